"""Rows of a walk on feet with six-axis transducers: offset and scale per axis.

``w = (1 + γ) reading − offset`` per axis. Total force and horizontal moments about the CoM balance
the motion of the body; a swinging foot weighs what hangs below its transducer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.contact import cycle_phase
from footcal_cli.core.effects.body import heading_rad
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.transport import DELAY
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.reference_states import advanced
from footcal_cli.core.online.replay import held_until_next
from footcal_cli.core.online.rows import Rows, block_means, by_neighbours, updates_of
from footcal_cli.core.parameters import BoolArray, ComplexArray, FloatArray
from footcal_cli.core.spatial import in_heading

KNOWN_MOTION = 0.05
"""Sd of the size of a body's horizontal motion and of the moments it takes, as a share of them: a
scale that both feet share on an axis and a motion of another size are one thing. Light limbs,
masses of links from a drawing and differences over a window leave ordinary estimators so far off.
"""
PRIOR_SD: Mapping[str, tuple[str, float]] = {
    "offset_f": ("N", 30.0),
    "offset_t": ("Nm", 5.0),
    "scale": ("-", 0.03),
    "mass_correction": ("kg", 7.0),
    "com_correction": ("m", 0.02),
    "weight": ("N", 3.0),
    "com_below": ("m", 0.05),
    DELAY.name: ("s", 0.01),
    "motion_size": ("-", KNOWN_MOTION),
    "angmom_loss": ("-", 0.2),
    "angmom_share": ("-", 0.5),
}
"""Kind of unknown -> unit and prior sd: transducers zeroed at an unknown time; the mass is taken to
a share of itself."""
_MASS_SHARE = 0.1
"""Prior sd of the mass as a share of it, where scales are not free. Models of humanoids leave out
cables, covers and batteries."""
BELOW_SHARE, _SURE_N = 0.0045, 1e-3
"""Sd of what is stated to hang below a transducer by the robot's weight; below a plate is none."""
KNOWN_MASS = 0.002
"""Sd of a mass that is taken as known, as a share of it: all scales together are as unsure."""
KNOWN_SWING = 0.05
"""Sd of the size of a foot's acceleration in the air, as a share of it: the weight below a
transducer is seen by it."""
_DELAY_STEP_S = 2e-3
DELAY_STATE, MASS_STATE = "robot.delay", "robot.mass_correction"
_PHASES = 40
_HORIZONTAL = ((0, 1), (3, 4))
TORQUE_ARM_M = 0.05
"""A torque row's noise over a force row's."""


def six_axis_rows(
    log: Log,
    *,
    samples_per_update: int = 2,
    scales: bool = True,
    mass: bool = False,
    walking: bool = True,
    prior_sd: Mapping[str, float] | None = None,
) -> Rows:
    """Rows of a walk with six-axis feet, averaged over blocks of samples.

    Parameters
    ----------
    log
        Walk with wrenches as logged and `footcal_cli.core.experiments.walk.SIX_AXIS_KNOWN`; what is
        `carried_over` from stances by a filter is taken off feet in the air.
    samples_per_update
        Samples averaged to one block.
    scales
        Whether the scale of each axis is unknown; otherwise only offsets are.
    mass
        Whether the mass is unknown. With free scales it is known: a common scale and the mass are
        the same thing, and forces that all shrink together would shrink their noise as well.
    walking
        Whether the body moves: only then a delay and the CoM below a transducer are unknowns.
    prior_sd
        Prior sd of kinds of unknowns where they differ from `PRIOR_SD`.
    """
    sd = {kind: spec[1] for kind, spec in PRIOR_SD.items()}
    sd["mass_correction"] = _MASS_SHARE * float(np.mean(log.known["mass_kg"]))
    sd |= dict(prior_sd or {})
    feet = walk.feet_of(log)
    names, units, scale = [], [], []

    def add(name: str, kind: str) -> None:
        names.append(name)
        units.append(PRIOR_SD[kind][0])
        scale.append(sd[kind])

    for foot in feet:
        for axis in AXES:
            add(f"{foot}.offset_{axis}", f"offset_{axis[0]}")
    for foot in feet if scales else ():
        for axis in AXES:
            add(f"{foot}.scale_{axis}", "scale")
    if mass:
        add(MASS_STATE, "mass_correction")
    add("robot.com_correction_x", "com_correction")
    add("robot.com_correction_y", "com_correction")
    weight_sd = log.known.get("foot_weight_sd_n", np.full((1, len(feet)), sd["weight"]))[0]
    for foot, own in zip(feet, weight_sd.tolist(), strict=True):
        add(f"{foot}.weight", "weight")
        scale[-1] = max(own, _SURE_N)
    for foot in feet if walking else ():
        for axis in "xyz":
            add(f"{foot}.com_below_{axis}", "com_below")
    blocks = updates_of(log, samples_per_update)
    used = log.rows(0, blocks * samples_per_update)
    balance = walk.six_axis_balance(used)
    h = _columns(used, scales, mass, samples_per_update)[:, :, : len(names)]
    for state, column in (
        _of_the_motion(used, scales, samples_per_update).items() if walking else ()
    ):
        add(f"robot.{state}", state.removesuffix("_x").removesuffix("_y"))
        h = np.concatenate([h, column[:, :, None]], axis=2)
    error, valid, h = in_heading(
        balance.error, balance.valid, h * np.array(scale), _HORIZONTAL, heading_rad(used)
    )
    error[:, len(walk.SIX_AXIS_TOTALS) :] -= used.known.get("carried_over", 0.0)
    h, error, valid = block_means(error, valid, h, samples_per_update)
    last = np.arange(1, blocks + 1) * samples_per_update - 1
    return Rows(
        time_s=log.time_s[last],
        names=tuple(names),
        units=tuple(units),
        prior_sd=np.array(scale),
        prior_correlation=np.eye(len(names)),
        outputs=balance.outputs,
        totals=len(walk.SIX_AXIS_TOTALS),
        h=h,
        error=error,
        valid=valid,
        last_sample=last,
        swing_sd_factor=np.tile([1.0, 1.0, 1.0] + [TORQUE_ARM_M] * 3, len(feet)),
    )


def _columns(log: Log, scales: bool, mass: bool, size: int) -> FloatArray:
    """``∂error/∂unknown`` of every row, shape (n, k, p), in physical units; `size` of a block."""
    known = log.known
    rot, pos = known["foot_rot_wt"], known["foot_pos_m"]
    n, feet = rot.shape[:2]
    wrench = by_neighbours(log.readings, size).reshape(n, feet, 6)
    arms = pos - known["com_m"][:, None]
    totals = len(walk.SIX_AXIS_TOTALS)
    carriers = 6 * feet * (1 + scales) + mass
    h = np.zeros((n, totals + 6 * feet, carriers + 2 + 4 * feet))
    below = walk.applied_below(log, np.ones((n, feet)))
    carried = walk.applied_below(_still(log), known["foot_weight_n"])
    in_the_air = carried + _unloaded(log)[None]
    for k in range(feet):
        unit = _total_of_axes(rot[:, k], arms[:, k])
        rows = totals + 6 * k + np.arange(6)
        h[:, :totals, 6 * k : 6 * k + 6] = -unit
        h[:, rows, 6 * k + np.arange(6)] = -1.0
        if scales:
            at = 6 * (feet + k) + np.arange(6)
            h[:, :totals, at] = unit * wrench[:, None, k]
            h[:, rows, at] = in_the_air[:, k]
        # one newton more below the transducer is one newton less that it must be given
        hanging = below[:, k]
        at_weight = carriers + 2 + k
        h[:, :totals, at_weight] = -np.einsum("nij,nj->ni", unit, hanging)
        h[:, totals + 6 * k : totals + 6 * k + 6, at_weight] = -hanging
        at_com = carriers + 2 + feet + 3 * k
        pull = known["foot_weight_n"][:, k, None] * hanging[:, :3]
        for i in range(3):
            lever = np.cross(np.eye(3)[i], pull)
            h[:, :totals, at_com + i] = -np.einsum("nij,nj->ni", unit[:, :, 3:], lever)
            h[:, totals + 6 * k + 3 : totals + 6 * k + 6, at_com + i] = -lever
    # Mass and CoM act through gravity alone: regressed on an acceleration that is itself measured
    # they would be pulled towards zero, and the offsets would take up the weight.
    if mass:
        h[:, 2, carriers - 1] = -known["gravity_mps2"]
    weight, yaw = known["mass_kg"] * known["gravity_mps2"], heading_rad(log)
    h[:, 4, carriers], h[:, 3, carriers] = weight * np.cos(yaw), -weight * np.sin(yaw)
    h[:, 4, carriers + 1], h[:, 3, carriers + 1] = -weight * np.sin(yaw), -weight * np.cos(yaw)
    return np.nan_to_num(h)


def _of_the_motion(log: Log, scales: bool, size: int) -> dict[str, FloatArray]:
    """What may be wrong with the motion -> ``∂error/∂state``, shape (n, k).

    Sizes come from the forces measured where they can: the noise of the demand stands in the error,
    and a size regressed on it is pulled towards −1. A motion whose demand is too poor for scales
    has no sizes either. Where a stream has no angular momentum, limbs still swing as the body
    is pushed: ``(L̇ʸ, −L̇ˣ) = s m cᶻ c̈``, a share s of the moment of the horizontal force, one along
    and one across the heading.
    """
    balances = [
        walk.six_axis_balance(advanced(log, sign * _DELAY_STEP_S)).error for sign in (1.0, -1.0)
    ]
    columns = {DELAY.name: np.nan_to_num((balances[0] - balances[1]) / (2.0 * _DELAY_STEP_S))}
    if not scales:
        return columns
    motion = _horizontal_motion(log, size)
    for axis, part in zip("xy", motion, strict=True):
        columns[f"motion_size_{axis}"] = _on_totals(log, force=-part)
    if log.known["angmom_rate_nm"].any():
        columns["angmom_loss"] = _on_totals(log, moment=-_repeating(log))
    else:
        height = log.known["com_m"][:, 2, None]
        for axis, part in zip("xy", motion, strict=True):
            moment = height * part[:, ::-1] * [1.0, -1.0]
            columns[f"angmom_share_{axis}"] = _on_totals(log, moment=moment)
    return columns


def _on_totals(
    log: Log, *, force: FloatArray | float = 0.0, moment: FloatArray | float = 0.0
) -> FloatArray:
    """A column that moves the horizontal forces and moments alone, each (n, 2); shape (n, k)."""
    column = np.zeros((len(log), len(walk.SIX_AXIS_TOTALS) + log.readings.shape[1]))
    column[:, :2], column[:, 3:5] = force, moment
    return np.nan_to_num(column)


def _still(log: Log) -> Log:
    """The log with feet that are not accelerated."""
    return log.with_known(foot_acc_mps2=np.zeros_like(log.known["foot_acc_mps2"]))


def shared_errors(log: Log, names: Sequence[str], values: FloatArray) -> FloatArray:
    """Errors of one sd that all estimates have in common and no balance shows, shape (m, p).

    - The mass: scales, and offsets, which are readings without load times their scales.
    - The size of the angular momentum: the same for torques about each horizontal axis.
    - The size of a foot's acceleration: the weight below it, its lever, and offsets in the air.
    """
    shared = np.zeros((4, len(names)))
    at = {name: i for i, name in enumerate(names)}
    feet = walk.feet_of(log)
    hanging = walk.applied_below(_still(log), np.ones((len(log), len(feet))))
    airborne = _airborne(log)
    for k, foot in enumerate(feet):
        for axis in AXES:
            offset, scale = at[f"{foot}.offset_{axis}"], at.get(f"{foot}.scale_{axis}")
            if scale is not None:
                mass = np.array([KNOWN_MASS, *KNOWN_MOTION * (np.array(["tx", "ty"]) == axis), 0.0])
                shared[:, scale] = mass
                shared[:, offset] = mass * values[offset]
        weight = KNOWN_SWING * float(log.known["foot_weight_n"][0, k])
        shared[3, at[f"{foot}.weight"]] = weight
        for axis, lever in zip("xyz", log.known["foot_com_m"][0, k], strict=True):
            name = f"{foot}.com_below_{axis}"
            shared[3, at[name]] = -KNOWN_SWING * (lever + values[at[name]])
        if airborne[:, k].any():
            own = [at[f"{foot}.offset_{axis}"] for axis in AXES]
            shared[3, own] = -weight * np.median(hanging[airborne[:, k], k], axis=0)
    return shared


def _repeating(log: Log) -> FloatArray:
    """The part of the rate of angular momentum that repeats in every gait cycle, (n, 2).

    In the heading's axes, the mean over all cycles at that phase: it has little of the noise that
    a differentiated stream adds to the error as well.
    """
    along = _in_heading(log, log.known["angmom_rate_nm"])
    phase = cycle_phase(log.known["contact"])
    whole = np.isfinite(phase)
    at = np.minimum((phase[whole] * _PHASES).astype(int), _PHASES - 1)
    count = np.maximum(np.bincount(at, minlength=_PHASES), 1)
    mean = np.zeros(len(log), dtype=complex)
    sums = [np.bincount(at, part[whole], _PHASES) for part in (along.real, along.imag)]
    mean[whole] = ((sums[0] + 1j * sums[1]) / count)[at]
    return _in_world(log, mean)


def _horizontal_motion(log: Log, size: int) -> tuple[FloatArray, FloatArray]:
    """The body's horizontal ``m c̈``, as measured: parts along and across its heading, (n, 2).

    By the readings that scales are regressed on: a scale that all feet share and a motion of
    another size are then one thing to the filter too, and their priors share it out.
    """
    readings = by_neighbours(log.readings, size) - _unloaded(log).ravel()
    balance = walk.six_axis_balance(log.with_readings(readings))
    force = balance.error[:, :2] + log.known["mass_kg"][:, None] * log.known["com_acc_mps2"][:, :2]
    along = _in_heading(log, force)
    return _in_world(log, along.real + 0j), _in_world(log, (along - along.conj()) / 2)


def _in_heading(log: Log, vector: FloatArray) -> ComplexArray:
    """A horizontal vector (n, 2) as along + i across the heading, shape (n,)."""
    return np.asarray((vector[:, 0] + 1j * vector[:, 1]) * np.exp(-1j * heading_rad(log)))


def _in_world(log: Log, along: ComplexArray) -> FloatArray:
    """Back: shape (n, 2)."""
    turned = along * np.exp(1j * heading_rad(log))
    return np.stack([turned.real, turned.imag], axis=1)


def _airborne(log: Log) -> BoolArray:
    """Which feet surely swing, shape (n, feet)."""
    return np.asarray(log.known["contact"] == 0.0)


def _unloaded(log: Log) -> FloatArray:
    """What each foot reads in the air beside the weight below, shape (feet, 6): its offsets.

    With it a foot in the air has the regressor of its scales. Its own reading would not do: the
    noise stands in the error as well, and a scale regressed on it is pulled towards −1 where
    little but noise is read.
    """
    airborne = _airborne(log)
    carried = walk.applied_below(_still(log), log.known["foot_weight_n"])
    wrench = log.readings.reshape(carried.shape) - carried
    return np.stack(
        [
            np.median(wrench[airborne[:, k], k], axis=0) if airborne[:, k].any() else np.zeros(6)
            for k in range(wrench.shape[1])
        ]
    )


def _total_of_axes(rot: FloatArray, arm: FloatArray) -> FloatArray:
    """What one unit on each axis adds to (fx, fy, fz, mx, my) in the world, shape (n, 5, 6)."""
    total = np.zeros((len(rot), 5, 6))
    total[:, :3, :3] = rot
    total[:, 3:, 3:] = rot[:, :2]
    turned = np.cross(arm[:, None, :], rot.transpose(0, 2, 1))
    total[:, 3:, :3] = turned.transpose(0, 2, 1)[:, :2]
    return total


def corrected_log(log: Log, names: Sequence[str], track: Track, rows: Rows) -> Log:
    """The log with all that a track has found taken out, sample by sample."""
    log = advanced(log, float(track.values[-1, names.index(DELAY_STATE)]))
    n = len(log)
    values = held_until_next(rows.last_sample, track.values, n)
    # what was not yet known at the very start is what the first update says
    values[: rows.last_sample[0]] = track.values[0]
    column = {name: values[:, i] for i, name in enumerate(names)}
    feet = walk.feet_of(log)
    readings = log.readings.copy()
    for k, foot in enumerate(feet):
        for j, axis in enumerate(AXES):
            at = 6 * k + j
            scale = column.get(f"{foot}.scale_{axis}", np.zeros(n))
            readings[:, at] = (1.0 + scale) * readings[:, at] - column[f"{foot}.offset_{axis}"]
    com = log.known["com_m"].copy()
    ahead, aside = (column[f"robot.com_correction_{axis}"] for axis in "xy")
    com[:, :2] += _in_world(log, ahead + 1j * aside)
    zero, push = np.zeros(n), log.known["com_acc_mps2"].copy()

    def shared_out(state: str) -> FloatArray:
        """Shares along and across the heading of a horizontal acceleration, (n, 2)."""
        own, other = (column.get(f"robot.{state}_{axis}", zero) for axis in "xy")
        along = _in_heading(log, push)
        return _in_world(log, own * along.real + 1j * other * along.imag)

    push[:, :2] += shared_out("motion_size")
    limbs = (log.known["mass_kg"] * com[:, 2])[:, None] * shared_out("angmom_share")
    momentum = log.known["angmom_rate_nm"] * (1.0 + column.get("robot.angmom_loss", zero))[:, None]
    momentum = momentum + np.stack([-limbs[:, 1], limbs[:, 0]], axis=1)
    weight = log.known["foot_weight_n"] + np.stack(
        [column[f"{foot}.weight"] for foot in feet], axis=1
    )
    hanging = np.stack(
        [np.stack([column[f"{foot}.com_below_{axis}"] for axis in "xyz"], -1) for foot in feet], 1
    )
    return log.with_readings(readings).with_known(
        com_m=com,
        com_acc_mps2=push,
        angmom_rate_nm=momentum,
        mass_kg=log.known["mass_kg"] + column.get(MASS_STATE, np.zeros(n)),
        foot_weight_n=weight,
        foot_com_m=log.known["foot_com_m"] + hanging,
    )
