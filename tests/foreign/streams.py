"""What the loggers of a standing or walking biped write: cells, and the state estimator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.signal import savgol_filter

from tests.foreign.ankles import ankles, foot_attitude, sole_origins
from tests.foreign.biped import (
    FEET,
    GRAVITY_MPS2,
    Biped,
    angles_of,
    draw_biped,
    leg_points,
    link_centres,
)
from tests.foreign.files import Recorded
from tests.foreign.loggers import Drift, converted, looped, smoothed, transported, turned
from tests.foreign.motion import (
    FINE_HZ,
    Motion,
    angular_momentum,
    move,
    plan_stance,
    plan_walk,
    rate,
)
from tests.foreign.noise import Array, Rng, coloured, slow, stream

Distort = Callable[[Array, Array], Array]
"""Hidden cause: (time_s (n,), cell loads (n, 8) in N) -> loads that the cells show."""
PAUSE_S = 3.0
STAMP_LAG_S = 0.001


def walk(
    seed: int,
    *,
    seconds: float = 60.0,
    delay_s: float | None = None,
    stated_delay_s: float | None = None,
    turn_radps: float | None = None,
    distort: Distort | None = None,
) -> Recorded:
    """A walk on foot load cells.

    Parameters
    ----------
    delay_s : lateness of the body stream, drawn from 20–83 ms where not given
    stated_delay_s : what the recipe says of it; by default right but for `STAMP_LAG_S`
    turn_radps : of the path; drawn where not given
    distort : a hidden cause
    """
    robot, motion = draw_biped(seed), walked(seed, seconds, turn_radps)
    return _recorded(robot, [motion], stream(seed, "walk logged"), delay_s, stated_delay_s, distort)


def walked(seed: int, seconds: float = 60.0, turn_radps: float | None = None) -> Motion:
    """What the robot of `walk` did."""
    robot, rng = draw_biped(seed), stream(seed, "walk")
    return move(robot, plan_walk(robot, rng, seconds, turn_radps), rng)


def stand(
    seed: int,
    *,
    stances: int = 12,
    seconds_each: float = 4.0,
    delay_s: float | None = None,
    stated_delay_s: float | None = None,
    distort: Distort | None = None,
) -> Recorded:
    """Quiet stances with the feet placed anew; the loggers pause while the robot moves."""
    robot, motions = draw_biped(seed), stood(seed, stances, seconds_each)
    return _recorded(robot, motions, stream(seed, "stand logged"), delay_s, stated_delay_s, distort)


def stood(seed: int, stances: int = 12, seconds_each: float = 4.0) -> list[Motion]:
    """What the robot of `stand` did, stance by stance."""
    robot, rng = draw_biped(seed), stream(seed, "stand")
    step = seconds_each + PAUSE_S
    return [
        move(robot, plan_stance(robot, rng, seconds_each, i * step, i), rng) for i in range(stances)
    ]


def habits(
    robot: Biped, rng: Rng, delay_s: float | None = None
) -> tuple[float, float, float, float]:
    """Delay of the body stream (s), rates of cells and body (Hz), lost angular momentum."""
    kind = robot.kind
    delay = float(np.round(rng.uniform(0.02, 0.083), 3)) if delay_s is None else delay_s
    cells_hz, body_hz = float(rng.choice([80.0, 100.0])), float(rng.choice([100.0, 200.0]))
    loss = float(rng.uniform(0.15, 0.25))
    delay = kind.delay_s if delay_s is None and kind.delay_s is not None else delay
    loss = loss if kind.momentum_loss is None else kind.momentum_loss
    return delay, kind.cells_hz or cells_hz, kind.body_hz or body_hz, loss


def _recorded(
    robot: Biped,
    motions: list[Motion],
    rng: Rng,
    delay_s: float | None,
    stated_delay_s: float | None,
    distort: Distort | None,
) -> Recorded:
    kind = robot.kind
    delay, cells_hz, body_hz, loss = habits(robot, rng, delay_s)
    stated = delay if stated_delay_s is None else stated_delay_s
    show = ankles if kind.cells == 0 else _cells
    drift = Drift(robot, rng)
    cells = pd.concat(
        [show(robot, m, rng, cells_hz, distort, drift) for m in motions], ignore_index=True
    )
    seen = [body_stream(robot, m, rng, body_hz, loss) for m in motions]
    body = pd.concat([frame for frame, _ in seen], ignore_index=True)
    body["time_s"] += delay + STAMP_LAG_S
    cells, body = (transported(kind, table, rng) for table in (cells, body))
    time_s = np.concatenate([m.plan.time_s for m in motions])
    felt = np.concatenate([m.cells_n for m in motions])
    truth = {
        "parameters": robot.truth(),
        "mass_kg": robot.mass_kg,
        "delay_s": delay + STAMP_LAG_S,
        "stated_delay_s": stated,
        "angmom_loss": loss,
        "plate_kg": robot.plate_kg,
        "cell_sd_n": robot.sd_n,
        "drift_n": drift.last(len(motions) > 1),
        "com_error_m": np.concatenate([error for _, error in seen]).mean(axis=0),
        "cells_time_s": cells["time_s"].to_numpy(),
        "cells_n": np.stack([np.interp(cells["time_s"], time_s, c) for c in felt.T], axis=1),
    }
    late = {"delay_s": stated}
    commands = {"online_replay": late, "static_init": late, "diagnose": late}
    return Recorded({"cells": cells, "body": body}, robot.recipe(), truth, commands)


def _cells(
    robot: Biped, motion: Motion, rng: Rng, hz: float, distort: Distort | None, drift: Drift
) -> pd.DataFrame:
    """Counts: means over a few milliseconds, noise, a converter."""
    fine = motion.plan.time_s
    time_s = np.arange(fine[0] + 0.01, fine[-1] - 0.01, 1.0 / hz)
    window = np.ones(3) / 3.0
    felt = np.stack([np.convolve(c, window, "same") for c in motion.cells_n.T], axis=1)
    load = np.stack([np.interp(time_s, fine, c) for c in felt.T], axis=1)
    if distort is not None:
        load = distort(time_s, load)
    load = looped(load, robot.kind.hysteresis, robot.weight_n) + drift.at(time_s)
    load = load + robot.sd_n * coloured(rng, len(time_s), load.shape[1], 0.1 * hz)
    counts = converted(robot, robot.zero + load / robot.scale)
    return pd.DataFrame(
        {
            "time_s": np.round(time_s, 5),
            **{f"{c}_counts": counts[:, i] for i, c in enumerate(robot.channels)},
        }
    )


def body_stream(
    robot: Biped, motion: Motion, rng: Rng, hz: float, loss: float
) -> tuple[pd.DataFrame, Array]:
    """An ordinary state estimator: leg odometry on quantised joints, differences of positions.

    It knows lengths exactly and masses to a few per cent, its IMU leans by milliradians, a fifth
    of the angular momentum is missing. Also the error of its CoM over the feet, (n, 3).
    """
    every = round(FINE_HZ / hz)
    plan = motion.plan
    at = np.arange(0, len(plan.time_s), every)
    n = len(at)
    lean = robot.tilt_rad + 3e-4 * slow(rng, n, 2, 1.0 * hz)
    error = np.tile(np.eye(3), (n, 1, 1))
    error[:, 0, 2], error[:, 2, 0] = lean[:, 1], -lean[:, 1]
    error[:, 2, 1], error[:, 1, 2] = lean[:, 0], -lean[:, 0]
    attitude = error @ motion.attitude[at]
    hips = np.array([[0.0, robot.hip_m, 0.0], [0.0, -robot.hip_m, 0.0]])
    ankle_up = np.array([0.0, 0.0, robot.ankle_m])
    ankle = plan.feet_m[at] + ankle_up - motion.torso_m[at, None]
    true_leg = np.einsum("nji,nfj->nfi", motion.attitude[at], ankle) - hips
    knee, shown = leg_points(robot, angles_of(robot, true_leg).quantised(robot.encoder_rad))
    from_torso = np.einsum("nij,nfj->nfi", attitude, hips + shown)
    torso, feet = _odometry(from_torso, plan.share[at], plan.feet_m[at[0]] + ankle_up)
    links = link_centres(robot, torso, attitude, knee, shown)
    believed = robot.believed_masses_kg
    com = np.einsum("k,nki->ni", believed, links) / believed.sum()
    span = max(round(0.05 * hz) // 2 * 2 + 1, 5)

    def derive(values: Array) -> Array:
        return np.asarray(savgol_filter(values, span, 2, deriv=1, delta=1.0 / hz, axis=0))

    momentum = (1.0 - loss) * derive(angular_momentum(believed, links, com, derive))
    acc = derive(derive(com))
    kind = robot.kind
    span = max(round(kind.smooth_s * hz) // 2 * 2 + 1, 1)
    seen = [smoothed(values, span) for values in (com, acc, momentum)]
    angle = kind.yaw_drift_radps * plan.time_s[at]
    com_seen, acc, momentum = (turned(values, angle) for values in seen)
    soles = sole_origins(robot, feet, plan.yaw_rad[at], plan.pitch_rad[at])
    frame: dict[str, Array] = {"time_s": np.round(plan.time_s[at], 5)}
    specific = rate(rate(motion.torso_m))[at] + np.array([0.0, 0.0, GRAVITY_MPS2])
    felt = np.einsum("nji,nj->ni", motion.attitude[at], specific) + rng.normal(0, 0.05, (n, 3))
    for i, axis in enumerate("xyz"):
        frame[f"com_{axis}_m"] = com_seen[:, i]
        frame[f"com_acc_{axis}_mps2"] = acc[:, i]
        if axis != "z" and loss < 1.0:
            frame[f"angmom_rate_{axis}_nm"] = momentum[:, i]
        frame[f"imu_acc_{axis}_mps2"] = felt[:, i]
        frame[f"imu_gyro_{axis}_radps"] = rng.normal(0.0, 0.003, n)
        for side, foot in enumerate(FEET):
            frame[f"{foot}_foot_{axis}_m"] = turned(soles[:, side], angle)[:, i]
    for side, foot in enumerate(FEET):
        yaw = plan.yaw_rad[at, side] + rng.normal(0.0, 5e-4, n) + angle
        frame |= foot_attitude(robot, foot, yaw, plan.pitch_rad[at, side])
    over = (com - feet.mean(axis=1)) - (
        motion.com_m[at] - (plan.feet_m[at] + ankle_up).mean(axis=1)
    )
    return pd.DataFrame(frame), over


def _odometry(from_torso: Array, share: Array, start: Array) -> tuple[Array, Array]:
    """Torso and ankles in a world that hangs on the foot with more weight, (n, 3) and (n, 2, 3)."""
    stance = np.argmax(share, axis=1)
    torso = np.empty((len(share), 3))
    anchor = start[stance[0]]
    first = 0
    for last in [*(np.flatnonzero(np.diff(stance)) + 1), len(share)]:
        foot = stance[first]
        torso[first:last] = anchor - from_torso[first:last, foot]
        if last < len(share):
            anchor = torso[last - 1] + from_torso[last - 1, stance[last]]
            anchor = np.array([anchor[0], anchor[1], start[0, 2]])
        first = last
    return torso, torso[:, None] + from_torso
