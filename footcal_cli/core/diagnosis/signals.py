"""What was recorded beside the residual, per experiment: anything unknown may depend on it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.case import Case, Rows
from footcal_cli.core.effects.contract import is_six_axis
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray


def describe(case: Case, rows: Rows) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Regressors (m,) and block-level covariates (B,) of any experiment."""
    per_log = [_signals(case, log) for log in case.logs]
    shared = [n for n in per_log[0] if all(n in signals for signals in per_log)]
    regressors: dict[str, FloatArray] = {}
    for name in shared:
        values = np.empty(rows.row.size)
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
        }  # fmt: skip
    if case.experiment.name in ("stand", "walk"):
        return _balanced(case, log)
    readings, _ = case.chain.remove(log, case.values)
    signals = {f"axis {c}": readings.readings[:, i] for i, c in enumerate(log.channels)}
    if len(log.channels) == 6:
        signals = {f"axis {c.split('.')[1]}": v for c, v in
                   zip(log.channels, readings.readings.T, strict=True)}  # fmt: skip
        phase = log.known["phase_rad"].reshape(len(log), -1)[:, 0]
        return {"sin φ": np.sin(phase), "cos φ": np.cos(phase), **signals}
    total = readings.readings.reshape(len(log), -1, 6)
    return {f"largest {a}": np.abs(total[:, :, i]).max(axis=1) for i, a in enumerate("xyz")}


def _weights(log: Log) -> dict[str, FloatArray]:
    if "load_n" not in log.known:
        wrench = log.known["wrench"]
        return {f"wrench {i}": wrench[:, i] for i in range(wrench.shape[1])}
    load = np.nan_to_num(log.known["load_n"].reshape(len(log), -1).sum(axis=1))
    fresh = np.diff(log.block, prepend=log.block[:1] - 1) != 0
    start = np.maximum.accumulate(np.where(fresh, np.arange(len(log)), 0))
    changed = np.diff(load, prepend=load[:1]) != 0
    since = np.maximum.accumulate(np.where(changed | fresh, np.arange(len(log)), 0))
    before = np.where(since > start, load[np.maximum(since - 1, 0)], 0.0)
    return {
        "load": load,
        "time in the session": log.time_s - log.time_s[start],
        "time at this load": log.time_s - log.time_s[since],
        "step into this load": load - before,
    }


def _balanced(case: Case, log: Log) -> dict[str, FloatArray]:
    """Demanded load, its rate and place, accelerations, loads of the feet."""
    known = log.known
    forces = case.chain.remove(log, case.values)[0].readings
    load = known["mass_kg"] * (known["com_acc_mps2"][:, 2] + known["gravity_mps2"])
    com, acc = known["com_m"], known["com_acc_mps2"]
    signals = {"vertical force": load, "acceleration x": acc[:, 0], "acceleration y": acc[:, 1]}
    if is_six_axis(log.channels):
        return signals
    middle = known["cell_pos_m"].mean(axis=1)
    feet = dict.fromkeys(c.split("_", 1)[0] for c in log.channels)
    for foot in feet:
        mine = [i for i, c in enumerate(log.channels) if c.startswith(f"{foot}_")]
        total = np.nansum(forces[:, mine], axis=1)
        signals[f"load of foot {foot}"] = total
        arms = known["cell_pos_m"][:, mine] - known["cell_pos_m"][:, mine].mean(1, keepdims=True)
        yaw = known["foot_yaw_rad"][:, list(feet).index(foot)]
        ahead = arms[..., 0] * np.cos(yaw)[:, None] + arms[..., 1] * np.sin(yaw)[:, None]
        signals[f"pitch moment of foot {foot}"] = np.nansum(forces[:, mine] * ahead, axis=1)
    signals["CoM ahead of the feet"] = com[:, 0] - middle[:, 0]
    signals["CoM beside the feet"] = com[:, 1] - middle[:, 1]
    if np.all(np.diff(log.time_s) > 0) and len(log) > 2:
        signals["force rate"] = np.gradient(load, log.time_s)
    return signals


def _covariates(case: Case, rows: Rows) -> dict[str, FloatArray]:
    """Block means of temperature and time of recording, where blocks may be permuted."""
    if not case.alike or case.drifts:
        return {}
    blocks = int(rows.block.max()) + 1
    count = np.maximum(np.bincount(rows.block, minlength=blocks), 1)
    covariates = {}
    time = np.bincount(rows.block, weights=rows.time_s, minlength=blocks) / count
    covariates["time of recording"] = time
    if all("temperature_degc" in log.known for log in case.logs):
        warm = np.empty(rows.row.size)
        for i, log in enumerate(case.logs):
            here = rows.log == i
            warm[here] = log.known["temperature_degc"].reshape(len(log), -1)[:, 0][rows.row[here]]
        covariates["temperature"] = np.bincount(rows.block, warm, minlength=blocks) / count
    return covariates
