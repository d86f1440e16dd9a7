"""`online-replay` on load cells: report, verdict and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.online.comparison import ReplayedWalk
from footcal_cli.core.online.filter import Track
from footcal_cli.core.study.sensitivity import Sensitivity
from footcal_cli.core.study.walk import PaperMethods
from footcal_cli.intake.cell_effects import cells_in_feet
from footcal_cli.plots import walk as plots
from footcal_cli.plots.forces import FootOutline, along_the_foot
from footcal_cli.recipe import Robot
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, number, plural, with_sd
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.streams import stream_findings
from footcal_cli.sheets.walk_tables import (
    AGAINST,
    STATE_UNITS,
    in_words,
    p_in_words,
    sensitivity_columns,
    sheets_of,
)

if TYPE_CHECKING:
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.recipe.options import OnlineReplayOptions

POOR_COP_MM, POOR_SHARE = 20.0, 0.05
"""Errors of the CoP, and of the vertical force over the weight, that no good calibration leaves."""
SHOWN = ("before", "static", "window", "memory", "smoother")


def outcome_of(
    found: ReplayedWalk,
    papers: PaperMethods | None,
    curves: Sequence[tuple[str, Sensitivity]],
    robot: Robot,
    recording: Recording,
    options: OnlineReplayOptions,
) -> Outcome:
    """What the replay of a walk on load cells found, without its samples."""
    return Outcome(
        title=f"Walking calibration of {robot.name}, {recording.name}",
        verdict=verdict_of(found, options.method, robot.mass_share_sd),
        pictures=pictures_of(found, curves, robot, options.picture_span_s),
        sheets=sheets_of(found, papers),
        findings=tuple(stream_findings(recording)),
        footer=footer_of(found, papers, options.delay_s),
        rmse=rmse_of(found),
        tables={"sensitivity.parquet": sensitivity_columns(curves)} if curves else {},
        stage=options.method,
        reference=found.best_reference,
    )


def verdict_of(found: ReplayedWalk, method: str, mass_sd: float) -> VerdictRecord:
    """The first sentence and what it rests on; `mass_sd`: of the stated mass, a share of it."""
    reference = found.best_reference
    before, after = (found.of(m, reference) for m in ("before", method))
    cop = [1e3 * one.rms("cop") for one in (before, after)]
    force = [one.rms("vgrf") for one in (before, after)]
    alarms = sum(jump.sure for jump in found.memory.jumps)
    actions: list[str] = []
    details = []
    for other in ("window", "static"):
        if other == method or (other, reference, "cop") not in found.ratios:
            continue
        ratio, p = found.ratios[other, reference, "cop"]
        details.append(
            f"CoP error {in_words(ratio)} × that of {_METHODS[other]} over {ratio.n} gait cycles "
            f"(Wilcoxon p {'' if p < 0.001 else '= '}{p_in_words(p)})."
            if method == "memory"
            else f"The estimator with memory has {in_words(ratio)} × the CoP error of "
            f"{_METHODS[other]} on this walk."
        )
    states = found.memory.track
    errors = []
    if "robot.delay" in states.names:
        late, sd = states.at_end("robot.delay")
        late = 1e3 * (late + found.memory.delay_s)
        errors.append(f"body stream {with_sd(late, 1e3 * sd)} ms later than compensated")
    for axis in "xy":
        name = f"robot.com_correction_{axis}"
        if name in states.names:
            value, sd = states.at_end(name)
            errors.append(f"CoM {axis} off by {with_sd(1e3 * value, 1e3 * sd)} mm")
    if errors:
        details.append(f"Found along the way: {'; '.join(errors)}.")
    details += [
        f"{jump.name.removesuffix('.bias')}: bias jumped by {number(jump.size, 2)} N at "
        f"{jump.onset_s:.2f} s."
        for jump in found.memory.jumps
        if jump.sure
    ]
    alarms += len(found.weighed.findings())
    if method == "memory":
        shared = number(100.0 * found.weighed.shared_sd(mass_sd), 2)
        details.append(
            f"All scales rest on mass_kg: they share an error of ± {shared} % (1 sd), which the sd "
            "in parameters.json contain; mass_sd_kg in [robot] says how well it is known."
        )
    worse = cop[1] > cop[0]
    known = found.merged.log.known
    if not (cop[1] < POOR_COP_MM and force[1] < POOR_SHARE * found.merged.weight_n):
        actions.append("Run diagnose: the residual is large, so something is not in the model.")
        alarms += 1
    if not np.any(known["angmom_rate_nm"]):
        actions.append(
            "Log angmom_rate_x_nm and angmom_rate_y_nm from the robot's model: the rate of "
            "angular momentum was estimated from the body's motion, and scales may be off by more "
            "than their sd."
        )
        alarms += 1
    consistent = found.consistency.as_claimed
    return VerdictRecord(
        level="good" if consistent and not alarms and not worse else "warning",
        sentence=f"CoP error {number(cop[0], 3)} → {number(cop[1], 3)} mm, error of the vertical "
        f"force {number(force[0], 3)} → {number(force[1], 3)} N (RMS over the walk) against "
        f"{AGAINST[reference]}, by {_METHODS[method]}.",
        actions=tuple(actions),
        details=tuple(details),
    )


_METHODS = {
    "memory": "the filter with memory",
    "smoother": "the smoother",
    "window": "the sliding window",
    "static": "the zero-acceleration assumption",
}


def _how_run(found: ReplayedWalk) -> str:
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
            f"Live: filtered, and learnt after 8, 16, 32 … s{first}, from the past alone; the "
            f"latency of the low-pass is not counted as an error.{parts}"
        )
    return (
        f"After the fact: delay, noise and uncertain states are learnt {taught}, the low-pass has "
        f"no lag; --causal runs as a robot would.{parts}"
    )


def footer_of(found: ReplayedWalk, papers: PaperMethods | None, delay_s: float) -> tuple[str, ...]:
    """What was assumed, for those who want to repeat it."""
    c = found.consistency
    return (
        _how_run(found),
        f"Normalised innovation squared {c.ratio:.3f} (95 % band for the number of independent "
        f"ones [{c.low:.3f}, {c.high:.3f}]), {100 * c.inside:.0f} % of {c.updates} "
        f"updates inside their own band, lag-one correlation of the force innovation "
        f"{c.whiteness:.2f}.",
        "Errors that repeat in every gait cycle widen all covariances "
        f"{found.memory.repeated:.2f} times."
        + (
            f" Total force and moments count up to {found.memory.band_hz:.1f} Hz: above that the "
            "motion's errors repeat with the steps."
            if found.memory.band_hz < np.inf
            else ""
        ),
        f"{found.taught[0]:,} of {found.taught[1]:,} updates changed the estimate.",
        f"Delay compensated {1e3 * delay_s:g} ms."
        + (
            f" Window: {papers.rule.samples} samples every {papers.rule.every}, up to "
            f"{papers.rule.iterations} Gauss-Newton iterations (NAO CoP self-calibration, eq. 14)."
            if papers is not None and papers.windowed
            else " --compare runs the methods window and static as well."
        ),
    )


def rmse_of(found: ReplayedWalk) -> RmseRecord:
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
    found: ReplayedWalk,
    curves: Sequence[tuple[str, Sensitivity]],
    robot: Robot,
    span_s: tuple[float, float] | None = None,
) -> tuple[Picture, ...]:
    """All figures; CoP and force over `span_s`, or the last seconds."""
    feet = {
        name: FootOutline(cells, robot.feet[name].outline_m)
        for name, cells in zip(robot.feet, cells_in_feet(robot), strict=True)
    }
    path = Picture(
        "path", lambda: plots.plot_path(found, feet),
        "CoP under each foot with its cells and outline; where there is no contact there "
        "is no point.",
        title="Path of the centre of pressure under each foot",
        result=lambda: _paths(found, feet),
    )  # fmt: skip
    return (*_errors_drawn(found, span_s), path, *_tracks_drawn(found), *_sensitivity_drawn(curves))


def _errors_drawn(found: ReplayedWalk, span_s: tuple[float, float] | None) -> tuple[Picture, ...]:
    """CoP and vertical force by each method, and their errors cycle by cycle."""
    judged = [m for m in SHOWN if m in found.replayed]
    drawn = tuple(m for m in ("static", "window", "memory") if m in found.replayed)
    if len(drawn) == 1:
        drawn = ("before", *drawn)
    against = AGAINST[found.best_reference]
    return (
        Picture("cop", lambda: plots.plot_cop(found, drawn, span_s),
                f"Left: centre of pressure; thickest line: {against}. Right: method − {against}; "
                f"{drawn[0]} is left out there, its error would hide the others (compare Figs. 10, "
                "12 and 14 of NAO CoP self-calibration).",
            title="Centre of pressure by method",
            result=_by_method(found, judged, "cop", 1e3, "mm"),
            zoom=True),
        Picture("vgrf", lambda: plots.plot_vgrf(found, drawn, span_s),
                f"Vertical force; thickest line: {against} (compare Figs. 11, 13, 15 of NAO CoP "
                "self-calibration).",
            title="Vertical force by method", result=_by_method(found, judged, "vgrf", 1.0, "N"),
            zoom=True),
        Picture("cycles", lambda: plots.plot_cycles(found, judged),
                f"Error of every gait cycle against {against}.",
            title="Error per gait cycle by method",
            result=_by_method(found, judged, "cop", 1e3, "mm"), zoom=True),
    )  # fmt: skip


def _tracks_drawn(found: ReplayedWalk) -> tuple[Picture, ...]:
    """What was estimated along the walk."""
    track, memory = found.memory.track, found.memory
    states = [n for n in STATE_UNITS if n in track.names]
    states += [n for n in track.names if n.endswith(("plate_weight", "plate_mass"))]
    found_first = {"robot.delay": memory.delay_s}
    errors = Picture(
        "states", lambda: plots.plot_states(track, states, STATE_UNITS, found_first),
        "Estimated errors of the body stream and the feet.",
        title="Errors of the body stream along the walk",
        result=lambda: _states_at_end(track, states, found_first), zoom=True,
    )  # fmt: skip
    return (
        Picture("parameters", lambda: plots.plot_parameters(track, memory.jumps, ("bias", "gain")),
                "Every cell's bias and gain on top of the prior with ± 2 sd; dashed: a jump.",
            title="Bias and gain of each cell along the walk",
            result=lambda: _known_to(track, len(memory.jumps)), zoom=True),
        Picture("innovations", lambda: plots.plot_innovations(track, ("fz", "mx", "my")),
                "Difference between each update and its prediction, over its predicted sd: 95 % "
                "should lie in the grey band, without a pattern.",
            title="Innovations in units of their predicted sd",
            result=lambda: plots.within_band(track, 3),
            zoom=True),
        *((errors,) if states else ()),
    )  # fmt: skip


def _sensitivity_drawn(curves: Sequence[tuple[str, Sensitivity]]) -> tuple[Picture, ...]:
    picture = Picture(
        "sensitivity", lambda: plots.plot_sensitivity(curves),
        "How much each weight and noise matters (NAO CoP self-calibration, section 3.3.2), the "
        "first 5 s left out.",
        title="Sensitivity to weights and noise settings",
        result=lambda: _most_sensitive(curves),
    )  # fmt: skip
    return (picture,) if curves else ()


def _by_method(
    found: ReplayedWalk, methods: Sequence[str], quantity: str, factor: float, unit: str
) -> str:
    """RMS error of a quantity by every method that was judged."""
    rms = {m: factor * found.of(m, found.best_reference).rms(quantity) for m in methods}
    return f"RMS error: {', '.join(f'{m} {number(v, 3)} {unit}' for m, v in rms.items())}."


def _paths(found: ReplayedWalk, feet: Mapping[str, FootOutline]) -> str:
    """How long the path of the CoP under each foot is."""
    return along_the_foot(
        {
            name: plots.cop_in_foot(found, "memory", k, name, foot.cells_m)
            for k, (name, foot) in enumerate(feet.items())
        }
    )


def _known_to(track: Track, jumps: int) -> str:
    """How well biases and gains are known at the end."""
    words = []
    for kind, factor, unit in (("bias", 1.0, "N"), ("gain", 100.0, "%")):
        sd = [s for n, s in zip(track.names, track.sd[-1], strict=True) if n.endswith(f".{kind}")]
        if sd:
            words.append(f"every {kind} to ± {number(factor * float(max(sd)), 2)} {unit}")
    return f"Known at the end: {', '.join(words)} or better; {plural(jumps, 'jump')}."


def _states_at_end(track: Track, names: Sequence[str], on_top_of: Mapping[str, float]) -> str:
    """Every error of the body stream at the end of the walk."""
    words = []
    for name in names:
        factor, unit = STATE_UNITS.get(name, (1.0, track.units[track.names.index(name)]))
        value, sd = track.at_end(name)
        value += on_top_of.get(name, 0.0)
        words.append(f"{plots.state_in_words(name)} {with_sd(factor * value, factor * sd)} {unit}")
    return f"At the end: {'; '.join(words)}."


def _most_sensitive(curves: Sequence[tuple[str, Sensitivity]]) -> str:
    """The setting that changes the CoP error most."""
    method, worst = max(curves, key=lambda one: float(np.ptp(one[1].cop_m)))
    return (
        f"{worst.setting} of {method} matters most: CoP error from "
        f"{number(1e3 * float(worst.cop_m.min()), 3)} to "
        f"{number(1e3 * float(worst.cop_m.max()), 3)} mm."
    )
