"""What the joint diagnosis of several experiments says: sentence, tables, record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.joint import JointDiagnosis
from footcal_cli.core.diagnosis.joint_hypotheses import JointSize
from footcal_cli.core.diagnosis.joint_sizes import SingleDiagnosis, SizeSeen
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.quality import Finding
from footcal_cli.intake.cases.shared import CaseRead
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import (
    CauseRecord,
    DiagnosisRecord,
    ExperimentRecord,
    SizeInExperimentRecord,
)
from footcal_cli.records.results import RmseRecord, VerdictRecord
from footcal_cli.report import Sheet, number
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.diagnosis.report import rmse_of
from footcal_cli.sheets.diagnosis.sentences import underpowered
from footcal_cli.sheets.diagnosis.words import alike_by_law, place_words, together, with_interval

_HOW_TO_READ = (
    "A column per experiment: the size that its data prefer ± standard deviation, its own "
    "calibration and the other causes fitted together with it; in brackets its distance from zero "
    "in standard deviations. The common size is what all experiments say together. Agreement: "
    "probability that sizes of one cause differ as much by chance, a form error of 20 % allowed "
    "for. Probability: of the name among its rivals."
)


def joint_verdict(joint: JointDiagnosis, table: Mapping[str, Effect]) -> VerdictRecord:
    """The verdict in words."""
    sentence, details = _said(joint)
    actions = [_remedy(item, table) for item in joint.causes if joint.agreed]
    actions += [_plan(item) for item in joint.causes if joint.agreed and len(item.rivals) > 1]
    details += [line for item in joint.causes for line in _resolved(item, joint)]
    for single in joint.singles:
        if single.name in joint.open_in:
            details.append(
                f"In {single.name} a residual remains that no name explains; its sizes of other "
                "causes do not count."
            )
        if single.found.verdict is Verdict.BAD_DATA:
            details.append(f"{single.name}: its readings are wrong, so it says nothing here.")
        if single.found.verdict is Verdict.UNDERPOWERED:
            details.append(f"{single.name} by itself: {underpowered(single.found, {})[0]}")
    return VerdictRecord(
        level="good" if combined(joint) is Verdict.NONE else "warning",
        sentence=sentence,
        actions=tuple(actions),
        details=tuple(details),
    )


def combined(joint: JointDiagnosis) -> Verdict:
    """One word for all: nothing was found only where every experiment could show something."""
    few = any(single.found.verdict is Verdict.UNDERPOWERED for single in joint.singles)
    return Verdict.UNDERPOWERED if few and joint.verdict is Verdict.NONE else joint.verdict


def _said(joint: JointDiagnosis) -> tuple[str, list[str]]:
    names = together(single.name for single in joint.singles)
    kind = joint.verdict
    if kind is Verdict.BAD_DATA:
        return f"Stopped: the readings of {names} are wrong.", []
    if kind is Verdict.NONE:
        ends = {
            verdict: [s.name for s in joint.singles if s.found.verdict is verdict]
            for verdict in (Verdict.NONE, Verdict.UNDERPOWERED, Verdict.BAD_DATA)
        }
        sentence = f"No unmodelled effect found in {together(ends[Verdict.NONE])}"
        if few := ends[Verdict.UNDERPOWERED]:
            sentence += f"; not tested: {together(few)}, with too few blocks to name a cause"
        if wrong := ends[Verdict.BAD_DATA]:
            sentence += f"; not tested: {together(wrong)}, with wrong readings"
        return f"{sentence}.", []
    if kind is Verdict.UNDERPOWERED:
        return f"Neither of {names} has enough blocks to name a cause.", []
    excluded = [item for item in joint.causes if item.excluded]
    if excluded:
        return f"Unknown: {'; '.join(_contradiction(item) for item in excluded)}.", []
    if not joint.causes or kind is Verdict.UNKNOWN:
        some = together(joint.open_in)
        return f"Something is missing in {some}, and no effect of the table explains it.", []
    causes = "; ".join(_cause_words(item) for item in joint.causes)
    if joint.open_in:
        causes += f"; in {together(joint.open_in)} a residual without a name remains"
    return f"{causes[0].upper()}{causes[1:]}.", []


def _cause_words(item: JointSize) -> str:
    cause = item.cause
    rivals = [name for name in item.rivals if name != cause.effect]
    size = with_interval(_surest(item), item.cause.unit)
    said = f"{words(cause.effect)}{place_words(cause.where)}, {size}"
    if not rivals:
        return said
    either = together((words(n) for n in item.rivals), "or")
    return f"Either {either}: these experiments together cannot distinguish them"


def _surest(item: JointSize) -> Interval:
    """The size that is surest not to be nothing."""
    known = [s for s in item.size if np.isfinite(s.value)]
    return max(known, key=lambda s: abs(s.value) / max(s.high - s.low, 1e-300))


def _contradiction(item: JointSize) -> str:
    sizes = [f"{_seen_words(seen, item)} in {name}" for name, seen in item.seen.items()]
    return (
        f"{words(item.cause.effect)}{place_words(item.cause.where)} is {together(sizes)}, and one "
        "size excludes the other"
    )


def _resolved(item: JointSize, joint: JointDiagnosis) -> list[str]:
    """Which rivals each experiment leaves open by itself that the others rule out, or do not."""
    lines: list[str] = []
    for single in joint.singles:
        if single.name not in item.named_by:
            continue
        own = next(names for names in _named_alone(single) if item.cause.effect in names)
        rivals = [rival for f in single.found.found for rival in f.cause.rivals]
        # by its law alone: what the other experiments see does not touch it
        by_law = {r.effect: r.where for r in rivals if not r.owners and r.effect in own}
        lines += [
            f"{alike_by_law(name, where, item.cause.effect)} in {single.name}, and no other "
            "experiment excludes it."
            for name, where in by_law.items()
        ]
        gone = [words(name) for name in own if name not in item.rivals and name not in by_law]
        if gone:
            lines.append(
                f"{single.name} alone cannot distinguish {words(item.cause.effect)} from "
                f"{together(gone, 'or')}; the other experiments rule "
                f"{'it' if len(gone) == 1 else 'them'} out."
            )
    return lines


def _remedy(item: JointSize, table: Mapping[str, Effect]) -> str:
    return f"To do about {words(item.cause.effect)}: {table[item.cause.effect].remedy}."


def _plan(item: JointSize) -> str:
    between = " ".join(f"--between {name}" for name in item.rivals)
    return f"The experiment that would distinguish them: footcal diagnose --plan {between}."


def _seen_words(seen: Sequence[SizeSeen | None], item: JointSize) -> str:
    known = [s for s in seen if s is not None]
    surest = max(known, key=lambda s: s.sureness)
    unit = "" if item.cause.unit in ("", "-") else f" {item.cause.unit}"
    return f"{number(surest.size, 3)} ± {number(surest.sd, 2)}{unit}"


def size_sheet(joint: JointDiagnosis) -> Sheet:
    """A row per cause, a column per experiment."""
    names = [single.name for single in joint.singles]
    rows = []
    for item in joint.causes:
        seen = [
            f"{_seen_words(item.seen[name], item)} ({_sds(item.seen[name])})"
            if name in item.seen
            else f"not testable here: {item.unseen.get(name, 'its readings are wrong')}"
            for name in names
        ]
        agreement = "–" if item.agreement is None else number(item.agreement, 2)
        probability = 100 * item.rivals[item.cause.effect]
        rows.append(
            (
                words(item.cause.effect), item.cause.where,
                with_interval(_surest(item), item.cause.unit), *seen, agreement,
                f"{min(probability, 99.9):.3g} %",
            )
        )  # fmt: skip
        rows += [
            (f"or {words(rival)}", "", "", *("" for _ in names), "", f"{100 * share:.2g} %")
            for rival, share in item.rivals.items()
            if rival != item.cause.effect
        ]
    return Sheet(
        "Causes, a column per experiment",
        ("cause", "where", "common size [95 %]", *names, "agreement", "probability"),
        rows or [("–",) * (len(names) + 5)],
        note=_HOW_TO_READ,
    )


def _sds(seen: Sequence[SizeSeen | None]) -> str:
    return f"{max(s.sureness for s in seen if s is not None):.1f}"


def experiment_sheet(joint: JointDiagnosis) -> Sheet:
    """What each experiment says by itself."""
    rows = [
        (
            single.name, single.kind, single.found.verdict.value,
            "; ".join(together(map(words, names), "or") for names in _named_alone(single)) or "–",
            str(single.found.problem.blocks),
        )
        for single in joint.singles
    ]  # fmt: skip
    return Sheet(
        "Each experiment by itself", ("experiment", "kind", "verdict", "names", "blocks"), rows
    )


def _named_alone(single: SingleDiagnosis) -> list[tuple[str, ...]]:
    """What an experiment names by itself: each cause with its rivals."""
    return [
        tuple(dict.fromkeys(s.effect for s in (f.cause.signature, *f.cause.rivals)))
        for f in single.findings
    ]


def unseen_sheet(joint: JointDiagnosis) -> Sheet:
    """Effects that none of the experiments can test, and why."""
    effects = {
        s.effect: None for single in joint.singles for s in single.found.problem.signatures
    } | {e.effect: None for single in joint.singles for e in single.found.problem.excluded}
    rows = []
    for effect in effects:
        reasons = {single.name: single.why_unseen(effect) for single in joint.singles}
        if all(reasons.values()):
            rows.append((words(effect), *reasons.values()))
    return Sheet(
        "What none of these experiments can test",
        ("effect", *(single.name for single in joint.singles)),
        rows or [("–",) * (len(joint.singles) + 1)],
        folded_after=12,
    )


def joint_record(
    joint: JointDiagnosis,
    table: Mapping[str, Effect],
    findings: Sequence[Finding],
    rules: Rules,
    seed: int,
) -> DiagnosisRecord:
    """``diagnosis.json`` of several experiments."""
    groups = tuple(tuple(item.rivals) for item in joint.causes if len(item.rivals) > 1)
    return DiagnosisRecord(
        experiment_kind="+".join(dict.fromkeys(single.kind for single in joint.singles)),
        verdict=combined(joint).value,
        sentence=joint_verdict(joint, table).sentence,
        causes=tuple(_cause_record(item, joint, table) for item in joint.causes if joint.agreed),
        rivals=groups,
        findings=tuple(findings),
        experiments=tuple(_experiment_record(single, joint) for single in joint.singles),
        blocks=sum(single.found.problem.blocks for single in joint.singles),
        rows=sum(int(single.found.problem.residual.size) for single in joint.singles),
        smallest_p=min(single.found.rounds[0].smallest_p for single in joint.singles),
        share_explained=None,
        leftover_p=None,
        seed=seed,
        rules=rules.listed(),
    )


def _experiment_record(single: SingleDiagnosis, joint: JointDiagnosis) -> ExperimentRecord:
    sizes = []
    for item in joint.causes:
        seen = [s for s in item.seen.get(single.name, ()) if s is not None]
        surest = max(seen, key=lambda s: s.sureness, default=None)
        sizes.append(
            SizeInExperimentRecord(
                effect=item.cause.effect,
                size=None if surest is None else surest.size,
                sd=None if surest is None else surest.sd,
                unit=item.cause.unit,
                named=single.name in item.named_by,
                not_testable=item.unseen.get(single.name, ""),
            )
        )
    return ExperimentRecord(
        name=single.name,
        kind=single.kind,
        verdict=single.found.verdict.value,
        names=tuple(_named_alone(single)),
        sizes=tuple(sizes),
    )


def _cause_record(
    item: JointSize, joint: JointDiagnosis, table: Mapping[str, Effect]
) -> CauseRecord:
    size = _surest(item)
    own = [
        f.cause
        for single in joint.singles
        if single.name in item.named_by
        for f in single.findings
        if item.cause.effect in f.cause.effects
    ]
    return CauseRecord(
        effect=item.cause.effect,
        where=item.cause.where,
        parameter=item.cause.parameter,
        size=size.value,
        sd=(size.high - size.low) / 4.0,
        unit=item.cause.unit,
        ci95=(size.low, size.high),
        shape=dict(item.shape),
        p=min(c.p for c in own),
        held_out_gain=None,
        blocks_better=sum(c.blocks_better for c in own),
        rivals=tuple(name for name in item.rivals if name != item.cause.effect),
        probability=dict(item.rivals),
        agreement_p=item.agreement,
        remedy=table[item.cause.effect].remedy,
    )


def joint_outcome(
    title: str,
    joint: JointDiagnosis,
    reads: Sequence[CaseRead],
    table: Mapping[str, Effect],
    rules: Rules,
    seed: int,
    alone: Sequence[str],
) -> Outcome:
    """One verdict on several experiments; `alone` are the options that diagnose each by itself."""
    singles = joint.singles
    findings = [
        replace(f, where=f"{one.name}: {f.where}")
        for one, read in zip(singles, reads, strict=True)
        for f in read.findings
    ]
    record = joint_record(joint, table, findings, rules, seed)
    rows = tuple(
        row.model_copy(update={"quantity": f"{one.name}: {row.quantity}"})
        for one in singles
        for row in rmse_of(one.found).rows
    )
    return Outcome(
        usable=record.verdict != "bad-data",
        diagnosis=record.verdict,
        title=f"{title}: {' + '.join(one.name for one in singles)}",
        verdict=joint_verdict(joint, table),
        lead_sheets=(size_sheet(joint), experiment_sheet(joint)),
        sheets=(unseen_sheet(joint),),
        findings=tuple(findings),
        footer=(
            "Each experiment by itself: footcal diagnose with its logs alone "
            f"({'; '.join(alone)}).",
            rules.sentence(),
        ),
        rmse=RmseRecord(rows=rows),
        records={"diagnosis.json": record},
    )
