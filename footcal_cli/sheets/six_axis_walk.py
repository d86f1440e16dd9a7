"""Verdict, tables and figures of `online-replay` on six-axis feet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.effects.transport import DELAY
from footcal_cli.core.online.evidence import departures
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.replay import held_until_next
from footcal_cli.core.online.six_axis import KNOWN_MASS, MASS_STATE
from footcal_cli.core.online.six_axis_replay import SixAxisReplay
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import root_mean_square
from footcal_cli.intake.recordings import Recording
from footcal_cli.plots import six_axis_walk as plots
from footcal_cli.plots.walk import plot_innovations, within_band
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, plural, with_sd
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.stand import beliefs_sheet, unit_of
from footcal_cli.sheets.streams import stream_findings

_SURPRISING_SHARE = 0.02
_SHARED_SCALE, _SURE = 0.01, 4.0
"""Part that the vertical scales of all feet must share, and its size in sd, to be reported."""
_WIDENED = 1.5
_NOTABLE_DELAY_S = 0.005


def _unit_of(name: str) -> str:
    return "Nm" if name.rsplit("_", 1)[-1][0] == "t" else "N"


POOR_SHARE = 0.05
"""Error of the vertical force over the weight that no good calibration leaves."""


def _column(found: SixAxisReplay, name: str) -> tuple[float, float]:
    """Value and sd of one estimate at the end."""
    return found.estimates[name], found.estimates.sd_of(name)


def feet_of(found: SixAxisReplay) -> tuple[str, ...]:
    """Names of the feet."""
    return tuple(dict.fromkeys(n.split(".")[0] for n in found.rows.outputs[found.rows.totals :]))


def outcome_of(found: SixAxisReplay, robot: str, recording: Recording) -> Outcome:
    """What the replay of a walk on six-axis feet found."""
    return Outcome(
        title=f"Walking calibration of {robot}, {recording.name}",
        verdict=verdict_of(found),
        pictures=pictures_of(found),
        sheets=sheets_of(found),
        findings=(*stream_findings(recording), *findings_of(found)),
        footer=footer_of(found),
        rmse=rmse_of(found),
        tables={"replay.parquet": columns_of(found)},
        stage="memory",
    )


def verdict_of(found: SixAxisReplay) -> VerdictRecord:
    """The first sentence and what it rests on."""
    before, after = (root_mean_square(e[:, 2]) for e in (found.before, found.after))
    details = []
    for foot in feet_of(found):
        offsets = [_column(found, f"{foot}.offset_{axis}") for axis in ("fx", "fy", "fz")]
        text = ", ".join(
            f"{axis} {with_sd(*value)}"
            for axis, value in zip(("fx", "fy", "fz"), offsets, strict=True)
        )
        at = [i for i, n in enumerate(found.rows.outputs) if n.startswith(f"{foot}.f")]
        residual = [root_mean_square(e[:, at]) for e in (found.before, found.after)]
        details.append(
            f"{foot}: offsets {text} N; in the air its force is off by {number(residual[0], 3)} → "
            f"{number(residual[1], 2)} N."
        )
    model = f"{found.merged.log.known['mass_kg'][0]:.4g} kg"
    if MASS_STATE in found.estimates.names:
        mass, sd = _column(found, MASS_STATE)
        details.append(f"The feet carry {with_sd(mass, sd)} kg more than the model's {model}.")
    else:
        details.append(
            f"The scales are relative to the stated mass of {model}, taken as known to "
            f"{100 * KNOWN_MASS:.1g} %."
        )
    heavier, sure = _all_vertical_scales(found)
    actions: tuple[str, ...] = ()
    if sure:
        actions = (
            f"Weigh the robot: both feet ask for {with_sd(100 * heavier[0], 100 * heavier[1])} % "
            f"on their vertical forces, so it does not weigh {model}, or both transducers are off.",
        )
    gone = scales_gone(found.track, found.rows.prior_sd)
    if gone:
        actions = (
            *actions,
            f"Do not use {', '.join(gone)}: no transducer is that far off. Check its calibration "
            "matrix, or walk faster: noise of the readings pulls a scale whose axis hardly moves.",
        )
    details += [
        f"{jump.name}: jumped by {with_sd(jump.size, jump.sd)} {_unit_of(jump.name)} at "
        f"{jump.onset_s:.2f} s, known {jump.found_s - jump.onset_s:.2f} s later."
        for jump in found.jumps
    ]
    known = sum(s is Status.ESTIMATED for s in found.estimates.status)
    consistent = found.consistency.as_claimed
    small = after < POOR_SHARE * found.merged.weight_n
    return VerdictRecord(
        level="good"
        if consistent and small and after < before and not sure and not gone
        else "warning",
        sentence=f"Total vertical force off by {number(before, 3)} → {number(after, 3)} N; "
        f"{known} of {len(found.estimates.names)} unknowns of the feet estimated.",
        actions=actions,
        details=tuple(details),
    )


def scales_gone(track: Track, prior_sd: FloatArray) -> tuple[str, ...]:
    """Scales that end outside of three prior sd by more than their own sd, (p,)."""
    return tuple(one.name for one in departures(track, prior_sd) if ".scale_" in one.name)


def _all_vertical_scales(found: SixAxisReplay) -> tuple[tuple[float, float], bool]:
    """What the vertical scales of all feet have in common, its sd, and whether it is sure."""
    at = [i for i, name in enumerate(found.estimates.names) if name.endswith(".scale_fz")]
    if not at:
        return (0.0, 0.0), False
    shared = float(found.estimates.values[at].mean())
    sd = float(np.sqrt(found.estimates.covariance[np.ix_(at, at)].mean()))
    return (shared, sd), abs(shared) > max(_SHARED_SCALE, _SURE * sd)


def sheets_of(found: SixAxisReplay) -> tuple[Sheet, ...]:
    """All tables."""
    e = found.estimates
    rows = []
    for i, name in enumerate(found.rows.outputs):
        unit = unit_of(name)
        errors = [found.before[:, i], found.after[:, i]]
        rows.append(
            (name, unit, str(int(np.isfinite(errors[0]).sum())),
             *(number(float(np.nanmean(x)), 3) for x in errors),
             *(number(root_mean_square(x), 3) for x in errors))
        )  # fmt: skip
    return (
        beliefs_sheet(
            e.names, e.units, e.values, e.sd, found.rows.prior_sd, e.status,
            "Offsets are subtracted from the readings, scales in per cent of them; masses, weights "
            "and CoM on top of the recipe's. Estimated: the walk at least halved the sd.",
        ),
        Sheet(
            "Balance before and after",
            ("row", "unit", "samples", "mean before", "mean after", "RMS before", "RMS after"),
            rows,
            note="Totals against the motion of the body; single axes against the weight below the "
            "transducer while that foot is in the air.",
        ),
    )  # fmt: skip


def findings_of(found: SixAxisReplay) -> Iterator[Finding]:
    """What does not fit this robot's model."""
    yield from _jumped(found)
    yield from _badly_explained(found)
    yield from _differing_body(found)
    yield from _scales_off(found)
    yield from found.consistency.findings()


def _jumped(found: SixAxisReplay) -> Iterator[Finding]:
    for jump in found.jumps:
        yield Finding(
            "offset_jump", "alarm" if jump.sure else "note", jump.name,
            f"the offset jumped by {with_sd(jump.size, jump.sd)} {_unit_of(jump.name)} at "
            f"{jump.onset_s:.2f} s (proved {jump.found_s - jump.onset_s:.2f} s later)",
            "check the transducer's cable and screws; before and after are calibrated apart",
        )  # fmt: skip


def _badly_explained(found: SixAxisReplay) -> Iterator[Finding]:
    """What the motion of the body explains badly: repeated errors, a delay, too poor a demand."""
    widened = max(found.inflated * found.repeated[0], found.inflated * found.repeated[1])
    if widened > _WIDENED:
        yield Finding(
            "model_wrong", "warning", "robot",
            f"errors of the totals repeat in every gait cycle ({found.repeated[0]:.1f} times the "
            f"variance of chance, of swinging feet {found.repeated[1]:.1f} times) and innovations "
            f"needed {found.inflated:.2f} times the learnt variance: intervals are widened by as "
            "much, for the robot's own model is wrong in a way that no noise describes",
            "run diagnose on these walks; log a better CoM, or an IMU",
        )  # fmt: skip
    if not found.delay_found:
        asked = ", ".join(
            f"{name} {1e3 * value:+.0f}"
            for name, value in zip(found.rows.outputs, found.delay_asked_s, strict=False)
        )
        yield Finding(
            "delay_not_found", "warning", "body stream",
            f"each total would move the body's stream by another time ({asked} ms): this is no "
            "delay but a motion that the feet did not feel, and nothing was taken out",
            "compare the model's CoM acceleration with an IMU",
        )  # fmt: skip
    elif abs(found.delay_s) > max(_NOTABLE_DELAY_S, 3 * found.delay_sd_s):
        yield Finding(
            DELAY.name, "warning", "body stream",
            f"the body's stream is {with_sd(1e3 * found.delay_s, 1e3 * found.delay_sd_s)} ms "
            "late beyond what the recipe compensates; it was taken out",
            "add it to delay_s in the recipe if several walks agree",
        )  # fmt: skip
    if not any(".scale_" in name for name in found.estimates.names):
        yield Finding(
            "scales_left_alone", "warning", "feet",
            f"the body's motion determines the force only to {found.demand_sd_n:.0f} N: scales "
            "were left at 1, a regression on so poor a demand would pull them to zero",
            "log the CoM from a better model, or an IMU; or set scales = true",
        )  # fmt: skip


def _differing_body(found: SixAxisReplay) -> Iterator[Finding]:
    """A mass and a CoM that are not the model's."""
    model = float(found.merged.log.known["mass_kg"][0])
    mass, sd = _column(found, MASS_STATE) if MASS_STATE in found.estimates.names else (0.0, 0.0)
    if abs(mass) > max(_SURPRISING_SHARE * model, 3 * sd):
        yield Finding(
            "mass_differs", "warning", "robot",
            f"the feet carry {model + mass:.1f} ± {sd:.1f} kg, the model has {model:.1f} kg "
            f"({100 * mass / model:+.1f} %), unless both vertical scales are off together",
            "weigh the robot with battery and payload",
        )  # fmt: skip
    for axis in "xy":
        value, sd = _column(found, f"robot.com_correction_{axis}")
        if abs(value) > max(0.005, 3 * sd):
            yield Finding(
                "com_differs", "warning", "robot",
                f"the CoM lies {1e3 * value:+.0f} ± {1e3 * sd:.0f} mm in {axis} from the model's",
                "correct the masses in the model, or level the IMU: they look alike here",
            )  # fmt: skip


def _scales_off(found: SixAxisReplay) -> Iterator[Finding]:
    for name, value, sd in zip(
        found.estimates.names, found.estimates.values, found.estimates.sd, strict=True
    ):
        kind = name.rsplit(".", 1)[-1]
        if kind.startswith("scale_") and abs(value) > max(0.03, 3 * sd):
            yield Finding(
                "scale_off", "warning", name,
                f"reads {100 * value:+.1f} ± {100 * sd:.1f} % too little",
                "check the transducer's calibration matrix and its axes",
            )  # fmt: skip


def rmse_of(found: SixAxisReplay) -> RmseRecord:
    """Errors before and after of every row of the balance."""
    rows = []
    for i, name in enumerate(found.rows.outputs):
        reference = "motion" if i < found.rows.totals else "weight below the transducer"
        for stage, errors in (("before", found.before), ("memory", found.after)):
            if np.isfinite(errors[:, i]).any():
                quantity = "vgrf" if name == "fz" else name
                rows.append(RmseRow.of(quantity, unit_of(name), stage, reference, errors[:, i]))
    return RmseRecord(rows=tuple(rows), rejected=found.merged.validity.counts)


def pictures_of(found: SixAxisReplay) -> tuple[Picture, ...]:
    """All figures."""
    return (
        Picture("vertical", lambda: plots.plot_vertical(found),
                "Total vertical force: what both feet read and what the body's motion demands.",
            title="Total vertical force: measured and demanded by the motion",
            result=lambda: _rms_words(found, ("fz",)), zoom=True),
        Picture("swing", lambda: plots.plot_swing(found),
                "A foot in the air should read only what hangs below its transducer.",
            title="Reading of each foot in the air",
            result=lambda: _rms_words(
                found, [n for n in found.rows.outputs[found.rows.totals :] if n.endswith("fz")]
            ), zoom=True),
        Picture("offsets",
                lambda: plots.plot_offsets(
                    found.track, found.smoothed, feet_of(found), found.jumps
                ),
                "Offsets along the walk: band ± 2 sd as known then, line with hindsight, dashed: a "
                "jump.",
            title="Offsets along the walk",
            result=lambda: _largest_offset(found), zoom=True),
        Picture("innovations", lambda: plot_innovations(found.track, found.rows.outputs[:5]),
                "Difference between each update and its prediction, over its predicted sd.",
            title="Innovations in units of their predicted sd",
            result=lambda: within_band(found.track, 5),
            zoom=True),
    )  # fmt: skip


def _rms_words(found: SixAxisReplay, outputs: Sequence[str]) -> str:
    """RMS error of some rows of the balance, before and after."""
    at = [found.rows.outputs.index(name) for name in outputs]
    before, after = (root_mean_square(errors[:, at]) for errors in (found.before, found.after))
    return f"RMS error {number(before, 3)} N before, {number(after, 3)} N calibrated."


def _largest_offset(found: SixAxisReplay) -> str:
    """The largest force offset at the end of the walk."""
    forces = [
        (abs(value), name, value, sd)
        for name, value, sd in zip(
            found.estimates.names, found.estimates.values, found.estimates.sd, strict=True
        )
        if ".offset_f" in name
    ]
    jumps = f"{plural(len(found.jumps), 'jump')}."
    if not forces:
        return jumps
    _, name, value, sd = max(forces)
    return f"Largest force offset at the end: {with_sd(value, sd)} N ({name}); {jumps}"


def footer_of(found: SixAxisReplay) -> tuple[str, ...]:
    """What was assumed."""
    c = found.consistency
    return (
        f"Normalised innovation squared {c.ratio:.3f}, {100 * c.inside:.0f} % of {c.updates} "
        "updates inside their own 95 % band; beyond the learnt noise all variances × "
        f"{found.inflated:.2f}, for errors that repeat with the gait × {found.repeated[0]:.1f} "
        f"(totals) and {found.repeated[1]:.1f} (swinging feet). Updates that changed nothing: "
        f"{int(np.sum(~found.track.used))}. Body stream late by {1e3 * found.delay_s:.1f} ± "
        f"{1e3 * found.delay_sd_s:.1f} ms beyond the recipe.",
        "Model: applied wrench = (1 + scale) · reading − offset per axis; totals balance the "
        "motion of the body, a foot in the air carries the weight below its transducer.",
    )


def columns_of(found: SixAxisReplay) -> dict[str, object]:
    """``replay.parquet``: calibrated wrenches, estimates, sd, validity and reason per sample."""
    log = found.merged.log
    n = len(log)
    frame: dict[str, object] = {"time_s": log.time_s}
    values = held_until_next(found.rows.last_sample, found.track.values, n)
    sd: FloatArray = held_until_next(found.rows.last_sample, found.track.sd, n)
    column = {name: i for i, name in enumerate(found.track.names)}
    for j, channel in enumerate(log.channels):
        foot, axis = channel.split(".")
        scale = (
            values[:, column[f"{foot}.scale_{axis}"]] if f"{foot}.scale_{axis}" in column else 0.0
        )
        offset = values[:, column[f"{foot}.offset_{axis}"]]
        unit = "n" if axis[0] == "f" else "nm"
        frame[f"{foot}_{axis}_{unit}"] = (1.0 + scale) * log.readings[:, j] - offset
    for k, foot in enumerate(feet_of(found)):
        frame[f"{foot}_contact"] = log.known["contact"][:, k]
    frame["vgrf_n"] = found.vertical_n[:, 1]
    frame["reference_vgrf_n"] = found.vertical_n[:, 2]
    for name, i in column.items():
        frame[name.replace(".", "_")] = values[:, i]
        frame[f"{name.replace('.', '_')}_sd"] = sd[:, i]
    frame["used"] = found.merged.validity.valid
    frame["reason"] = found.merged.validity.words()
    return frame
