"""What was recorded beside the residual, per experiment: anything unknown may depend on it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.contact import gait_cycles
from footcal_cli.core.diagnosis.features import GAIT
from footcal_cli.core.effects.contract import Scope, columns_of, is_six_axis
from footcal_cli.core.experiments.walk import feet_of
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import begins


def describe(case: Case, rows: Problem) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Regressors (m,) and block-level covariates (B,) of any experiment."""
    per_log = [_signals(case, log) for log in case.logs]
    shared = [n for n in per_log[0] if all(n in signals for signals in per_log)]
    regressors: dict[str, FloatArray] = {}
    for name in shared:
        values = np.empty(rows.residual.size)
        for i, signals in enumerate(per_log):
            here = rows.log == i
            values[here] = signals[name][rows.row[here]]
        finite = np.isfinite(values)
        if finite.any() and np.ptp(values[finite]) > 0:
            regressors[name] = np.where(finite, values, np.median(values[finite]))
    return regressors, _covariates(case, rows)


def _signals(case: Case, log: Log) -> Mapping[str, FloatArray]:
    if case.experiment.name == "weights":
        return _weights(log)
    if case.experiment.name == "placements":
        hole = log.known["hole_m"]
        load = log.known["load_n"].reshape(len(log), -1).sum(axis=1)
        return {
            "load": load, "hole x": hole[:, 0], "hole y": hole[:, 1],
            "load × hole x": load * hole[:, 0], "load × hole y": load * hole[:, 1],
            "order of recording": np.arange(float(len(log))),
        }  # fmt: skip
    if case.experiment.name == "walk":
        return _walking(log)
    truth, _ = case.chain.remove(log, case.values)
    if case.experiment.name == "stand":
        return _standing(truth)
    return _hanging(truth) if case.experiment.name == "hang" else _posing(truth)


def _hanging(log: Log) -> dict[str, FloatArray]:
    """Shaft angle, direction of gravity, time since the robot was hung so, and temperature."""
    fresh = np.diff(log.known["hanging"], prepend=-1.0) != 0
    start = np.maximum.accumulate(np.where(fresh, np.arange(len(log)), 0))
    down = log.known["gravity_dir"]
    signals: dict[str, FloatArray] = {
        "shaft phase": np.mod(log.known["phase_rad"], 2.0 * np.pi),
        "time in this hanging": log.time_s - log.time_s[start],
        **{f"gravity along {a}": np.round(down[:, i], 1) for i, a in enumerate("xyz")},
    }
    if "temperature_degc" in log.known:
        signals["temperature"] = log.known["temperature_degc"]
    return signals


def _posing(log: Log) -> dict[str, FloatArray]:
    """Tilt of the body, and vertical load and shaft angle of every leg."""
    legs = list(dict.fromkeys(c.split(".")[0] for c in log.channels))
    force = log.readings.reshape(len(log), -1, 6)[..., :3]
    vertical = np.einsum("nki,nki->nk", log.known["hip_rot_bt"][:, :, 2], force)
    down = -log.known["rot_wb"][:, 2]
    return {
        "tilt forward": down[:, 0],
        "tilt to the left": down[:, 1],
        **{f"load on {leg}": vertical[:, k] for k, leg in enumerate(legs)},
        **{f"shaft of {leg}": log.known["phase_rad"][:, k] for k, leg in enumerate(legs)},
        **{
            f"force along {axis} of {leg}": force[:, k, i]
            for k, leg in enumerate(legs)
            for i, axis in enumerate("xy")
        },
    }


def _weights(log: Log) -> dict[str, FloatArray]:
    if "load_n" not in log.known:
        wrench = log.known["wrench"]
        return {f"wrench {i}": wrench[:, i] for i in range(wrench.shape[1])}
    load = np.nan_to_num(log.known["load_n"].reshape(len(log), -1).sum(axis=1))
    fresh = begins(log.block)
    start = np.maximum.accumulate(np.where(fresh, np.arange(len(log)), 0))
    changed = np.diff(load, prepend=load[:1]) != 0
    since = np.maximum.accumulate(np.where(changed | fresh, np.arange(len(log)), 0))
    before = np.where(since > start, load[np.maximum(since - 1, 0)], 0.0)
    signals: dict[str, FloatArray] = {
        "load": load,
        "time in the session (s)": log.time_s - log.time_s[start],
        "time at this load": log.time_s - log.time_s[since],
        "step into this load": load - before,
    }
    if "temperature_degc" in log.known:
        signals["temperature"] = log.known["temperature_degc"].reshape(len(log), -1)[:, 0]
    return signals


def _standing(log: Log) -> dict[str, FloatArray]:
    """Where the CoM is, and where each foot is loaded."""
    com = log.known["com_m"]
    middle = com[:, :2] * 0.0
    if "cell_pos_m" in log.known:
        middle = log.known["cell_pos_m"].mean(axis=1)
    return {
        "CoM ahead of the feet": com[:, 0] - middle[:, 0],
        "CoM to the left of the feet": com[:, 1] - middle[:, 1],
        "CoM height": com[:, 2],
        **_on_each_foot(log),
    }


def _on_each_foot(log: Log) -> dict[str, FloatArray]:
    """Load of each foot, and how far before and beside the middle of its cells it acts.

    A sole that rolls over its edge or folds depends on where its own foot is loaded.
    """
    if is_six_axis(log.channels):
        return {}
    signals: dict[str, FloatArray] = {}
    columns = columns_of(Scope.FOOT, log.channels)
    for k, (foot, own) in enumerate(zip(feet_of(log), columns, strict=True)):
        force = log.readings[:, own]
        load = force.sum(axis=1)
        signals[f"load on {foot}"] = load
        arms = log.known["cell_pos_m"][:, own]
        arms = arms - arms.mean(axis=1, keepdims=True)
        moment = np.einsum("nc,nci->ni", force, arms)
        bears = load > _BEARS * load.max()
        cop = np.where(bears[:, None], moment / np.where(bears, load, 1.0)[:, None], np.nan)
        yaw = log.known["foot_yaw_rad"][:, k] if "foot_yaw_rad" in log.known else 0.0 * load
        cos, sin = np.cos(yaw), np.sin(yaw)
        signals[f"CoP ahead in {foot}"] = cos * cop[:, 0] + sin * cop[:, 1]
        signals[f"CoP to the left in {foot}"] = cos * cop[:, 1] - sin * cop[:, 0]
    return signals


_BEARS = 0.1
"""Share of its largest load from which a foot has a CoP worth the name."""


def _walking(log: Log) -> dict[str, FloatArray]:
    """Phase of the gait.

    Measured forces and accelerations share their noise with the residual, so that a flexible
    function of them would explain part of any clean log. The phase does not, and what a robot
    does repeats with it.
    """
    cycle = gait_cycles(log.known["contact"])
    if cycle.max(initial=-1) < _LEAST_CYCLES:
        return {}
    phase = np.zeros(len(log))
    for number in range(int(cycle.max()) + 1):
        rows = np.flatnonzero(cycle == number)
        if rows.size > 1:
            phase[rows] = (log.time_s[rows] - log.time_s[rows[0]]) / (
                log.time_s[rows[-1]] - log.time_s[rows[0]]
            )
    return {GAIT: phase}


_LEAST_CYCLES = 3


def _covariates(case: Case, rows: Problem) -> dict[str, FloatArray]:
    """Block means of temperature and time of recording, where blocks may be permuted."""
    if not case.alike or case.drifts:
        return {}
    blocks = int(rows.block.max()) + 1
    count = np.maximum(np.bincount(rows.block, minlength=blocks), 1)
    covariates = {}
    time = np.bincount(rows.block, weights=rows.time_s, minlength=blocks) / count
    covariates["time of recording"] = time
    if all("temperature_degc" in log.known for log in case.logs):
        warm = np.empty(rows.residual.size)
        for i, log in enumerate(case.logs):
            here = rows.log == i
            warm[here] = log.known["temperature_degc"].reshape(len(log), -1)[:, 0][rows.row[here]]
        covariates["temperature"] = np.bincount(rows.block, warm, minlength=blocks) / count
    return covariates
