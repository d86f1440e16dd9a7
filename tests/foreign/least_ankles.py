"""Least errors of walks and stands on six-axis ankles, as `tests.foreign.least` has them for cells.

*Load known*: every wrench on a transducer is known. *With the estimator*: the force of the whole
robot and its moments about both horizontal axes as its estimator says them; a foot in the air
carries itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from tests.foreign.ankles import AXES, UNITS, ankles, sole
from tests.foreign.biped import FEET, GRAVITY_MPS2, Biped, draw_biped
from tests.foreign.drawn import ANKLE_GAIN_SD, BELOW_SHARE, MASS_SD
from tests.foreign.least import (
    AGAIN,
    demanded,
    estimators,
    information,
    rolled,
    white_and_slow,
)
from tests.foreign.motion import FINE_HZ, Motion, rate
from tests.foreign.noise import Array, Rng, stream
from tests.foreign.streams import body_stream, habits, stood, walked

_FEW, _EXACT = 1e-3 / np.sqrt(12.0), 1e-9
"""A CoM below an ankle is stated in millimetres; what is exact in this world."""
_EACH = 16
"""Unknowns of a foot: offsets (6), gains (6), weight below and its CoM (3)."""


@dataclass(frozen=True)
class Wrenches:
    """One recording on the clock of its body stream, in pieces of n samples.

    Parameters
    ----------
    shown : (pieces, n, 2, 6) readings without noise: wrenches and offsets, both times a gain
    below : (pieces, n, 2, 6, 4) per relative weight below them and per metre of its CoM
    on : (pieces, n, 2) whether a foot stands
    lever : (pieces, n, 5, 2, 6) of readings: force, and moments about the middle of the feet
    whole : (pieces, n, 5)
    sd : (6,) of the channels' noise; power : (n,) of noise of one sd
    off : (again, pieces, n, 5)
    """

    shown: Array
    below: Array
    on: Array
    lever: Array
    whole: Array
    sd: Array
    power: Array
    off: Array


def least_ankles(seed: int, task: str) -> dict[str, list[list[float]]]:
    """Kind of value -> least sd of each, load known and with the estimator, as errors are listed.

    What this world has exact, and loads that are known where weights are asked for, have none.
    """
    what = "walk" if task.startswith("online") else "stand"
    robot, rows = draw_biped(seed), wrenches_of(seed, what)
    gain = ANKLE_GAIN_SD[what] if task.endswith("off") else _EXACT
    stated = task == "static-init, ankles off"
    weight = robot.below_kg * GRAVITY_MPS2
    offset = robot.weight_n * np.array([0.03] * 3 + [0.006 * robot.leg_m] * 3)
    part = BELOW_SHARE * robot.weight_n / weight if stated else 0.02
    prior = np.concatenate([offset, [gain] * 6, [part], [_FEW] * 3])
    power = rows.power[:, None, None]
    alone = np.zeros((len(FEET), 6, 2))
    for foot in range(len(FEET)):
        for c in range(6):
            seen = np.diag([prior[c] ** -2, gain**-2])
            for piece in rows.shown[:, :, foot, c]:
                columns = np.column_stack([np.ones_like(piece), piece])
                seen = seen + information(columns[:, None], power * rows.sd[c] ** 2)
            alone[foot, c] = np.sqrt(np.diag(np.linalg.inv(seen)))
    sd = _with_estimator(rows, prior, MASS_SD if stated else 0.0)
    found: dict[str, list[list[float]]] = {}
    nothing = float("nan")
    for foot in range(len(FEET)):
        for c, axis in enumerate(AXES):
            kind = "force offset" if axis[0] == "f" else "torque offset"
            found.setdefault(kind, []).append([alone[foot, c, 0], sd[foot, c]])
        for i in range(3):
            found.setdefault("leg CoM", []).append([nothing, sd[foot, 13 + i]])
        found.setdefault("weight", []).append([nothing, sd[foot, 12] * weight])
        if gain != _EXACT:
            own = zip(alone[foot, :, 1], sd[foot, 6:12], strict=True)
            found.setdefault("scale", []).extend([a, b] for a, b in own)
    return found


def _with_estimator(rows: Wrenches, prior: Array, mass_sd: float) -> Array:
    """Least sd (2, 16) of the unknowns of both feet."""
    pieces, n = rows.on.shape[:2]
    own = np.zeros((pieces, n, len(FEET), 6, _EACH))
    own[..., np.arange(6), np.arange(6)] = 1.0
    own[..., np.arange(6), 6 + np.arange(6)] = rows.shown
    own[..., 12:] = rows.below
    felt = own * rows.on[..., None, None]
    columns = np.einsum("snrfc,snfcp->snrfp", rows.lever, felt).reshape(pieces, n, 5, -1)
    mass = rows.whole[..., None] * (1.0 if mass_sd else 0.0)
    carried = (rows.lever * rows.on[:, :, None, :, None] * rows.sd).reshape(pieces, n, 5, -1)
    precision = np.diag(prior**-2.0)
    total = block_diag(precision, precision, np.array([[mass_sd**-2 if mass_sd else 1.0]]))
    columns = np.concatenate([columns, -mass], axis=3)
    total += demanded(columns, carried, rows.power, rows.off)
    power = rows.power[:, None, None]
    for foot in range(len(FEET)):
        at = slice(_EACH * foot, _EACH * (foot + 1))
        for piece, on in zip(own[:, :, foot], rows.on[:, :, foot], strict=True):
            for c in range(6):
                idle = piece[:, c] * (1.0 - on)[:, None]
                total[at, at] += information(idle[:, None], power * rows.sd[c] ** 2)
    sd = np.sqrt(np.diag(np.linalg.inv(total))[:-1])
    return np.asarray(sd.reshape(len(FEET), _EACH))


@cache
def wrenches_of(seed: int, what: str, again: int | None = None) -> Wrenches:
    """Of a `walk` or a `stand`."""
    robot = draw_biped(seed)
    motions = [walked(seed)] if what == "walk" else stood(seed)
    _, cells_hz, hz, loss = habits(robot, stream(seed, f"{what} logged"))
    every = round(FINE_HZ / hz)
    hz = FINE_HZ / every
    parts = [_piece(robot, motion, every) for motion in motions]
    shown, below, on, lever, whole = (np.stack(one) for one in zip(*parts, strict=True))
    drawn = estimators(robot, seed, loss, again or AGAIN[what])
    return Wrenches(
        shown, below, on, lever, whole,
        robot.sd_n * np.array([1.0] * 3 + [0.1 * robot.leg_m] * 3),
        white_and_slow(1.0, on.shape[1], cells_hz, hz, 0.0),
        np.stack([
            np.stack([_off(one, motion, rng, hz, lost) for motion in motions])
            for one, rng, lost in drawn
        ]),
    )  # fmt: skip


def _piece(robot: Biped, motion: Motion, every: int) -> tuple[Array, Array, Array, Array, Array]:
    """`Wrenches` of one motion, without noise."""
    plan = motion.plan
    at = slice(None, None, every)
    silent = ankles(replace(robot, sd_n=0.0), motion, stream(0, "twist"), FINE_HZ, None, None)
    names = [f"{foot}_{a}_{u}" for foot in FEET for a, u in zip(AXES, UNITS, strict=True)]
    shown = np.stack(
        [np.interp(plan.time_s[at], silent["time_s"], silent[name]) for name in names], axis=1
    )
    up = np.array([0.0, 0.0, robot.ankle_m])
    place = plan.feet_m + up
    middle = plan.feet_m.mean(axis=1)
    n = len(plan.time_s)
    lever, below = np.zeros((n, 5, len(FEET), 6)), np.zeros((n, len(FEET), 6, 4))
    for side in range(len(FEET)):
        turn = sole(robot, plan.yaw_rad[:, side], plan.pitch_rad[:, side])
        axes, arm = turn.as_matrix(), np.array(robot.com_below_m)
        lever[:, :3, side, :3] = axes
        across = np.cross((place[:, side] - middle)[:, None], axes.swapaxes(1, 2)).swapaxes(1, 2)
        lever[:, 3:, side, :3], lever[:, 3:, side, 3:] = across[:, :2], axes[:, :2]
        specific = rate(rate(place[:, side] + turn.apply(arm))) + np.array([0, 0, GRAVITY_MPS2])
        pull = -robot.below_kg * turn.inv().apply(specific)
        below[:, side, :3, 0], below[:, side, 3:, 0] = pull, np.cross(arm, pull)
        for i, axis in enumerate(np.eye(3)):
            below[:, side, 3:, 1 + i] = np.cross(axis, pull)
    on = (plan.share[at] > 0.0).astype(float)
    return shown.reshape(-1, len(FEET), 6), below[at], on, lever[at], _true(robot, motion)[at]


def _true(robot: Biped, motion: Motion) -> Array:
    middle = motion.plan.feet_m.mean(axis=1)
    turning = np.column_stack([motion.angmom_rate_nm, np.zeros(len(middle))])
    return _whole(robot, motion.com_m - middle, motion.com_acc_mps2, turning)


def _whole(robot: Biped, arm: Array, acc: Array, turning: Array) -> Array:
    """Force of the ground and its moments about a point (n, 5): Newton and Euler."""
    force = robot.mass_kg * (acc + np.array([0.0, 0.0, GRAVITY_MPS2]))
    return np.hstack([force, (np.cross(arm, force) + turning)[:, :2]])


def _off(robot: Biped, motion: Motion, rng: Rng, hz: float, loss: float) -> Array:
    """What an estimator demands less what is true, (n, 5)."""
    frame, _ = body_stream(robot, motion, rng, hz, loss)
    plan, every = motion.plan, round(FINE_HZ / hz)
    at = slice(None, None, every)

    def vector(pattern: str, axes: str = "xyz") -> Array:
        return np.asarray(frame[[pattern.format(axis) for axis in axes]].to_numpy())

    soles = np.stack([vector(f"{foot}_foot_{{}}_m") for foot in FEET], axis=1)
    quats = [vector(f"{foot}_foot_q{{}}", "xyzw") for foot in FEET]
    up = np.array([0.0, 0.0, robot.ankle_m])
    seen = soles + np.stack([Rotation.from_quat(q).apply(up) for q in quats], axis=1)
    middle = seen.mean(axis=1) - up
    turning = np.zeros((len(frame), 3))
    if "angmom_rate_x_nm" in frame:
        turning[:, :2] = vector("angmom_rate_{}_nm", "xy")
    wanted = _whole(robot, vector("com_{}_m") - middle, vector("com_acc_{}_mps2"), turning)
    whole = _true(robot, motion)[at]
    moved = (seen - middle[:, None]) - (plan.feet_m + up - plan.feet_m.mean(axis=1)[:, None])[at]
    moved[..., :2] -= rolled(robot, motion, rng, every)
    push = plan.share[at, :, None] * whole[:, None, :3]
    across = np.cross(moved, push).sum(axis=1)[:, :2]
    return np.asarray(wanted - whole - np.hstack([np.zeros((len(across), 3)), across]))
