"""What every walk has and nobody hides: no rows of the table, fitted beside every cause.

Limbs that swing without a logged angular momentum, feet of some weight below their transducers, a
body that hangs on one foot after the other.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.body import heading_rad, level_share, scaled_in_body, turned_about_z
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Transform,
    columns_of,
    is_six_axis,
    on_known,
    on_wrenches,
    plus,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.spatial import cross


def _swung(log: Log, theta: Theta) -> FloatArray:
    known = log.known
    acc = scaled_in_body(known["com_acc_mps2"], log, level_share(theta, "limb_swing"))
    lever = (known["mass_kg"] * known["com_m"][:, 2])[:, None]
    return np.asarray(lever * np.stack([-acc[:, 1], acc[:, 0]], axis=1))


def middles_of_feet(log: Log) -> FloatArray | None:
    """Middles of the feet along the floor, shape (n, feet, 2)."""
    if is_six_axis(log.channels):
        return log.known["foot_pos_m"][..., :2] if "foot_pos_m" in log.known else None
    if "cell_pos_m" not in log.known:
        return None
    places = log.known["cell_pos_m"]
    own = columns_of(Scope.FOOT, log.channels)
    return np.stack([places[:, cells].mean(axis=1) for cells in own], axis=1)


_HARMONICS = 6


def _of_the_gait(log: Log, theta: Theta) -> FloatArray:
    if "gait_phase" not in log.known:
        return np.zeros((1, 2))
    phase = 2.0 * np.pi * log.known["gait_phase"]
    along = np.zeros((2, len(log)))
    for axis, course in zip("xy", along, strict=True):
        for k in range(1, _HARMONICS + 1):
            course += theta[f"gait_moment_{axis}_sin{k}"][0] * np.sin(k * phase)
            course += theta[f"gait_moment_{axis}_cos{k}"][0] * np.cos(k * phase)
    along = np.nan_to_num(along)  # no whole cycle
    return turned_about_z(np.vstack([along, np.zeros(len(log))]).T, heading_rad(log))[:, :2]


def _legs_swung(log: Log, theta: Theta) -> FloatArray:
    known, soles = log.known, middles_of_feet(log)
    if soles is None or "foot_acc_mps2" not in known:
        return np.zeros((1, 2))
    total = np.zeros((len(log), 2))
    for foot in range(soles.shape[1]):
        x, y = np.moveaxis(soles[:, foot] - known["com_m"][:, :2], -1, 0)
        acc = known["foot_acc_mps2"][:, foot] - known["com_acc_mps2"]
        down = theta["leg_swing"][foot] * known["com_m"][:, 2] + theta["leg_swing_below"][foot]
        up = theta["leg_swing"][foot] * acc[:, 2]
        total += np.stack([y * up + down * acc[:, 1], -down * acc[:, 0] - x * up], axis=1)
    return total


def _below(log: Log, theta: Theta) -> FloatArray:
    known = log.known
    if not {"foot_rot_wt", "foot_acc_mps2", "gravity_mps2"} <= known.keys():
        return np.zeros(1)
    specific = known["foot_acc_mps2"].copy()
    specific[..., 2] += known["gravity_mps2"][:, None]
    specific = np.einsum("nkji,nkj->nki", known["foot_rot_wt"], specific)
    first = np.stack([theta[f"moment_below_{axis}"] for axis in "xyz"], axis=-1)
    turning = cross(first, specific)
    return np.concatenate([theta["mass_below"][:, None] * specific, turning], axis=-1)


LIMB_SWING = Effect(
    name="limb_swing",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=tuple(
        EffectParameter(f"limb_swing_{axis}", "-", 0.0, -5.0, 5.0, 0.2) for axis in "xy"
    ),
    apply=on_known("angmom_rate_nm", plus(_swung, -1.0)),
    remove=on_known("angmom_rate_nm", plus(_swung)),
    experiments=("walk",),
    formula="L̇_shown = L̇ − m c_z R(heading) (−s_y c̈_y, s_x c̈_x)",
    source="Herr & Popovic, J. Exp. Biol. 211, 467 (2008): limbs swing against each other as the "
    "body is pushed",
    remedy="log the rate of angular momentum",
    needs=("angmom_missing",),
)
"""No row of the table: of logs without L̇, whose moments of the body's motion nobody knows."""


GAIT_MOMENT = Effect(
    name="gait_moment",
    stage=Stage.BODY,
    scope=Scope.ROBOT,
    parameters=tuple(
        EffectParameter(f"gait_moment_{axis}_{wave}{k}", "Nm", 0.0, -1e4, 1e4, 1.0)
        for axis in "xy"
        for k in range(1, _HARMONICS + 1)
        for wave in ("sin", "cos")
    ),
    apply=on_known("angmom_rate_nm", plus(_of_the_gait, -1.0)),
    remove=on_known("angmom_rate_nm", plus(_of_the_gait)),
    experiments=("walk",),
    formula="L̇_shown = L̇ − R(heading) Σ_k (a_k sin kφ + b_k cos kφ), φ the phase of the gait",
    source="Herr & Popovic, J. Exp. Biol. 211, 467 (2008): L̇ repeats, its mean is none",
    remedy="log the rate of angular momentum",
    needs=("angmom_missing", "gait_phase"),
)
"""Where a walk comes without L̇, its moments show their mean over the gait, and not their course."""

LEG_SWING = Effect(
    name="leg_swing",
    stage=Stage.BODY,
    scope=Scope.FOOT,
    parameters=(
        EffectParameter("leg_swing", "kg", 0.0, -100.0, 100.0, 1.0),
        EffectParameter("leg_swing_below", "kg·m", 0.0, -100.0, 100.0, 0.3),
    ),
    apply=on_known("angmom_rate_nm", plus(_legs_swung, -1.0)),
    remove=on_known("angmom_rate_nm", plus(_legs_swung)),
    experiments=("walk",),
    formula="L̇_shown = L̇ − Σ (m (p_foot − c) − b e_z) × (p̈_foot − c̈)",
    source="angular momentum of a leg between a hip that moves with the CoM and its foot",
    remedy="log the rate of angular momentum",
    needs=("angmom_missing", "foot_acc_mps2", "com_acc_mps2"),
)
"""Where a walk comes without L̇: two legs that swing have some, in proportion to their feet's."""


def _leg_mass(sign: float) -> Transform:
    def moved(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        known = log.known
        soles = middles_of_feet(log)
        if soles is None or not {"com_acc_mps2", "foot_acc_mps2"} <= known.keys():
            return log, state
        com, acc = known["com_m"].copy(), known["com_acc_mps2"].copy()
        for foot, sole in enumerate(np.moveaxis(soles, 1, 0)):
            share = sign * theta["leg_mass"][foot]
            com[:, :2] += share * (sole - known["com_m"][:, :2])
            acc += share * (known["foot_acc_mps2"][:, foot] - known["com_acc_mps2"])
        return log.with_known(com_m=com, com_acc_mps2=acc), state

    return moved


LEG_MASS = Effect(
    name="leg_mass",
    stage=Stage.BODY,
    scope=Scope.FOOT,
    parameters=(EffectParameter("leg_mass", "-", 0.0, -0.5, 0.5, 0.01),),
    apply=_leg_mass(1.0),
    remove=_leg_mass(-1.0),
    experiments=("walk",),
    formula="c = c₀ + Σ s (p_foot − c₀), its acceleration alike; s: share of the robot's mass",
    source="masses of a CAD model, off by some per cent",
    remedy="weigh the legs",
    needs=("com_acc_mps2", "foot_acc_mps2"),
)
"""No row of the table: no robot's links weigh what its model says."""

_BLUR_S = 0.03
"""Of what an estimator and a 10 Hz filter make of a step."""
_APART_S = 0.2


def _changes(log: Log) -> tuple[FloatArray, IntArray]:
    """When the demanded CoP passes from one foot's half of the way to the other's, and to which."""
    known = log.known
    soles = middles_of_feet(log)
    if soles is None or soles.shape[1] != 2:
        return np.empty(0), np.empty(0, dtype=np.int64)
    com, acc = known["com_m"], known["com_acc_mps2"]
    lever = com[:, 2] / np.maximum(known["gravity_mps2"] + acc[:, 2], 1.0)
    cop = com[:, :2] - lever[:, None] * acc[:, :2]
    way, middle = soles[:, 1] - soles[:, 0], soles.mean(axis=1)
    second = np.einsum("ni,ni->n", cop - middle, way) > 0.0
    at = np.flatnonzero(second[1:] != second[:-1]) + 1
    if at.size:
        at = at[np.diff(log.time_s[at], prepend=-np.inf) > _APART_S]
    return log.time_s[at], second[at].astype(np.int64)


def _change_of_foot(sign: float) -> Transform:
    def moved(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        if not {"com_acc_mps2", "com_m", "gravity_mps2"} <= log.known.keys():
            return log, state
        acc = log.known["com_acc_mps2"].copy()
        times, foot = _changes(log)
        for moment, onto in zip(times, foot, strict=True):
            rows = slice(*np.searchsorted(log.time_s, [moment - 5 * _BLUR_S, moment + 5 * _BLUR_S]))
            u = (log.time_s[rows] - moment) / _BLUR_S
            parts = (np.ones(u.size), u, u**2 - 1.0)
            wave = sum(theta[f"switch_{k}"][onto] * part for k, part in enumerate(parts))
            acc[rows, 2] += sign * np.exp(-0.5 * u**2) * wave
        return log.with_known(com_acc_mps2=acc), state

    return moved


CHANGE_OF_FOOT = Effect(
    name="change_of_foot",
    stage=Stage.BODY,
    scope=Scope.FOOT,
    parameters=tuple(
        EffectParameter(f"switch_{k}", "m/s²", 0.0, -50.0, 50.0, 0.05) for k in range(3)
    ),
    apply=_change_of_foot(1.0),
    remove=_change_of_foot(-1.0),
    experiments=("walk",),
    formula="a_z = a_z₀ + exp(−u²/2) (a₀ + a₁ u + a₂ (u² − 1)), u = (t − t_change) / 30 ms",
    source="leg odometry hangs the body on the foot with more load: its height and its velocity "
    "jump where that foot changes, and touch-downs are shorter than what differences show",
    remedy="take the acceleration from an inertial unit on the torso",
    needs=("com_acc_mps2",),
)
"""No row of the table: fitted beside every cause of a walk."""

FOOT_INERTIA = Effect(
    name="foot_inertia",
    stage=Stage.SIX_AXIS,
    scope=Scope.LEG,
    parameters=(
        EffectParameter("mass_below", "kg", 0.0, -20.0, 20.0, 0.1),
        *(EffectParameter(f"moment_below_{a}", "kg·m", 0.0, -5.0, 5.0, 0.01) for a in "xyz"),
    ),
    apply=on_wrenches(plus(_below, -1.0)),
    remove=on_wrenches(plus(_below)),
    experiments=("walk",),
    formula="f_measured = f − m s, τ_measured = τ − q × s, s = Rᵀ (a + g e_z) of the foot",
    source="Newton: a transducer drives what is mounted below it, and carries it in the air",
    remedy="give the weight below the transducer and its CoM to the recipe",
    needs=("foot_acc_mps2", "foot_rot_wt"),
)
"""No row of the table: every foot weighs something, and it is fitted beside every cause."""
