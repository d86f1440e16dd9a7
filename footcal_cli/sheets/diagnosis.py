"""A diagnosis in words, tables and its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.engine import EffectRow, EffectStatus, Verdict, leftover
from footcal_cli.core.diagnosis.investigation import Found, Gain, Investigation
from footcal_cli.core.diagnosis.menu import Prospect, advice, prospects
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.diagnosis.problem import Signature
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import Interval
from footcal_cli.core.quality import Finding
from footcal_cli.records import (
    CauseRecord,
    DiagnosisRecord,
    EffectRowRecord,
    FindingRecord,
    HeldOutGain,
    VerdictRecord,
)
from footcal_cli.report import Sheet, number

STOPPING = frozenset({"readings_repeat_across_channels"})
"""Findings that make blocks no independent evidence; alarms stop a diagnosis too."""
LADDER_AGAIN = (
    "a ladder of at least six weights up and down, two holds of five minutes, each cell alone, "
    "three times"
)


@dataclass(frozen=True)
class Answer:
    """The verdict in words and what to do next.

    Parameters
    ----------
    kind
        One of DIAGNOSIS's words.
    verdict
        Sentence and details.
    rivals
        Groups of effects that these data cannot tell apart.
    experiment
        What to run next.
    menu
        The menu judged for the first pair of rivals.
    """

    kind: Verdict
    verdict: VerdictRecord
    rivals: tuple[tuple[str, ...], ...]
    experiment: str
    menu: tuple[Prospect, ...]


def answer_of(
    found: Investigation,
    table: Mapping[str, Effect],
    findings: Sequence[Finding],
    untested: Mapping[str, str],
) -> Answer:
    """Turn an investigation into its sentence."""
    stop = [f for f in findings if f.severity == "alarm" or f.code in STOPPING]
    rivals = rival_groups(found)
    menu = _menu(found, table)
    experiment = next_experiment(found, table, menu)
    kind = Verdict.BAD_DATA if stop else found.verdict
    if stop:
        return _stopped(found, stop, rivals, menu, untested)
    speak = {
        Verdict.NONE: _none,
        Verdict.NAMED: _named,
        Verdict.AMBIGUOUS: _ambiguous,
        Verdict.NAMED_UNKNOWN: _partly,
        Verdict.UNKNOWN: _unknown,
        Verdict.UNDERPOWERED: _underpowered,
    }[kind]
    sentence, details = speak(found, experiment)
    level = "good" if kind is Verdict.NONE else "warning"
    return Answer(
        kind,
        VerdictRecord(level=level, sentence=sentence, details=tuple(details)),  # type: ignore[arg-type]  # a literal by construction
        rivals,
        experiment,
        menu,
    )


def words(name: str) -> str:
    """An effect's name for a sentence."""
    return name.replace("_", " ")


def size_words(item: Found) -> str:
    """Every fitted number of an effect with its interval and unit."""
    signature = item.cause.signature
    parts = []
    for name, interval in zip(item.parameter_names, item.intervals, strict=True):
        parameter = name.rsplit(".", 1)[1]
        unit = signature.unit if parameter == signature.parameter else ""
        parts.append(f"{words(parameter)} {with_interval(interval, unit)}")
    return ", ".join(parts)


def with_interval(interval: Interval, unit: str) -> str:
    """``1.1 N [0.9, 1.3]``."""
    spread = interval.high - interval.low
    digits = 3
    if np.isfinite(spread) and spread > 0 and interval.value:
        digits = int(np.clip(np.ceil(np.log10(abs(interval.value) / spread)) + 2, 2, 6))
    unit = f" {unit}" if unit and unit != "-" else ""
    return (
        f"{number(interval.value, digits)}{unit} "
        f"[{number(interval.low, digits)}, {number(interval.high, digits)}]"
    )


def main_gain(found: Investigation) -> Gain | None:
    """The output that gained most."""
    return max(found.gains, key=lambda g: g.change.value, default=None)


def gain_words(found: Investigation) -> str:
    """``Held-out error of fz falls 19 % [14, 24], 0.41 to 0.33 N.``."""
    gain = main_gain(found)
    if gain is None:
        return ""
    low, value, high = (100 * x for x in (gain.change.low, gain.change.value, gain.change.high))
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    return (
        f"Held-out error of {gain.output} falls {value:.0f} % [{low:.0f}, {high:.0f}], "
        f"{number(gain.before, 3)} to {number(gain.after, 3)} {gain.unit}, better in {better} of "
        f"{len(gain.per_block)} blocks"
    )


def rival_groups(found: Investigation) -> tuple[tuple[str, ...], ...]:
    """Effects that do as well as each named one, itself first."""
    groups = []
    for item in found.found:
        cause = item.cause
        if cause.rivals:
            names = dict.fromkeys([cause.signature.effect, *(r.effect for r in cause.rivals)])
            groups.append(tuple(names))
    return tuple(groups)


def _causes_words(found: Investigation) -> str:
    return "; ".join(
        f"{words(f.cause.signature.effect)} in {f.cause.signature.where}, {size_words(f)}"
        for f in found.found
    )


def _could_not(found: Investigation) -> str:
    rows = [
        f"{words(r.signature.effect)} ({r.reason})"
        for r in found.rounds[0].effects
        if r.status is EffectStatus.NOT_TESTABLE
    ]
    rows += [f"{words(e.effect)} ({e.reason})" for e in found.problem.excluded]
    return "; ".join(rows)


def _none(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    shown = [
        f"{words(r.signature.effect)} > {number(r.detectable, 2)} {r.signature.unit}".rstrip(" -")
        for r in found.rounds[0].effects
        if r.status is not EffectStatus.NOT_TESTABLE and np.isfinite(r.detectable)
    ]
    details = []
    if shown:
        details.append("This data would have shown (power 0.8): " + ", ".join(shown) + ".")
    missing = _could_not(found)
    if missing:
        details.append(f"It could NOT have shown: {missing}.")
    details += [f"Set aside: {text}." for text in found.rounds[0].search.refused]
    details.append("Not found does not mean not there; the table says what was looked for.")
    return "No unmodelled effect found.", details


def _named(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    last = found.rounds[-1].before
    sentence = f"Cause: {_causes_words(found)}. {gain_words(found)}. Nothing else left."
    return sentence, [
        f"Left: nothing found (p = {number(last.p, 2)}).",
        *_detail_lines(found),
    ]


def _detail_lines(found: Investigation) -> list[str]:
    lines = []
    for item in found.found:
        cause = item.cause
        if cause.places:
            places = ", ".join(dict.fromkeys(s.where for s in cause.places))
            lines.append(
                f"Where: {words(cause.signature.effect)} in {cause.signature.where} cannot be told "
                f"from {places}."
            )
        lines.append(
            f"{words(cause.signature.effect)}: p = {number(cause.p, 2)} family-wise, size differs "
            f"between blocks by I² = {100 * cause.heterogeneity:.0f} %."
        )
    if found.case.one_recording:
        lines.append(
            "Repeatability between recordings is unknown: all this holds for this recording only."
        )
    if len(found.rounds) > 1 and found.stable < 1.0:
        lines.append(
            f"Leaving out single blocks keeps the first choice in {100 * found.stable:.0f} % of "
            "the cases."
        )
    return lines


def _ambiguous(found: Investigation, experiment: str) -> tuple[str, list[str]]:
    groups = [
        ", ".join(words(name) for name in dict.fromkeys(
            [f.cause.signature.effect, *(r.effect for r in f.cause.rivals)]
        ))
        for f in found.found if f.cause.rivals
    ]  # fmt: skip
    certain = [f for f in found.found if not f.cause.rivals]
    sentence = "One of {" + "}, and one of {".join(groups) + "}"
    if certain:
        sentence += " beside " + ", ".join(words(f.cause.signature.effect) for f in certain)
    sentence += ": these data cannot tell them apart."
    return sentence, [
        f"Run: {experiment}.",
        f"As {_causes_words(found)}.",
        f"{gain_words(found)}.",
        *_detail_lines(found),
    ]


def _partly(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    last = found.rounds[-1].before
    first = found.rounds[0].before
    share = 1.0 - last.ceiling / max(first.ceiling, 1e-9) if first.ceiling > 0 else 1.0
    sentence = (
        f"{_causes_words(found)} explains {100 * np.clip(share, 0, 1):.0f} % of what can be "
        f"explained; the rest {_depends(found)} and has no name in the library."
    )
    return sentence, [f"{gain_words(found)}.", *_detail_lines(found)]


def _depends(found: Investigation) -> str:
    detection = found.rounds[-1].before
    if detection.line_p < 0.01:
        name, frequency = detection.line
        return f"is a line at {number(frequency, 3)} Hz in {name}"
    if detection.between_p < 0.01:
        return f"moves with {detection.driver} from block to block"
    if detection.groups:
        best = int(np.argmin(detection.group_p))
        return f"depends on {detection.groups[best]}"
    return "repeats from block to block"


def _unknown(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    sentence = (
        f"Something is missing and no library effect explains it. Signature: {_depends(found)}, "
        f"in {_outputs(found)}."
    )
    details = [f"Considered and refused: {text}." for r in found.rounds for text in
               r.search.refused]  # fmt: skip
    if found.found:
        details.insert(0, f"Nearest: {_causes_words(found)}, but too much is left beside it.")
    return sentence, details


def _outputs(found: Investigation) -> str:
    problem = found.final
    energy = [
        float(np.mean(problem.residual[problem.output == o] ** 2))
        if np.any(problem.output == o) else 0.0
        for o in range(len(problem.outputs))
    ]  # fmt: skip
    return problem.outputs[int(np.argmax(energy))]


def _underpowered(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    blocks = found.problem.blocks
    rules = found.rounds[0].rules
    more = max(rules.fewest_blocks - blocks, 1)
    return (
        f"{blocks} blocks cannot reach alpha = {rules.alpha_name:g} (smallest possible p is "
        f"{number(found.rounds[0].smallest_p, 2)}). Record at least {more} more.",
        ["Blocks are recordings, sessions or remounts, alike in content; more samples in the same "
         "block do not help."],
    )  # fmt: skip


def _stopped(
    found: Investigation,
    stop: Sequence[Finding],
    rivals: tuple[tuple[str, ...], ...],
    menu: tuple[Prospect, ...],
    untested: Mapping[str, str],
) -> Answer:
    """Bad data: say so, and what can be said all the same."""
    sentence = f"Stopped: {stop[0].sentence.split(':')[0]}; diagnosing would be meaningless."
    details = []
    if found.case.experiment.name == "weights":
        bent = _curvature(found)
        if bent:
            details += bent
            what = "nonlinearity from creep or the order of loading"
            repeats = "with four unrepeated points" if _unrepeated(found) else "here"
            details.append(f"These readings cannot separate {what} {repeats}.")
            rivals = rivals or (("nonlinearity", "creep", "hysteresis"),)
    details.append(f"Run: {LADDER_AGAIN}.")
    return Answer(
        Verdict.BAD_DATA,
        VerdictRecord(level="bad", sentence=sentence, details=tuple(details)),
        rivals,
        LADDER_AGAIN,
        menu,
    )


def _unrepeated(found: Investigation) -> bool:
    return all(np.unique(log.known["load_n"]).size == len(log) == 4 for log in found.case.logs)


def _curvature(found: Investigation) -> list[str]:
    """Whether scale and bias are inadequate, and whether all channels bend alike."""
    from footcal_cli.core.bench.regression import fit_affine, pooled_curvature

    fits = []
    for log in found.case.logs:
        load = log.known["load_n"].reshape(len(log), -1)[:, 0]
        known = np.isfinite(load)
        fits.append(fit_affine(log.channels[0], load[known], log.readings[known, 0]))
    worst = max(fits, key=lambda f: f.worst_n)
    largest = max(float(np.abs(f.load_n).max()) for f in fits)
    if worst.worst_n < 0.01 * largest:
        return []
    curvature = pooled_curvature(fits)
    lines = [
        f"Affine inadequate: errors up to {number(worst.worst_n, 2)} N ({worst.channel}) of "
        f"{number(largest, 3)} N."
    ]
    if curvature is not None:
        shape = "compressive" if curvature.mean > 0 else "expansive"
        lines.append(
            f"Shared {shape} curve: {curvature.same_sign} of {len(curvature.bows)} channels bend "
            f"the same way (mean bow {100 * abs(curvature.mean):.1f} % of the span, sign test p = "
            f"{number(curvature.sign_p, 2)} were the channels independent)."
        )
    return lines


def _menu(found: Investigation, table: Mapping[str, Effect]) -> tuple[Prospect, ...]:
    for item in found.found:
        if not item.cause.rivals:
            continue
        rival = item.cause.rivals[0]
        if found.case.experiment.name not in ("weights", "placements"):
            return ()
        load = max(float(np.nanmax(np.abs(log.known["load_n"]))) for log in found.case.logs)
        problem = found.problem
        noise = float(np.median(problem.noise[problem.output == 0]))
        return prospects(item.cause.signature, rival, table, item.cause.size.value, noise, load)
    return ()


def next_experiment(
    found: Investigation, table: Mapping[str, Effect], menu: Sequence[Prospect]
) -> str:
    """What to run next: the best of the menu, else the table's advice."""
    if menu and menu[0].repeats < 10**6:
        best = menu[0]
        times = f", {best.repeats} times" if best.repeats > 1 else ""
        now = _cosine_now(found)
        return (
            f"{best.words}{times} (|cos| of the rivals {now:.4f} here, {best.cosine:.4f} then; "
            f"predicted separation {number(best.separation, 2)} noise sd)"
        )
    for item in found.found:
        if item.cause.rivals:
            names = [item.cause.signature.effect, *(r.effect for r in item.cause.rivals)]
            return advice([table[n] for n in dict.fromkeys(names) if n in table])
    if found.verdict is Verdict.UNDERPOWERED:
        return f"at least {max(10 - found.problem.blocks, 1)} more recordings of the same kind"
    return ""


def _cosine_now(found: Investigation) -> float:
    """|cos| of the first pair of rivals on these data."""
    cause = next(f.cause for f in found.found if f.cause.rivals)
    problem = found.problem
    index = {s: i for i, s in enumerate(problem.signatures)}
    pair = [index[s] for s in (cause.signature, cause.rivals[0]) if s in index]
    if len(pair) < 2:
        return 1.0
    from dataclasses import replace

    left = replace(
        problem, columns=problem.columns[:, pair], signatures=tuple(problem.signatures[i]
                                                                    for i in pair)
    ).left()  # fmt: skip
    norms = np.sqrt(np.sum(left**2, axis=0))
    return float(abs(left[:, 0] @ left[:, 1]) / max(norms[0] * norms[1], 1e-300))


def evidence_sheet(found: Investigation, untested: Mapping[str, str]) -> Sheet:
    """One row per effect of the table, by gain; greyed: not testable, and why."""
    rows: list[tuple[str, ...]] = []
    greyed = set()
    for row in _table_rows(found):
        if row.status is EffectStatus.NOT_TESTABLE:
            greyed.add(len(rows))
        rows.append(_evidence_row(row))
    for effect, reason in [(e.effect, e.reason) for e in found.problem.excluded] + list(
        untested.items()
    ):
        greyed.add(len(rows))
        rows.append((words(effect), "–", "–", "–", "–", "–", "–", "not testable", reason))
    return Sheet(
        "Evidence",
        ("effect", "where", "size [95 %]", "matters from", "visible", "p", "held-out gain",
         "status", "why"),
        rows,
        note="Gain: reduction of the squared error on blocks the effect was not fitted to. "
        "Visible: share of the effect that the calibration cannot absorb. p: family-wise over the "
        "whole table, from sign flips of whole blocks.",
        greyed=frozenset(greyed),
    )  # fmt: skip


def _table_rows(found: Investigation) -> list[EffectRow]:
    """Rows of named effects as they were accepted, the others beside the extended model."""
    named = {f.cause.signature.effect: f for f in found.found}
    rows: list[EffectRow] = []
    seen = set()
    for diagnosis in found.rounds:
        for row in diagnosis.effects:
            name = row.signature.effect
            if name in named and name not in seen and row.signature == named[name].cause.signature:
                from dataclasses import replace

                rows.append(replace(row, size=named[name].cause.size))
                seen.add(name)
    rivals = {r.effect for f in found.found for r in f.cause.rivals}
    for row in found.rounds[0].effects:
        if row.signature.effect in rivals and row.signature.effect not in seen:
            rows.append(row)
            seen.add(row.signature.effect)
    rows += [r for r in found.rounds[-1].effects if r.signature.effect not in seen]
    return sorted(rows, key=lambda r: (r.status is EffectStatus.NOT_TESTABLE, -r.gain))


def _evidence_row(row: EffectRow) -> tuple[str, ...]:
    tested = row.status is not EffectStatus.NOT_TESTABLE
    unit = row.signature.unit
    return (
        words(row.signature.effect),
        row.signature.where,
        with_interval(row.size, unit) if np.isfinite(row.size.low) else "–",
        f"{number(row.smallest, 2)} {unit}".rstrip(" -") if np.isfinite(row.smallest) else "–",
        f"{100 * row.visible:.0f} %",
        number(row.p, 2) if tested else "–",
        f"{100 * row.gain:+.1f} %".replace("-", "−") if tested else "–",
        str(row.status).replace("_", " "),
        row.reason,
    )


def gain_sheets(found: Investigation) -> tuple[Sheet, ...]:
    """Held-out errors before and after, per output."""
    if not found.found:
        return ()
    rows = [
        (
            gain.output, number(gain.before, 3), number(gain.after, 3), gain.unit,
            f"{100 * gain.change.value:.1f} % [{100 * gain.change.low:.1f}, "
            f"{100 * gain.change.high:.1f}]".replace("-", "−"),
            f"{int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))} of {len(gain.per_block)}",
        )
        for gain in found.gains
    ]  # fmt: skip
    return (
        Sheet(
            "What the extended model buys on data it was not fitted to",
            ("output", "before", "after", "unit", "reduction [95 %]", "blocks better"),
            rows,
            note=f"Each block is predicted by a fit to the others. Repeating the choice of the "
            f"effect without single blocks gives the same effect in {100 * found.stable:.0f} % of "
            "the folds.",
        ),
    )


def menu_sheets(answer: Answer) -> tuple[Sheet, ...]:
    """The menu of experiments, judged."""
    if not answer.menu:
        return ()
    rows = [
        (
            p.words, f"{p.cosine:.3f}", number(p.separation, 3),
            str(p.repeats) if p.repeats < 10**4 else "hopeless",
        )
        for p in answer.menu
    ]  # fmt: skip
    return (
        Sheet(
            "Which experiment would tell the rivals apart",
            ("experiment on one cell", "|cos| of the rivals", "separation (noise sd)",
             "runs for power 0.8"),
            rows,
            note="Predicted by simulating each experiment with the fitted size and this data's "
            "noise, calibration and rival refitted.",
        ),
    )  # fmt: skip


def card_sheets(found: Investigation) -> tuple[Sheet, ...]:
    """The signature card of what has no name."""
    detection = found.rounds[-1].before
    if not leftover(detection, found.rounds[-1].rules):
        return ()
    order = np.argsort(detection.group_p)[:3]
    rows = [
        ("output most touched", _outputs(found)),
        ("depends on", ", ".join(_group_words(detection, int(i)) for i in order) or "–"),
        ("line", f"{number(detection.line[1], 3)} Hz in {detection.line[0]}, "
                 f"p = {number(detection.line_p, 2)}" if detection.line[0] else "–"),
        ("between blocks", f"{detection.driver or 'no driver'}, p = "
                           f"{number(detection.between_p, 2)}"),
        ("share any function explains", f"{100 * detection.ceiling:.1f} %"),
        ("blocks in which it repeats",
         f"{int(np.sum(detection.flexible_gain > 0))} of {detection.flexible_gain.size}"),
        ("nearest library effects", ", ".join(
            f"{words(r.signature.effect)} ({r.signature.where})"
            for r in found.rounds[-1].effects[:3]) or "–"),
    ]  # fmt: skip
    return (Sheet("Signature card of what has no name", ("what", "value"), rows),)


def _group_words(detection: Detection, group: int) -> str:
    return f"{detection.groups[group]} (p = {number(float(detection.group_p[group]), 2)})"


def movement_sheets(moved: Sequence[Movement]) -> tuple[Sheet, ...]:
    """Calibration before and after."""
    if not moved:
        return ()
    rows = [
        (
            m.name, number(m.before, 7), number(m.after, 7), m.unit,
            f"{m.in_sd:+.1f}".replace("-", "−"),
        )
        for m in moved
    ]  # fmt: skip
    return (
        Sheet(
            "What the calibration does when the effects enter the model",
            ("parameter", "without", "with", "unit", "moved (sd)"),
            rows,
            note="A parameter that moves by many sd had been carrying the effect.",
        ),
    )


def untested_sheet(found: Investigation, untested: Mapping[str, str]) -> Sheet:
    """What could not be tested, and why."""
    rows = [
        (words(r.signature.effect), r.reason, "")
        for r in found.rounds[-1].effects
        if r.status is EffectStatus.NOT_TESTABLE
    ]
    rows += [(words(e.effect), e.reason, "") for e in found.problem.excluded]
    rows += [(words(name), reason, "") for name, reason in untested.items()]
    return Sheet("What could not be tested", ("effect", "why", ""), rows or [("–", "–", "")])


def method_note(found: Investigation, seed: int) -> str:
    """How the evidence was counted."""
    first = found.rounds[0]
    tau = first.grams.autocorrelation_time
    rate = found.problem.rate_hz
    time = f"{number(tau / rate, 2)} s" if rate > 0 else f"{number(tau, 2)} rows"
    return (
        f"{found.problem.blocks} blocks, {found.problem.residual.size} rows; the residual's "
        f"autocorrelation time is {time}; smallest reachable p {number(first.smallest_p, 2)}; "
        f"seed {seed}. Rows are never counted as evidence, blocks are."
    )


def record_of(
    found: Investigation, answer: Answer, read: Any, rules: Rules, seed: int
) -> DiagnosisRecord:
    """``diagnosis.json``."""
    last = found.rounds[-1].before
    first = found.rounds[0].before
    causes = () if answer.kind is Verdict.BAD_DATA else tuple(
        _cause_record(found, item) for item in found.found
    )  # fmt: skip
    if answer.kind is Verdict.UNKNOWN:
        causes = ()
    rows = [_row_record(row) for row in _table_rows(found)]
    rows += [
        _absent_record(name, reason)
        for name, reason in [
            *((e.effect, e.reason) for e in found.problem.excluded),
            *read.untested.items(),
        ]
    ]
    return DiagnosisRecord(
        experiment_kind=found.case.experiment.name,
        verdict=answer.kind.value,
        sentence=answer.verdict.sentence,
        causes=causes,
        rivals=answer.rivals if causes or answer.kind is Verdict.BAD_DATA else (),
        experiment=answer.experiment,
        findings=tuple(FindingRecord.of(f) for f in read.findings),
        effects=tuple(rows),
        blocks=found.problem.blocks,
        rows=int(found.problem.residual.size),
        smallest_p=found.rounds[0].smallest_p,
        share_explained=None if not found.found else 1.0 - last.ceiling,
        leftover_p=last.p,
        evidence={
            "signals_p": first.bump_p,
            "flexible_p": first.flexible_p,
            "line_p": first.line_p,
            "between_p": first.between_p,
            "ceiling": first.ceiling,
        },
        seed=seed,
        rules=rules.sentence(),
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _pair(interval: Interval) -> tuple[float, float] | None:
    if not np.isfinite(interval.low) or not np.isfinite(interval.high):
        return None
    return interval.low, interval.high


def _cause_record(found: Investigation, item: Found) -> CauseRecord:
    cause, signature = item.cause, item.cause.signature
    gain = main_gain(found)
    shape = {
        name.rsplit(".", 1)[1]: interval.value
        for name, interval in zip(item.parameter_names, item.intervals, strict=True)
        if not name.endswith(f".{signature.parameter}")
    }
    return CauseRecord(
        effect=signature.effect,
        where=signature.where,
        parameter=signature.parameter,
        size=cause.size.value,
        sd=_finite((cause.size.high - cause.size.low) / 4.0),
        unit=signature.unit,
        ci95=_pair(cause.size),
        shape=shape,
        p=cause.p,
        held_out_gain=None
        if gain is None
        else HeldOutGain(
            quantity=gain.output, unit=gain.unit, before=gain.before, after=gain.after,
            ci95=_pair(gain.change),
        ),
        blocks_better=cause.blocks_better,
        rivals=tuple(dict.fromkeys(r.effect for r in cause.rivals)),
        places=tuple(dict.fromkeys(s.where for s in cause.places)),
    )  # fmt: skip


def _row_record(row: EffectRow) -> EffectRowRecord:
    signature: Signature = row.signature
    tested = row.status is not EffectStatus.NOT_TESTABLE
    return EffectRowRecord(
        effect=signature.effect,
        where=signature.where,
        parameter=signature.parameter,
        unit=signature.unit,
        size=_finite(row.size.value) if tested else None,
        ci95=_pair(row.size) if tested else None,
        smallest_that_matters=_finite(row.smallest),
        detectable=_finite(row.detectable),
        visible=row.visible,
        p=row.p if tested else None,
        gain=row.gain if tested else None,
        informative_blocks=row.informative,
        status=row.status.value,
        reason=row.reason,
    )


def _absent_record(name: str, reason: str) -> EffectRowRecord:
    return EffectRowRecord(
        effect=name, where="", parameter="", unit="", size=None, ci95=None,
        smallest_that_matters=None, detectable=None, visible=None, p=None, gain=None,
        informative_blocks=None, status="not_testable", reason=reason,
    )  # fmt: skip
