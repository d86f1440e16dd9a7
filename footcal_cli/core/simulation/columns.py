"""Simulated logs as the canonical columns of footcal's log files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.ankle_logs import AnkleLogs
from footcal_cli.core.simulation.biped_logs import BipedLogs
from footcal_cli.core.simulation.hexapod_logs import HangPlan, orientation_of, rot_named
from footcal_cli.core.simulation.measure import Simulated
from footcal_cli.core.simulation.robots import Hexapod

Columns = Mapping[str, NDArray[np.generic]]
"""Column name -> values, all of one length."""
WRENCH_COLUMNS = tuple(
    f"{axis}_{unit.lower()}" for axis, unit in zip(AXES, AXIS_UNITS, strict=True)
)


def _counts(log: Log) -> dict[str, NDArray[np.generic]]:
    return {
        f"{channel}_counts": _codes(log.readings[:, i]) for i, channel in enumerate(log.channels)
    }


def _codes(readings: FloatArray) -> NDArray[np.generic]:
    """Readings (n,) of a converter as the whole numbers that they are; others as they are."""
    whole = readings.astype(np.int64)
    return whole if np.array_equal(whole, readings) else readings


def _vector(name: str, unit: str, array: FloatArray, axes: str = "xyz") -> dict[str, FloatArray]:
    return {f"{name}_{axis}_{unit}": array[:, i] for i, axis in enumerate(axes)}


def weights_columns(logs: Sequence[Simulated]) -> Columns:
    """Long table of known weights, channel after channel."""
    parts = [
        {
            "channel": np.repeat(np.array(done.log.channels), len(done.log)),
            "load_n": done.log.known["load_n"][:, 0],
            "counts": _codes(done.log.readings[:, 0]),
            "time_s": done.log.time_s,
            "temperature_degc": np.round(done.log.known["temperature_degc"], 3),
            "direction": done.log.known["direction"].astype(np.int64),
            "repeat": done.log.block,
            "session": (done.log.block + 1).astype(str),
        }
        for done in logs
    ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def placements_columns(logs: Sequence[Simulated]) -> Columns:
    """Long table of placements, foot after foot."""
    parts = []
    for done in logs:
        log = done.log
        foot = log.channels[0].split("_", 1)[0]
        repeats = int(np.bincount(log.block).max())
        parts.append(
            {
                "foot": np.repeat(np.array([foot]), len(log)),
                "placement": _names_of_holes(log.known["hole_m"]),
                "hole_x_m": np.round(log.known["hole_m"][:, 0], 9),
                "hole_y_m": np.round(log.known["hole_m"][:, 1], 9),
                "load_n": log.known["load_n"],
                **{
                    f"{channel.split('_', 1)[1]}_counts": _codes(log.readings[:, i])
                    for i, channel in enumerate(log.channels)
                },
                "repeat": np.arange(len(log)) % repeats,
                "time_s": log.time_s,
            }
        )
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _names_of_holes(hole_m: FloatArray) -> NDArray[np.generic]:
    """``H01`` … from the heel on, shape (n,)."""
    _, number = np.unique(np.round(hole_m, 9), axis=0, return_inverse=True)
    return np.array([f"H{k:02d}" for k in number.ravel() + 1])


def cells_columns(logs: BipedLogs) -> Columns:
    """The stream of the cells."""
    log = logs.cells.log
    return {
        "time_s": log.time_s,
        **_counts(log),
        "temperature_degc": np.round(log.known["temperature_degc"], 3),
    }


def wrenches_columns(logs: AnkleLogs) -> Columns:
    """The stream of the transducers at the ankles."""
    log = logs.wrenches.log
    return {
        "time_s": log.time_s,
        **{
            channel.split(".")[0] + f"_{WRENCH_COLUMNS[i % 6]}": log.readings[:, i]
            for i, channel in enumerate(log.channels)
        },
    }


def ankle_body_columns(logs: AnkleLogs) -> Columns:
    """The body's stream on its own clock, with the attitudes of the feet."""
    columns = _motion_columns(logs.body)
    feet = dict.fromkeys(channel.split(".")[0] for channel in logs.wrenches.log.channels)
    for i, foot in enumerate(feet):
        columns |= _vector(f"{foot}_foot", "m", logs.foot_m[:, i])
        columns |= {
            f"{foot}_foot_q{axis}": logs.foot_quaternion[:, i, k] for k, axis in enumerate("xyzw")
        }
    return columns


def _motion_columns(body: Log) -> dict[str, NDArray[np.generic]]:
    known = body.known
    return {
        "time_s": body.time_s,
        **_vector("com", "m", known["com_m"]),
        **_vector("com_acc", "mps2", known["com_acc_mps2"]),
        **_vector("angmom_rate", "nm", known["angmom_rate_nm"], "xy"),
    }


def body_columns(logs: BipedLogs, feet: Sequence[str]) -> Columns:
    """The body's stream on its own clock."""
    columns = _motion_columns(logs.body)
    for i, foot in enumerate(feet):
        columns |= _vector(f"{foot}_foot", "m", logs.foot_m[:, i])
        columns[f"{foot}_foot_yaw_rad"] = logs.foot_yaw_rad[:, i]
    return columns


def loads_columns(truth: Log) -> Columns:
    """True loads of all cells at the cells' stamps."""
    return {
        "time_s": truth.time_s,
        **{f"{channel}_n": truth.readings[:, i] for i, channel in enumerate(truth.channels)},
    }


def hang_columns(logs: Mapping[str, Simulated], robot: Hexapod, plan: HangPlan) -> Columns:
    """Long table of a hanging robot, leg after leg."""
    parts = []
    for leg, done in logs.items():
        log = done.log
        parts.append(
            {
                "orientation": np.array(orientation_of(log, rot_named(robot, leg, plan))),
                "time_s": log.time_s,
                "leg": np.repeat(np.array([leg]), len(log)),
                "phase_rad": log.known["phase_rad"],
                **{name: log.readings[:, i] for i, name in enumerate(WRENCH_COLUMNS)},
                "temperature_degc": log.known["temperature_degc"],
            }
        )
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def poses_columns(done: Simulated, legs: Sequence[str]) -> Columns:
    """Long table of a standing robot, a row per pose and leg."""
    log = done.log
    rows, count = len(log), len(legs)
    wrench = log.readings.reshape(rows * count, 6)
    quaternion = np.repeat(Rotation.from_matrix(log.known["rot_wb"]).as_quat(), count, axis=0)
    return {
        "pose": np.repeat(log.block, count),
        "leg": np.tile(np.array(legs), rows),
        "phase_rad": log.known["phase_rad"].ravel(),
        **{name: wrench[:, i] for i, name in enumerate(WRENCH_COLUMNS)},
        **{f"body_q{axis}": quaternion[:, i] for i, axis in enumerate("xyzw")},
        "contact": log.known["contact"].ravel().astype(np.int64),
    }
