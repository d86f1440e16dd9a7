"""What the ladder of channel models found, as tables, sentences and records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.bench.changes import ParameterChange
from footcal_cli.core.bench.channel import ChannelFit
from footcal_cli.core.bench.hands import wrong_until
from footcal_cli.core.bench.regression import Curvature
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.core.effects import TABLE
from footcal_cli.records.display_units import display_unit
from footcal_cli.records.results import RmseRow, VerdictRecord
from footcal_cli.report import Sheet, number, with_sd
from footcal_cli.sheets.moved_zeros import zero_sentences, zeros_alone, zeros_verdict
from footcal_cli.sheets.weights import (
    NEXT_RECORDING,
    curvature_sentence,
    force_row,
    inadequate,
    misfit_sentences,
)

_MOST_ROWS = 120
NOTABLE_P = 0.01
"""A change since the last calibration is named in the verdict below this corrected p-value."""


def size_words(fit: ChannelFit) -> list[str]:
    """Each term's size with sd, hysteresis in % of full scale too."""
    words, called = [], Counter(term.size for term in fit.terms)
    full_scale = max(abs(fit.load_range_n[0]), abs(fit.load_range_n[1]))
    for term in fit.terms:
        name = f"{fit.channel}{term.owner}.{term.size}"
        value, sd = fit.estimates[name], fit.estimates.sd_of(name)
        text = f"{term.size.replace('_', ' ')} {with_sd(value, sd)} {term.unit}".rstrip(" -")
        if term.size == "hysteresis_width":
            text += f" ({100 * value / full_scale:.2f} % of full scale)"
        for shape, unit, grid in zip(term.shapes, term.shape_units, term.grids, strict=True):
            if called[term.size] > 1 and not term.free:  # which of them
                text += f" at {shape.replace('_', ' ')} {number(grid[0], 3)} {unit}"
            if term.free:
                full = f"{fit.channel}{term.owner}.{shape}"
                low, high = fit.ci95[fit.estimates.names.index(full)]
                text += (
                    f", {shape.replace('_', ' ')} {number(fit.estimates[full], 3)} {unit} "
                    f"[{number(low, 3)}, {number(high, 3)}]"
                )
        words.append(text)
    return words


def study_sentence(study: ChannelStudy) -> str | None:
    """What a channel is beyond scale and bias, and what that does to the affine scale."""
    ladder = study.ladder
    if ladder is None or not ladder.rungs:
        return None
    before, after = ladder.rows[0].held_out_rmse_n, ladder.held_out.rmse
    text = (
        f"{study.channel}: {'; '.join(size_words(ladder.chosen))}. Held-out error "
        f"{number(before, 3)} → {number(after, 3)} N"
    )
    if ladder.rivals:
        text += f" ({' or '.join(ladder.rivals)} would explain it as well{_separating(study)})"
    if is_curved(study):
        return f"{text}; a straight line bows by {100 * study.affine.bow:.1f} % of the span."
    error = f"{100 * ladder.affine_scale_error:+.2f}".replace("-", "−")
    return (
        f"{text}; because of it the affine scale is off by {error} % and its reading at mid-range "
        f"by {number(ladder.affine_bias_error_n, 2)} N."
    )


def _separating(study: ChannelStudy) -> str:
    """The experiment that tells the first term from its rivals, by the table of effects."""
    terms = study.fit.terms if study.fit is not None else ()
    effect = TABLE.get(terms[0].effect) if terms else None
    return (
        f"; {effect.separates} would distinguish them"
        if effect is not None and effect.separates
        else ""
    )


def is_curved(study: ChannelStudy) -> bool:
    """Whether the chosen model is curved: its scale is then the slope at no load."""
    fit = study.fit
    powers = ("quadratic", "cubic", "power_4", "power_5", "power_6")
    return fit is not None and any(term.size in powers for term in fit.terms)


def creep_sentence(study: ChannelStudy) -> str | None:
    """Time constants of creep seen in the holds and what waiting does to the scale."""
    found, waiting = study.relaxation, study.waiting
    if found is None or not np.any(np.abs(found.amplitude) > 3.0 * found.amplitude_sd):
        return None
    times = " and ".join(
        f"{tau:.0f} s [{low:.0f}, {high:.0f}]"
        for tau, (low, high) in zip(found.tau_s, found.tau_ci95_s, strict=True)
    )
    text = f"{study.channel}: creeps within its holds, time constant {times} (95 %)"
    if waiting is None:
        return f"{text}."
    finite = np.flatnonzero(np.isfinite(waiting.wait_s))
    last = finite[-1]
    change = f"{100 * waiting.change[last]:+.2f}".replace("-", "−")
    text += (
        f"; reading every load after {waiting.wait_s[last]:.0f} s instead of "
        f"{waiting.wait_s[0]:.0f} s changes the scale by {change} %"
    )
    if np.isinf(waiting.wait_s[-1]):
        final = f"{100 * waiting.change[-1]:+.2f}".replace("-", "−")
        text += f", waiting for ever by {final} %"
    return f"{text}."


def late_sentence(study: ChannelStudy, tolerance_n: float) -> str | None:
    """Errors in the first seconds of loads alone: the weight came later than its number."""
    record = study.record
    if study.samples is None or np.unique(record.session).size > 1:
        return None
    known = record.known
    rows = (record.time_s[known], record.load_n[known], record.reading[known])
    until = wrong_until(*rows, tolerance_n)
    if until is None:
        return None
    return (
        f"{study.channel}: errors above {number(tolerance_n, 2)} N lie in the first "
        f"{number(until, 2)} s after changes of load: of weights that came later than their "
        f"number plateaus.settle_s = {np.ceil(until + 1.0):.0f} in [offline_fit] leaves them out."
    )


def weights_verdict(
    studies: Sequence[ChannelStudy], curvature: Curvature | None, tolerance_n: float
) -> VerdictRecord:
    """Whether scale and bias describe the channels, and if not, what does."""
    extended = [study for study in studies if study.ladder is not None and study.ladder.rungs]
    plain = [study.affine for study in studies if study not in extended]
    bad = inadequate(plain, tolerance_n)
    moved = zeros_alone(studies, [fit.channel for fit in bad], tolerance_n)
    bad = [fit for fit in bad if fit.channel not in moved]
    details = [text for study in extended if (text := study_sentence(study))]
    details += misfit_sentences(bad) + zero_sentences(moved)
    details += [text for study in studies if (text := late_sentence(study, tolerance_n))]
    details += [text for study in studies if (text := creep_sentence(study))]
    bent = curvature_sentence([study.affine for study in studies], curvature)
    if extended:
        kinds = ", ".join(
            f"{model} in {sum(study.model == model for study in extended)}"
            for model in dict.fromkeys(study.model for study in extended)
        )
        left = [s.ladder.held_out.rmse for s in extended if s.ladder is not None]
        before = [s.ladder.rows[0].held_out_rmse_n for s in extended if s.ladder is not None]
        good = not bad and not moved and max(left) <= tolerance_n
        return VerdictRecord(
            level="good" if good else "warning",
            sentence=f"{_some(len(extended), len(studies))} more than a scale and a "
            f"bias ({kinds}): error on unseen data {number(float(np.median(before)), 2)} → "
            f"{number(float(np.median(left)), 2)} N.",
            details=tuple(details),
        )
    bare = [fit.channel for fit in plain if fit.load_n.size <= 2]
    if bare:
        return VerdictRecord(
            level="warning",
            sentence=f"Two readings fix scale and bias of {len(bare)} of the {len(studies)} "
            f"channels ({', '.join(bare)}): nothing shows their error.",
            actions=("Weigh at three loads or more, each of them twice.",),
            details=tuple(details),
        )
    if moved and not bad:
        return zeros_verdict(moved, _share(len(moved), len(studies)), details)
    if not bad:
        worst = max((study.affine for study in studies), key=lambda fit: fit.worst_n)
        return VerdictRecord(
            level="good",
            sentence=f"A scale and a bias describe {_all(len(studies))}: largest error "
            f"{number(worst.worst_n, 2)} N ({worst.channel}).",
            details=tuple(details),
        )
    if bent is not None:
        details.append(bent)
    return VerdictRecord(
        level="warning",
        sentence=f"The affine model does not fit {_share(len(bad), len(studies))}: errors "
        f"up to {number(bad[0].worst_n, 2)} N ({bad[0].channel}).",
        actions=(NEXT_RECORDING,),
        details=tuple(details),
    )


def _all(channels: int) -> str:
    return "the only channel" if channels == 1 else f"all {channels} channels"


def _share(some: int, channels: int) -> str:
    if channels == 1:
        return "the only channel"
    if some == channels == 2:
        return "both channels"
    return f"all {channels} channels" if some == channels else f"{some} of the {channels} channels"


def _some(some: int, channels: int) -> str:
    subject = _share(some, channels)
    return f"{subject[:1].upper()}{subject[1:]} {'needs' if some == 1 else 'need'}"


def model_sheet(studies: Sequence[ChannelStudy]) -> Sheet:
    """One row per channel: the model in use and what it is worth on data it has not seen."""
    rows, greyed = [], set()
    for i, study in enumerate(studies):
        ladder = study.ladder
        if ladder is None:
            greyed.add(i)
            rows.append((study.channel, "affine", "too few rows", "–", "–", "–", "–", "–"))
            continue
        chosen, extended = ladder.chosen, ladder.model != "affine"
        scale_error = f"{100 * ladder.affine_scale_error:+.3f}".replace("-", "−")
        rows.append(
            (
                study.channel,
                ladder.model,
                f"{ladder.groups} {'sessions' if ladder.by_session else 'loads'}",
                number(ladder.rows[0].held_out_rmse_n, 3),
                number(ladder.held_out.rmse, 3) if extended else "–",
                number(chosen.sd_within_n, 2),
                number(chosen.sd_between_n, 2) if chosen.sessions > 1 else "–",
                "curved" if is_curved(study) else scale_error if extended else "–",
            )
        )
    return Sheet(
        "Model of each channel",
        ("channel", "model", "left out in turn", "affine, held out (N)", "model, held out (N)",
         "scatter (N)", "between sessions (N)", "affine scale off by (%)"),
        rows,
        note="A model is extended where it beats the simpler one by more than one standard error "
        "on left-out sessions (three or more) or loads, and its sizes are not zero. With one "
        "session nothing is known of changes from session to session, and intervals do not "
        "contain them.",
        greyed=frozenset(greyed),
    )  # fmt: skip


def tried_sheet(studies: Sequence[ChannelStudy]) -> Sheet | None:
    """Every model tried on every channel."""
    factor, unit = display_unit("N²")
    rows = [
        (
            study.channel,
            row.model,
            str(row.coefficients),
            number(row.rmse_n, 3),
            number(row.held_out_rmse_n, 3),
            with_sd(factor * row.gain_n2, factor * row.gain_sd_n2) if row.gain_sd_n2 else "–",
            number(row.p_value, 2),
            row.why,
        )
        for study in studies
        if study.ladder is not None
        for row in study.ladder.rows
    ]
    if not rows:
        return None
    more = f" The first {_MOST_ROWS} of {len(rows)}." if len(rows) > _MOST_ROWS else ""
    return Sheet(
        "Models tried",
        ("channel", "model", "numbers", "fitted (N)", "held out (N)", f"gain ({unit})", "p", "why"),
        rows[:_MOST_ROWS],
        note="Gain: mean squared held-out error of the model below it minus its own, ± one "
        "standard error over the groups left out. What is not significant is not taken, however "
        f"well it predicts: its held-out error is not computed.{more}",
    )


def creep_sheet(studies: Sequence[ChannelStudy]) -> Sheet | None:
    """Time constants of holds and the scale after several waiting times."""
    rows = []
    for study in studies:
        if study.relaxation is not None:
            found = study.relaxation
            for k, tau in enumerate(found.tau_s):
                low, high = found.tau_ci95_s[k]
                largest = int(np.argmax(np.abs(found.amplitude[:, k])))
                amplitude = with_sd(
                    float(found.amplitude[largest, k]), float(found.amplitude_sd[largest, k])
                )
                rows.append(
                    (
                        study.channel,
                        f"time constant {k + 1}",
                        f"{number(float(tau), 3)} s",
                        f"[{number(float(low), 3)}, {number(float(high), 3)}] s"
                        + ("" if found.resolved[k] else " (at the edge of what the holds show)"),
                        f"largest amplitude {amplitude} counts",
                    )
                )
        if study.waiting is not None:
            per_count, unit = display_unit("N/count", study.waiting.scale)
            for wait, scale, change in zip(
                study.waiting.wait_s, study.waiting.scale, study.waiting.change, strict=True
            ):
                when = "level the creep tends to" if np.isinf(wait) else f"read after {wait:.0f} s"
                rows.append(
                    (
                        study.channel,
                        when,
                        f"scale {number(per_count * float(scale), 5)} {unit}",
                        f"{100 * change:+.2f} %".replace("-", "−"),
                        f"{study.waiting.loads} loads",
                    )
                )
    if not rows:
        return None
    return Sheet(
        "Creep",
        ("channel", "what", "value", "95 % interval or change", "of"),
        rows,
        note="Time constants from the shape of each hold alone: neither the loads nor what "
        "happened between them enter. The scale depends on how long one waits before reading.",
    )


def change_sheet(changes: Sequence[ParameterChange], since: str) -> Sheet:
    """Parameters then and now."""
    rows = [
        (
            change.name,
            number(change.before, 6),
            number(change.now, 6),
            change.unit,
            f"{change.in_earlier_sd:+.1f}".replace("-", "−"),
            f"{change.in_joint_sd:+.1f}".replace("-", "−"),
            number(change.p_value, 2),
        )
        for change in changes
    ]
    return Sheet(
        f"Changes since {since}",
        ("parameter", "then", "now", "unit", "in its earlier sd", "in sd of the change", "p"),
        rows,
        note="p: chance of such a shift where nothing changed, corrected for the number of "
        "parameters (Holm).",
    )


def held_out_rows(studies: Sequence[ChannelStudy]) -> list[RmseRow]:
    """Held-out errors of the straight line and of the chosen model."""
    rows = []
    for study in studies:
        if study.ladder is None:
            continue
        out = study.ladder.held_out
        affine = study.ladder.rows[0].held_out_rmse_n
        rows.append(
            RmseRow(
                quantity=f"force {study.channel}", unit="N", stage="affine",
                reference="known load", split="held_out", rmse=affine, n=out.error.size,
            )
        )  # fmt: skip
        rows.append(force_row(study.channel, "after", out.error, "held_out"))
    return rows
