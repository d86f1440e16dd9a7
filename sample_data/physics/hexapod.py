"""Measured-like truth for hang-calib and pose-calib, from a physics engine.

Five logs of one hexapod (see `hexapod_model` for frames and signs): hanging four ways, standing
in several hundred poses, standing on tripods, standing still between transitions, and walking.
Every wrench is what an ideal transducer would feel: no offset, no noise, no gain error.  The
calibration's own equations make nothing here; `check_balance` only asks whether they hold.

Run ``python sample_data/physics/hexapod.py --out DIR [--seed N]`` to write all logs and the truth.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from hexapod_model import (
    CONVENTIONS,
    GRAVITY_MPS2,
    LEGS,
    TIME_STEP_S,
    Array,
    Hexapod,
    Reading,
    Rig,
    draw_hexapod,
)
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

WRENCH = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"]
QUAT = ["body_qx", "body_qy", "body_qz", "body_qw"]
GROUND = [f"ground_{axis}_w_{unit}" for axis, unit in (name.split("_") for name in WRENCH)]
#: Body axis along gravity per orientation.  Left transducers see it along the axis of that name,
#: right ones (turned by pi about z) see +x as -x and -x as +x; z is the same for all.
ORIENTATIONS = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+z": (0, 0, 1), "-z": (0, 0, -1)}
STANCE_RAD = np.deg2rad(36.0)
LEFT_TRIPOD = np.array([leg in ("fl", "mr", "hl") for leg in LEGS])
LEFT_SIDE = np.array([leg.endswith("l") for leg in LEGS])

HANG_RATE_HZ = 0.05
MOVE_S = 0.8
WALK_RATE_HZ = 0.08
WALK_DUTY = 0.55
#: Half difference of the stance sweep, left over right: turns the walk to the right (rad).
WALK_STEER_RAD = 0.11


@dataclass(frozen=True)
class HangLog:
    """One hanging log and what was true of it.

    Attributes
    ----------
    table
        Columns `orientation`, `time_s`, `leg`, `phase_rad`, `fx_n` ... `tz_nm`.
    tilt_rotvec_rad
        Rotation that took gravity, in body axes, away from the orientation's axis, shape (3,).
    gravity_dir_t
        Unit vector of gravity in each true transducer frame, shape (6, 3), rows as `LEGS`.
    """

    table: pd.DataFrame
    tilt_rotvec_rad: Array
    gravity_dir_t: Array


def hang(
    robot: Hexapod, orientation: str, seed: int, cycles: int = 10, tilt_sd_rad: float = 0.035
) -> HangLog:
    """Hang the robot in the air, legs turning slowly through `cycles` turns, read at 20 Hz.

    The chassis is held; each leg starts at its own phase, the same in all four orientations.

    Parameters
    ----------
    orientation
        A key of `ORIENTATIONS`: the nominal axis of a left transducer along gravity.
    seed
        Draws the tilt (different in each orientation) and the phases at the start.
    tilt_sd_rad
        Spread of the tilt about each of the two horizontal axes.
    """
    index = list(ORIENTATIONS).index(orientation)
    axis = np.array(ORIENTATIONS[orientation], dtype=float)
    draw = tilt_sd_rad * np.random.default_rng([seed, 2, index]).standard_normal(3)
    tilt = draw - (draw @ axis) * axis
    gravity_dir_b: Array = Rotation.from_rotvec(tilt).as_matrix() @ axis
    start = np.random.default_rng([seed, 3]).uniform(0.0, 2 * np.pi, len(LEGS))
    rate = 2 * np.pi * HANG_RATE_HZ
    rig = Rig(robot, gravity_dir_b, start - rate, rate)
    _run(rig, 1.0, lambda t: start + rate * (t - 1.0))
    readings = _run(rig, cycles / HANG_RATE_HZ, lambda t: start + rate * t, every=50)
    table = _table(readings, orientation=np.full(len(readings), orientation))
    return HangLog(
        table=table[["orientation", "time_s", "leg", "phase_rad", *WRENCH]],
        tilt_rotvec_rad=tilt,
        gravity_dir_t=np.stack([leg.rot_bt.T @ gravity_dir_b for leg in robot.legs]),
    )


def stand(robot: Hexapod, poses: int, seed: int) -> pd.DataFrame:
    """Stand in `poses` of the 3**6 poses of [Wu], section I-B, one after the other.

    Feet stay on the floor from pose to pose, so friction leaves internal forces.  Columns `pose`,
    `leg`, `phase_rad`, `fx_n` ... `tz_nm`, `body_qx` ... `body_qw`, `contact`, and the wrench of
    the ground on the foot in the floating-base frame: `ground_fx_w_n` ... `ground_tz_w_nm` (see
    `Reading.ground_wrench_w`).
    """
    targets = _draw_poses(poses, np.random.default_rng([seed, 4]))
    rig = Rig(robot, phase_rad=targets[0])
    readings = [_hold(rig, target, settle_s=2.0) for target in targets]
    return _table(readings, pose=np.arange(poses)).drop(columns="time_s")


def stand_tripod(robot: Hexapod, stances: int, seed: int) -> pd.DataFrame:
    """Stand on three legs, the other tripod lifted; columns as `stand`.

    Half of the stances stand on each tripod; the lifted shafts are near pi, feet in the air.
    """
    rng = np.random.default_rng([seed, 5])
    on_left = np.repeat([True, False], [stances - stances // 2, stances // 2])
    stance = rng.choice([-STANCE_RAD, 0.0, STANCE_RAD], (stances, len(LEGS)))
    lifted = np.pi + rng.uniform(-0.6, 0.6, (stances, len(LEGS)))
    targets = np.where(on_left[:, None] == LEFT_TRIPOD, stance, lifted)
    rig = Rig(robot)
    readings = []
    for target in targets:
        _hold(rig, np.zeros(len(LEGS)), settle_s=0.0)
        readings.append(_hold(rig, target, settle_s=1.5))
    return _table(readings, pose=np.arange(stances)).drop(columns="time_s")


def stand_still(robot: Hexapod, poses: int, seed: int, dwell_s: float = 5.0) -> pd.DataFrame:
    """One log at 100 Hz: `poses` poses held for `dwell_s` each, and the transitions between.

    Columns as `stand` without `ground_...`, with `time_s`; `pose` is -1 while the legs are told to
    move.
    """
    targets = _draw_poses(poses, np.random.default_rng([seed, 6]))
    rig = Rig(robot, phase_rad=targets[0])
    _hold(rig, targets[0], settle_s=1.0)
    readings: list[Reading] = []
    label: list[int] = []
    for index, target in enumerate(targets):
        moving = _move(rig, target, every=10) if index else []
        still = _stay(rig, target, dwell_s, every=10)
        readings += moving + still
        label += [-1] * len(moving) + [index] * len(still)
    return _table(readings, pose=np.array(label)).drop(columns=GROUND)


def walk(robot: Hexapod, cycles: int) -> pd.DataFrame:
    """Slow tripod walk to the right, read at 100 Hz ([Wu], section IV-3).

    Buehler clock at 0.08 Hz: slow sweep on the ground, fast turn through the air; some 9 degrees
    to the right per cycle.  Columns as `stand`, with `time_s` for `pose`.
    """
    sweep = np.where(LEFT_SIDE, STANCE_RAD + WALK_STEER_RAD, STANCE_RAD - WALK_STEER_RAD)
    lead = WALK_DUTY / 2 + np.where(LEFT_TRIPOD, 0.0, 0.5)

    def clock(time_s: float) -> Array:
        turns, part = np.divmod(WALK_RATE_HZ * time_s + lead, 1.0)
        ground = sweep * (2 * part / WALK_DUTY - 1)
        air = sweep + 2 * (np.pi - sweep) * (part - WALK_DUTY) / (1 - WALK_DUTY)
        phase: Array = 2 * np.pi * turns + np.where(part < WALK_DUTY, ground, air)
        return phase

    rig = Rig(robot)
    _hold(rig, np.zeros(len(LEGS)), settle_s=0.5)
    _hold(rig, clock(0.0), settle_s=1.5)
    readings = _run(rig, cycles / WALK_RATE_HZ, clock, every=10)
    return _table(readings)


def _draw_poses(count: int, rng: np.random.Generator) -> Array:
    """Distinct poses of the 3**6, phases in {-36, 0, 36} degrees, shape (count, 6)."""
    chosen = rng.choice(3 ** len(LEGS), count, replace=False)
    digits = chosen[:, None] // 3 ** np.arange(len(LEGS)) % 3
    phase: Array = STANCE_RAD * (digits - 1)
    return phase


def _run(
    rig: Rig, duration_s: float, command: Callable[[float], Array], every: int = 0
) -> list[Reading]:
    """Follow `command(time from now)`; take a reading each `every` steps, none for 0."""
    readings = []
    for index in range(round(duration_s / TIME_STEP_S)):
        phase_rad = command(index * TIME_STEP_S)
        if every and index % every == 0:
            readings.append(rig.read(phase_rad))
        rig.step(phase_rad)
    return readings


def _move(rig: Rig, target: Array, every: int = 0) -> list[Reading]:
    """Take the shafts from the present command to `target` along a cosine ramp."""
    begin = rig.command

    def ramp(time_s: float) -> Array:
        return begin + (target - begin) * float(1 - np.cos(np.pi * time_s / MOVE_S)) / 2

    return _run(rig, MOVE_S, ramp, every)


def _stay(rig: Rig, target: Array, duration_s: float, every: int = 0) -> list[Reading]:
    """Keep the shafts at `target`."""
    return _run(rig, duration_s, lambda _: target, every)


def _hold(rig: Rig, target: Array, settle_s: float) -> Reading:
    """Move to `target`, wait, and read."""
    _move(rig, target)
    _stay(rig, target, settle_s)
    return rig.read(target)


def _table(readings: list[Reading], **labels: NDArray[Any]) -> pd.DataFrame:
    """Long table, one row per reading and leg, legs in the order of `LEGS`.

    Labels have one value per reading and come first.
    """
    rows = len(readings)
    columns: dict[str, Any] = {name: np.repeat(values, 6) for name, values in labels.items()}
    time_s = np.array([reading.time_s for reading in readings])
    columns["time_s"] = np.repeat(np.round(time_s - time_s[0], 6), 6)
    columns["leg"] = np.tile(LEGS, rows)
    columns["phase_rad"] = np.concatenate([reading.phase_rad for reading in readings])
    wrench = np.concatenate([reading.wrench for reading in readings])
    quat = np.repeat([reading.quat_wb for reading in readings], 6, axis=0)
    ground = np.concatenate([reading.ground_wrench_w for reading in readings])
    columns |= dict(zip(WRENCH, wrench.T, strict=True))
    columns |= dict(zip(QUAT, quat.T, strict=True))
    columns["contact"] = np.concatenate([reading.contact for reading in readings])
    columns |= dict(zip(GROUND, ground.T, strict=True))
    return pd.DataFrame(columns)


def _by_leg(table: pd.DataFrame, columns: list[str]) -> Array:
    """A copy of some columns, shape (readings, 6, columns)."""
    values: Array = table[columns].to_numpy(dtype=float, copy=True)
    return values.reshape(-1, len(LEGS), len(columns))


def chassis_residual(robot: Hexapod, table: pd.DataFrame) -> Array:
    """What the chassis balance leaves over, body axes (N, Nm), shape (P, 6).

    The chassis is held up by six transducers and pulled down by its own weight:
    ``sum_k R_k f_k + m_c g = 0`` and ``sum_k [R_k t_k + (p_k - c) x R_k f_k] = 0``, with f, t
    applied on the transducers, ``m_c = M - sum m_k`` and c the chassis CoM (METHODS: the exact
    form of [Wu], eqs. 8 and 9).  True poses of the transducers are used.
    """
    wrench = _by_leg(table, WRENCH)
    body_to_world = Rotation.from_quat(_by_leg(table, QUAT)[:, 0])
    gravity_b = body_to_world.apply([0.0, 0.0, -GRAVITY_MPS2], inverse=True)
    residual = np.zeros((len(wrench), 6))
    residual[:, :3] = robot.chassis_mass_kg * gravity_b
    for index, leg in enumerate(robot.legs):
        force = wrench[:, index, :3] @ leg.rot_bt.T
        arm = leg.pos_b_m - robot.chassis_com_b_m
        residual[:, :3] += force
        residual[:, 3:] += wrench[:, index, 3:] @ leg.rot_bt.T + np.cross(arm, force)
    return residual


def foot_residual(robot: Hexapod, table: pd.DataFrame) -> Array:
    """Applied wrench minus leg weight minus wrench of the ground (N, Nm), shape (P, 6, 6).

    [Wu], eq. (3), in the floating-base frame; zero while the legs move slowly.
    """
    wrench = _by_leg(table, WRENCH)
    phase = _by_leg(table, ["phase_rad"])[..., 0]
    body_to_world = Rotation.from_quat(_by_leg(table, QUAT)[:, 0])
    forward = body_to_world.apply([1.0, 0.0, 0.0])
    heading = Rotation.from_euler("z", np.arctan2(forward[:, 1], forward[:, 0])[:, None])
    body_to_floating = heading.inv() * body_to_world
    residual = -_by_leg(table, GROUND)
    for index, leg in enumerate(robot.legs):
        force = body_to_floating.apply(wrench[:, index, :3] @ leg.rot_bt.T)
        torque = body_to_floating.apply(wrench[:, index, 3:] @ leg.rot_bt.T)
        hip_b = leg.pos_b_m - robot.reference_com_b_m
        com = body_to_floating.apply(hip_b + leg.com_t_m(phase[:, index]) @ leg.rot_bt.T)
        weight = [0.0, 0.0, -leg.mass_kg * GRAVITY_MPS2]
        residual[:, index, :3] += force - weight
        residual[:, index, 3:] += (
            torque + np.cross(body_to_floating.apply(hip_b), force) - np.cross(com, weight)
        )
    return residual


def hang_residual(robot: Hexapod, log: HangLog) -> Array:
    """Hanging wrench minus ``[m g, r(phase) x m g]``, transducer axes (N, Nm), shape (P, 6, 6).

    [Wu], eqs. (4)-(7), with the true direction of gravity.
    """
    residual = _by_leg(log.table, WRENCH)
    phase = _by_leg(log.table, ["phase_rad"])[..., 0]
    for index, leg in enumerate(robot.legs):
        weight = leg.mass_kg * GRAVITY_MPS2 * log.gravity_dir_t[index]
        residual[:, index, :3] -= weight
        residual[:, index, 3:] -= np.cross(leg.com_t_m(phase[:, index]), weight)
    return residual


def check_balance(
    robot: Hexapod, hangs: dict[str, HangLog], standing: dict[str, pd.DataFrame]
) -> dict[str, dict[str, float]]:
    """Print and return how well statics hold in every log.

    Parameters
    ----------
    hangs
        Hanging logs by orientation.
    standing
        Standing and walking tables by name.

    Returns
    -------
    dict
        Per check: RMS, median and largest norm of the force (N) and torque (Nm) residuals;
        while the legs move from pose to pose or a foot lands, statics does not hold.
    """

    def rms(values: Array) -> float:
        return float(np.sqrt(np.mean(values**2)))

    residuals = {f"hang {name}": hang_residual(robot, log) for name, log in hangs.items()}
    for name, table in standing.items():
        residuals[f"chassis {name}"] = chassis_residual(robot, table)
        if GROUND[0] in table:
            residuals[f"feet {name}"] = foot_residual(robot, table)
    report = {}
    for name, residual in residuals.items():
        force, torque = (np.linalg.norm(part, axis=-1) for part in np.split(residual, 2, axis=-1))
        report[name] = {
            f"{quantity}_{statistic}_{unit}": float(compute(norm))
            for quantity, unit, norm in (("force", "n", force), ("torque", "nm", torque))
            for statistic, compute in (("rms", rms), ("median", np.median), ("max", np.max))
        }
        print(f"{name:16}", *(f"{key} {value:.1e}" for key, value in report[name].items()))
    return report


def truth(robot: Hexapod, hangs: dict[str, HangLog], seed: int) -> dict[str, Any]:
    """Everything that was true of the logs, ready for JSON; conventions in `hexapod_model`."""
    return {
        "seed": seed,
        "engine": f"MuJoCo {mujoco.__version__}",
        "conventions": CONVENTIONS,
        "gravity_mps2": GRAVITY_MPS2,
        **robot.record(),
        "hang": {
            name: {
                "tilt_rotvec_b_rad": log.tilt_rotvec_rad.tolist(),
                "gravity_dir_t": dict(zip(LEGS, log.gravity_dir_t.tolist(), strict=True)),
            }
            for name, log in hangs.items()
        },
    }


def write_parquet(table: pd.DataFrame, path: Path) -> None:
    """Write a table: float32 but float64 time, zstd, same bytes for the same table."""
    floats = [name for name in table.select_dtypes("float64") if name != "time_s"]
    arrow = pa.table(
        {
            name: column.to_numpy(np.float32 if name in floats else None)
            for name, column in table.items()
        }
    )
    others = [name for name in table if name not in floats]
    pq.write_table(
        arrow,
        path,
        compression="zstd",
        compression_level=19,
        use_dictionary=others,
        use_byte_stream_split=floats,
    )


def main() -> None:
    """Write the five logs and their truth into a folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=3)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    robot = draw_hexapod(options.seed)
    hangs = {name: hang(robot, name, options.seed) for name in ORIENTATIONS}
    standing = {
        "poses": stand(robot, 543, options.seed),
        "tripod": stand_tripod(robot, 60, options.seed),
        "still": stand_still(robot, 12, options.seed),
        "hexwalk": walk(robot, 3),
    }
    hanging = pd.concat([log.table for log in hangs.values()], ignore_index=True)
    for name, table in {"hang": hanging, **standing}.items():
        write_parquet(table, options.out / f"motion_{name}.parquet")
    record = truth(robot, hangs, options.seed)
    record["balance"] = check_balance(robot, hangs, standing)
    text = json.dumps(record, indent=1) + "\n"
    (options.out / "truth_hexapod.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
