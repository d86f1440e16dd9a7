"""Verdict, tables and figures of `online-replay` on load cells."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np

from footcal_cli.core.online.comparison import Comparison
from footcal_cli.core.online.evidence import Interval
from footcal_cli.core.online.filter import Noise
from footcal_cli.core.online.memory import LEARNT_RATIO
from footcal_cli.core.online.sensitivity import Sensitivity
from footcal_cli.core.parameters import Status
from footcal_cli.intake.cell_effects import cells_in_feet
from footcal_cli.plots import walk as plots
from footcal_cli.recipe import Robot
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, with_sd
from footcal_cli.sheets.stand import beliefs_sheet

_QUANTITIES = (("cop", "m", 1e3, "mm"), ("foot_cop", "m", 1e3, "mm"), ("vgrf", "N", 1.0, "N"))
_PIECE_ROWS = 2**16
"""Samples written at a time."""
_TITLES = {"cop": "CoP", "foot_cop": "CoP of each foot", "vgrf": "vertical force"}
_AGAINST = {
    "truth": "the truth",
    "baseline": "the offline baseline",
    "motion": "the demand of the motion",
}
POOR_COP_MM, POOR_SHARE = 20.0, 0.05
"""Errors of the CoP, and of the vertical force over the weight, that no good calibration leaves."""
SHOWN = ("before", "static", "window", "memory", "smoother")
STATE_UNITS = {
    "robot.delay": (1e3, "ms"),
    "robot.com_correction_x": (1e3, "mm"),
    "robot.com_correction_y": (1e3, "mm"),
    "robot.angmom_loss": (100.0, "%"),
}


def verdict_of(found: Comparison, method: str) -> VerdictRecord:
    """The first sentence and what it rests on."""
    reference = found.best_reference
    before, after = (found.of(m, reference) for m in ("before", method))
    cop = [1e3 * one.rms("cop") for one in (before, after)]
    force = [one.rms("vgrf") for one in (before, after)]
    alarms = sum(jump.sure for jump in found.memory.jumps)
    details = []
    for other in ("window", "static"):
        if other == method or (other, reference, "cop") not in found.ratios:
            continue
        ratio, p = found.ratios[other, reference, "cop"]
        details.append(
            f"CoP error {_interval(ratio)} × that of {_METHODS[other]} over {ratio.n} gait cycles "
            f"(Wilcoxon p {_p(p)})."
            if method == "memory"
            else f"The estimator with memory has {_interval(ratio)} × the CoP error of "
            f"{_METHODS[other]} on this walk."
        )
    states = found.memory.track
    told = []
    if "robot.delay" in states.names:
        told.append(
            f"body stream {with_sd(1e3 * found.memory.delay_s, 1e3 * found.memory.delay_sd_s)} ms "
            "later than compensated"
        )
    for axis in "xy":
        name = f"robot.com_correction_{axis}"
        if name in states.names:
            i = states.names.index(name)
            value, sd = 1e3 * states.values[-1, i], 1e3 * states.sd[-1, i]
            told.append(f"CoM {axis} off by {with_sd(float(value), float(sd))} mm")
    if told:
        details.append(f"Found along the way: {'; '.join(told)}.")
    details += [
        f"{jump.name.removesuffix('.bias')}: bias jumped by {number(jump.size, 2)} N at "
        f"{jump.onset_s:.2f} s."
        for jump in found.memory.jumps
        if jump.sure
    ]
    alarms += len(found.weighed.findings())
    worse = cop[1] > cop[0]
    known = found.merged.log.known
    weight_n = float(known["mass_kg"][0] * known["gravity_mps2"][0])
    if not (cop[1] < POOR_COP_MM and force[1] < POOR_SHARE * weight_n):
        details.insert(
            0, "The residual is large, whatever it was before: something is not in the model; run "
            "diagnose.",
        )  # fmt: skip
        alarms += 1
    consistent = 0.8 < found.consistency.ratio < 1.25
    return VerdictRecord(
        level="bad" if worse else "good" if consistent and not alarms else "warning",
        sentence=f"CoP error {number(cop[0], 3)} → {number(cop[1], 3)} mm, error of the vertical "
        f"force {number(force[0], 3)} → {number(force[1], 3)} N against {_AGAINST[reference]}, "
        f"by {_METHODS[method]}.",
        details=tuple(details),
    )


_METHODS = {
    "memory": "the filter with memory",
    "smoother": "the smoother",
    "window": "the sliding window",
    "static": "the zero-acceleration assumption",
}


def _interval(interval: Interval) -> str:
    return f"{interval.value:.2f} [{interval.low:.2f}, {interval.high:.2f}]"


def _p(p: float) -> str:
    return "–" if p != p else "< 0.001" if p < 0.001 else f"= {p:.3f}"


def sheets_of(found: Comparison) -> tuple[Sheet, ...]:
    """All tables."""
    return (
        _methods_sheet(found),
        _calibration_sheet(found),
        _states_sheet(found),
        _settling_sheet(found),
        _noise_sheet(found),
    )


def _methods_sheet(found: Comparison) -> Sheet:
    rows = []
    for reference in dict.fromkeys(j.reference for j in found.judged):
        for one in (j for j in found.judged if j.reference == reference):
            cells = [one.method, _AGAINST[reference]]
            for quantity, _, factor, _ in _QUANTITIES:
                key = (one.method, reference, quantity)
                if key not in found.per_cycle:
                    cells.append("–")
                    continue
                mean = found.per_cycle[key]
                spread = float(np.nanstd(one.cycles(quantity)))
                cells.append(with_sd(factor * mean.value, factor * spread))
            key = (one.method, reference, "cop")
            ratio, p = found.ratios.get(key, (None, float("nan")))
            cells.append(_interval(ratio) if ratio is not None else "1")
            cells.append(_p(p))
            rows.append(cells)
    return Sheet(
        "Methods",
        ("method", "against", "CoP (mm)", "each foot's CoP (mm)", "vertical force (N)",
         "memory / method, CoP", "p"),
        rows,
        note="RMS error per gait cycle, mean ± sd over cycles, the first 5 s left out. Ratios of "
        "RMS errors with 95 % bootstrap intervals over paired cycles; p: Wilcoxon signed-rank. "
        "The smoother uses the whole walk. Truth and cells are in the same 10 Hz band. The "
        "demand of the motion is taken with the delay, CoM offset and L̇ that memory estimated: it "
        "judges the scatter of the methods, not these estimates.",
    )  # fmt: skip


def _calibration_sheet(found: Comparison) -> Sheet:
    track, rows = found.memory.track, found.memory.rows
    c = 2 * len(found.belief.channels)
    status = [
        Status.ESTIMATED if now < LEARNT_RATIO * before else Status.PRIOR_KEPT
        for now, before in zip(track.sd[-1, :c], rows.prior_sd[:c], strict=True)
    ]
    return beliefs_sheet(
        track.names[:c], track.units[:c], track.values[-1, :c], track.sd[-1, :c], rows.prior_sd[:c],
        status,
        "State of memory at the end of the walk, on top of the prior; parameters.json has scale "
        "and bias of the raw counts. Estimated: the walk at least halved the sd.",
    )  # fmt: skip


def _states_sheet(found: Comparison) -> Sheet:
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


def _settling_sheet(found: Comparison) -> Sheet:
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
        note="Converged: stays within ± 2 sd of the mean of the last third. Steady sd: scatter "
        "about a line over the last third. Drift: middle to last third, with the filter's sd.",
    )


def _noise_sheet(found: Comparison) -> Sheet:
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
        for f in fields(Noise)
    ]
    for method, weights in found.weights.items():
        rows += [
            (f"{method}: {name}", number(float(np.asarray(weight)), 3), source)
            for name, weight, source in (
                ("omega_f", weights.force, "quiet standing, or given"),
                ("omega_p", weights.cop, "quiet standing, or given"),
                ("omega_s", weights.smooth, "best prediction of the motion's demand, or given"),
            )
        ]
    return Sheet("Noise and weights", ("setting", "value", "from"), rows)


def _how_run(found: Comparison) -> str:
    """After the fact or live, whole or in parts."""
    taught = "from the whole walk"
    parts = ""
    if found.in_parts is not None:
        how = found.in_parts
        minutes = number(how.part_s / 60, 2)
        taught = f"from {minutes} min from {number(how.taught_from_s, 4)} s on"
        parts = (
            f" Run in {how.parts} parts of {number(how.part_s / 60, 2)} min, the filter's state "
            f"handed on; the smoother of a part sees {number(how.ahead_s, 2)} s beyond its end. "
            "CoP, force and path are drawn for the last part; of the other series every "
            f"{how.every}th update is kept."
        )
    if found.causal:
        first = " of the first part" if parts else ""
        return (
            f"Live: filtered, and learnt after 8, 16, 32 … s{first}, from the past alone; of the "
            f"latency of the low-pass nothing is counted as error.{parts}"
        )
    return (
        f"After the fact: delay, noise and doubted states are learnt {taught}, the low-pass has no "
        f"lag; --causal runs as a robot would.{parts}"
    )


def footer_of(found: Comparison, delay_s: float) -> tuple[str, ...]:
    """What was assumed, for who wants to repeat it."""
    c = found.consistency
    return (
        _how_run(found),
        f"Normalised innovation squared {c.ratio:.3f} (95 % band for as many independent ones as "
        f"these are worth [{c.low:.3f}, {c.high:.3f}]), {100 * c.inside:.0f} % of {c.updates} "
        f"updates inside their own band, lag-one correlation of the force innovation "
        f"{c.whiteness:.2f}.",
        f"Covariances × {found.memory.repeated:.2f} for errors that come back in every gait cycle."
        + (
            f" Total force and moments count up to {found.memory.band_hz:.1f} Hz: above that the "
            "motion's errors repeat with the steps."
            if found.memory.band_hz < np.inf
            else ""
        ),
        f"{found.taught[0]} of {found.taught[1]} updates taught "
        "something; the others changed nothing.",
        f"Delay compensated {1e3 * delay_s:g} ms."
        + (
            f" Window: {found.rule.samples} samples every {found.rule.every}, "
            f"{found.rule.iterations} Gauss-Newton iterations (NAO CoP self-calibration, eq. 14)."
            if found.weights
            else " --compare runs the methods window and static as well."
        ),
    )


def rmse_of(found: Comparison) -> RmseRecord:
    """Errors of every method against every reference, per axis and for the vector."""
    rows = []
    for one in found.judged:
        for quantity, sums in one.whole.items():
            if sums.count:
                rows.append(
                    RmseRow(
                        quantity=quantity, unit="N" if quantity == "vgrf" else "m",
                        stage=one.method, reference=one.reference, split="all",
                        rmse=one.rms(quantity), n=int(sums.count),
                    )
                )  # fmt: skip
    return RmseRecord(rows=tuple(rows), rejected=dict(found.rejected))


def pictures_of(
    found: Comparison,
    curves: Sequence[tuple[str, Sensitivity]],
    robot: Robot,
    span_s: tuple[float, float] | None = None,
) -> tuple[Picture, ...]:
    """All figures; CoP and force over `span_s`, or the last seconds."""
    track, memory = found.memory.track, found.memory
    outlines = {name: foot.outline_m for name, foot in robot.feet.items()}
    feet = {
        name: (cells, outlines[name])
        for name, cells in zip(robot.feet, cells_in_feet(robot), strict=True)
    }
    judged = [m for m in SHOWN if m in found.replayed]
    drawn = tuple(m for m in ("static", "window", "memory") if m in found.replayed)
    if len(drawn) == 1:
        drawn = ("before", *drawn)
    against = _AGAINST[found.best_reference]
    states = [n for n in STATE_UNITS if n in track.names]
    states += [n for n in track.names if n.endswith("plate_weight")]
    pictures = [
        Picture("cop", lambda: plots.plot_cop(found, drawn, span_s),
                f"Centre of pressure; black: {against} (compare Figs. 10, 12 and 14 of NAO CoP "
                "self-calibration).",
            title="Centre of pressure by method", zoom=True),
        Picture("vgrf", lambda: plots.plot_vgrf(found, drawn, span_s),
                f"Vertical force; black: {against} (compare Figs. 11, 13, 15 of NAO CoP "
                "self-calibration).",
            title="Vertical force by method", zoom=True),
        Picture("cycles", lambda: plots.plot_cycles(found, judged),
                f"Error of every gait cycle against {_AGAINST[found.best_reference]}.",
            title="Error per gait cycle by method", zoom=True),
        Picture("path", lambda: plots.plot_path(found, "memory", feet),
                "CoP under each foot with its cells and outline; where there is no contact there "
                "is no point.",
            title="Path of the centre of pressure under each foot"),
        Picture("parameters", lambda: plots.plot_parameters(track, memory.jumps, ("bias", "gain")),
                "Every cell's bias and gain on top of the prior with ± 2 sd; dashed: a jump.",
            title="Bias and gain of each cell along the walk", zoom=True),
        Picture("innovations", lambda: plots.plot_innovations(track, ("fz", "mx", "my")),
                "What each update did not expect, over its claimed sd: 95 % should lie in the "
                "grey band, without a pattern.",
            title="Innovations in units of their predicted sd", zoom=True),
    ]  # fmt: skip
    if states:
        pictures.append(
            Picture("states", lambda: plots.plot_states(track, states, STATE_UNITS),
                    "What was wrong with the body stream and the feet; the delay is on top of "
                    f"{1e3 * memory.delay_s:.1f} ms found first.",
                title="Errors of the body stream along the walk", zoom=True)
        )  # fmt: skip
    if curves:
        pictures.append(
            Picture("sensitivity", lambda: plots.plot_sensitivity(curves),
                    "How much each weight and noise matters (NAO CoP self-calibration, section "
                    "3.3.2), the first "
                    "5 s left out.",
                title="Sensitivity to weights and noise settings")
        )  # fmt: skip
    return tuple(pictures)


def sensitivity_frame(curves: Sequence[tuple[str, Sensitivity]]) -> dict[str, object]:
    """``sensitivity.parquet``: one row per method, setting and factor."""
    size = [curve.factors.size for _, curve in curves]
    return {
        "method": np.repeat([method for method, _ in curves], size),
        "setting": np.repeat([curve.setting for _, curve in curves], size),
        "factor": np.concatenate([curve.factors for _, curve in curves]),
        "cop_rmse_m": np.concatenate([curve.cop_m for _, curve in curves]),
        "vgrf_rmse_n": np.concatenate([curve.vgrf_n for _, curve in curves]),
    }


def frames_of(found: Comparison) -> Iterator[dict[str, object]]:
    """``replay.parquet`` in pieces: per sample forces, CoP, parameters, sd, validity, reason."""
    for start in range(0, len(found.memory.log), _PIECE_ROWS):
        yield _frame_of(found, slice(start, start + _PIECE_ROWS))


def _frame_of(found: Comparison, part: slice) -> dict[str, object]:
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
