"""`online-replay` on load cells: its tables, and the columns of ``replay.parquet``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np

from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.online.comparison import ReplayedWalk
from footcal_cli.core.online.filter import WalkNoise
from footcal_cli.core.parameters import learnt_status
from footcal_cli.core.signals import parts_of
from footcal_cli.core.study.sensitivity import Sensitivity
from footcal_cli.core.study.walk import PaperMethods
from footcal_cli.plots import walk as plots
from footcal_cli.report import Sheet, number, with_sd
from footcal_cli.sheets.stand import beliefs_sheet

_QUANTITIES = (("cop", 1e3), ("foot_cop", 1e3), ("vgrf", 1.0))
"""Quantity and the factor that shows it in mm or N."""
_PIECE_ROWS = 2**16
"""Samples written at a time."""
AGAINST = {
    "truth": "the truth",
    "baseline": "the offline baseline",
    "motion": "the demand of the motion",
}
STATE_UNITS = {
    "robot.delay": (1e3, "ms"),
    "robot.com_correction_x": (1e3, "mm"),
    "robot.com_correction_y": (1e3, "mm"),
    "robot.com_correction_z": (1e3, "mm"),
    "robot.angmom_loss": (100.0, "%"),
    "robot.angmom_share_x": (100.0, "%"),
    "robot.angmom_share_y": (100.0, "%"),
    "robot.smoothing": (1e6, "ms²"),
    "robot.smoothing_fourth": (1e8, "(10 ms)⁴"),
}


def sheets_of(found: ReplayedWalk, papers: PaperMethods | None) -> tuple[Sheet, ...]:
    """All tables."""
    return (
        _methods_sheet(found),
        _calibration_sheet(found),
        _states_sheet(found),
        _settling_sheet(found),
        _noise_sheet(found, papers),
    )


def _methods_sheet(found: ReplayedWalk) -> Sheet:
    rows = []
    for reference in dict.fromkeys(j.reference for j in found.judged):
        for one in (j for j in found.judged if j.reference == reference):
            whole = one.rms("cop") if one.whole["cop"].count else float("nan")
            cells = [one.method, AGAINST[reference], number(1e3 * whole, 3)]
            for quantity, factor in _QUANTITIES:
                key = (one.method, reference, quantity)
                if key not in found.per_cycle:
                    cells.append("–")
                    continue
                mean = found.per_cycle[key]
                spread = float(np.nanstd(one.cycles(quantity)))
                cells.append(with_sd(factor * mean.value, factor * spread))
            key = (one.method, reference, "cop")
            ratio, p = found.ratios.get(key, (None, float("nan")))
            cells.append(in_words(ratio) if ratio is not None else "1")
            cells.append(p_in_words(p))
            rows.append(cells)
    return Sheet(
        "Errors by method, of the whole walk and per gait cycle",
        ("method", "against", "CoP, whole walk (mm)", "CoP per cycle (mm)",
         "each foot's CoP per cycle (mm)", "vertical force per cycle (N)",
         "memory / method, CoP", "p"),
        rows,
        brief=("method", "against", "CoP, whole walk (mm)", "CoP per cycle (mm)",
               "vertical force per cycle (N)"),
        note="Whole walk: RMS over all samples. Per cycle: RMS of each gait cycle, mean ± sd over "
        "cycles. Both leave the first 5 s out. Ratios of "
        "RMS errors with 95 % bootstrap intervals over paired cycles; p: Wilcoxon signed-rank. "
        "The smoother uses the whole walk. Truth and cells are in the same 10 Hz band. The "
        "demand of the motion is taken with the delay, CoM offset and L̇ that memory estimated: it "
        "judges the scatter of the methods, not these estimates.",
    )  # fmt: skip


def _calibration_sheet(found: ReplayedWalk) -> Sheet:
    track, rows = found.memory.track, found.memory.rows
    c = 2 * len(found.belief.channels)
    status = learnt_status(track.sd[-1, :c], rows.prior_sd[:c])
    return beliefs_sheet(
        track.names[:c], track.units[:c], track.values[-1, :c], track.sd[-1, :c], rows.prior_sd[:c],
        status,
        "State of memory at the end of the walk, on top of the prior; parameters.json has scale "
        "and bias of the raw counts. Estimated: the walk at least halved the sd.",
    )  # fmt: skip


def _states_sheet(found: ReplayedWalk) -> Sheet:
    track, prior = found.memory.track, found.memory.rows.prior_sd
    c = 2 * len(found.belief.channels)
    rows = []
    for i in range(c, len(track.names)):
        factor, unit = STATE_UNITS.get(track.names[i], (1.0, track.units[i]))
        value, sd = factor * track.values[-1, i], factor * track.sd[-1, i]
        if track.names[i] == "robot.delay":
            value += 1e3 * found.memory.delay_s
        rows.append(
            (plots.state_in_words(track.names[i]), with_sd(float(value), float(sd)), unit,
             number(factor * float(prior[i]), 3))
        )  # fmt: skip
    return Sheet(
        "What was wrong with the reference",
        ("state", "at the end ± sd", "unit", "prior sd"),
        rows,
        note="CoM offset, a tilted IMU, accelerometer bias and floor slope look alike while "
        "walking straight: the CoM correction stands for all of them.",
    )


def _settling_sheet(found: ReplayedWalk) -> Sheet:
    rows = []
    for s in found.settling:
        factor, unit = (100.0, "%") if s.unit == "-" else (1.0, s.unit)
        rows.append(
            (
                s.name,
                number(s.converged_s, 3),
                number(factor * s.steady_sd, 2),
                with_sd(factor * s.drift_per_hour, factor * s.drift_sd),
                unit,
            )
        )
    return Sheet(
        "Convergence and drift",
        ("unknown", "converged after (s)", "steady sd", "drift per hour", "unit"),
        rows,
        note="Converged: the estimate stays within ± 2 sd of the mean of the last third. Steady "
        "sd: scatter about a line over the last third. Drift: middle to last third, with the "
        "filter's sd.",
    )


def _noise_sheet(found: ReplayedWalk, papers: PaperMethods | None) -> Sheet:
    memory = found.memory
    learnt = {}
    if memory.tuning is not None:
        learnt = dict(zip(memory.tuning.learnt, memory.tuning.sd_log, strict=True))
    rows = [
        (
            f.name,
            number(float(np.asarray(getattr(memory.noise, f.name))), 3),
            f"learnt, × or / {np.exp(min(learnt[f.name], 3.0)):.2f}"
            if f.name in learnt
            else "given",
        )
        for f in fields(WalkNoise)
    ]
    for method, one in papers.windowed.items() if papers is not None else ():
        weights = one.weights
        rows += [
            (f"{method}: {name}", number(float(np.asarray(weight)), 3), source)
            for name, weight, source in (
                ("omega_f", weights.force, "quiet standing, or given"),
                ("omega_p", weights.cop, "quiet standing, or given"),
                ("omega_s", weights.smooth, "best prediction of the motion's demand, or given"),
            )
        ]
    return Sheet("Noise and weights", ("setting", "value", "from"), rows)


def in_words(interval: Interval) -> str:
    """A value with its 95 % interval."""
    return f"{interval.value:.2f} [{interval.low:.2f}, {interval.high:.2f}]"


def p_in_words(p: float) -> str:
    """``0.013``, ``< 0.001``, a dash for none."""
    return "–" if p != p else "< 0.001" if p < 0.001 else f"{p:.3f}"


def sensitivity_columns(curves: Sequence[tuple[str, Sensitivity]]) -> dict[str, object]:
    """``sensitivity.parquet``: one row per method, setting and factor."""
    size = [curve.factors.size for _, curve in curves]
    return {
        "method": np.repeat([method for method, _ in curves], size),
        "setting": np.repeat([curve.setting for _, curve in curves], size),
        "factor": np.concatenate([curve.factors for _, curve in curves]),
        "cop_rmse_m": np.concatenate([curve.cop_m for _, curve in curves]),
        "vgrf_rmse_n": np.concatenate([curve.vgrf_n for _, curve in curves]),
    }


def frames_of(found: ReplayedWalk) -> Iterator[dict[str, object]]:
    """``replay.parquet`` in pieces: per sample forces, CoP, parameters, sd, validity, reason."""
    for part in parts_of(len(found.memory.log), _PIECE_ROWS):
        yield _frame_of(found, part)


def _frame_of(found: ReplayedWalk, part: slice) -> dict[str, object]:
    log, ours = found.memory.log, found.replayed["memory"]
    frame: dict[str, object] = {"time_s": log.time_s[part], "gait_cycle": found.cycle[part]}
    for i, channel in enumerate(log.channels):
        frame[f"{channel}_n"] = ours.forces_n[part, i]
    for method in ("memory", "window", "static", "smoother"):
        if method not in found.replayed:
            continue
        one = found.replayed[method].total
        suffix = "" if method == "memory" else f"_{method}"
        frame[f"vgrf{suffix}_n"] = one.fz_n[part]
        frame[f"cop{suffix}_x_m"], frame[f"cop{suffix}_y_m"] = one.cop_m[part].T
    for name, pressure in zip(_feet_names(log.channels), ours.feet, strict=True):
        frame[f"{name}_cop_x_m"], frame[f"{name}_cop_y_m"] = pressure.cop_m[part].T
    for k, name in enumerate(_feet_names(log.channels)):
        frame[f"{name}_contact"] = log.known["contact"][part, k]
    reference = found.reference
    frame["reference_vgrf_n"] = reference.fz_n[part]
    frame["reference_cop_x_m"], frame["reference_cop_y_m"] = reference.cop_m[part].T
    track, last = found.memory.track, found.memory.rows.last_sample
    samples = np.arange(*part.indices(len(log)))
    update = np.clip(np.searchsorted(last, samples, side="right") - 1, 0, None)
    for i, name in enumerate(track.names):
        frame[name.replace(".", "_")] = track.values[update, i]
        frame[f"{name.replace('.', '_')}_sd"] = track.sd[update, i]
    validity = found.validity
    frame["cop_valid"] = ours.total.valid[part]
    frame["used"] = validity.valid[part]
    frame["reason"] = replace(validity, reason=validity.reason[part]).words()
    return frame


def _feet_names(channels: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(channel.split("_", 1)[0] for channel in channels))
