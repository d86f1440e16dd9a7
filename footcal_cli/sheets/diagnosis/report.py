"""What ``diagnose`` says of one experiment: report, record, errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects.contract import Effect
from footcal_cli.intake.cases.shared import CaseRead
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Sheet
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.diagnosis.answer import answer_of
from footcal_cli.sheets.diagnosis.contract import Answer
from footcal_cli.sheets.diagnosis.evidence import evidence_sheet, untested_sheet
from footcal_cli.sheets.diagnosis.experiment import menu_sheets
from footcal_cli.sheets.diagnosis.followed import (
    after,
    followed_records,
    followed_words,
    left_over,
    suspect_records,
)
from footcal_cli.sheets.diagnosis.gains import gain_sheets, method_note, movement_sheets
from footcal_cli.sheets.diagnosis.held import held_words
from footcal_cli.sheets.diagnosis.pictures import pictures_of
from footcal_cli.sheets.diagnosis.record import record_of
from footcal_cli.sheets.diagnosis.sentences import most_informative, nothing_testable
from footcal_cli.sheets.diagnosis.unknown import card_sheets
from footcal_cli.sheets.diagnosis.words import together
from footcal_cli.sheets.ladder import study_sentence


@dataclass(frozen=True)
class DiagnosisRequest:
    """What was asked of a diagnosis.

    Parameters
    ----------
    title
        Of the report.
    table, rules, seed
        What it is judged by.
    alone
        Cells that need more than a scale and a bias, where the diagnosis named nothing.
    before
        The diagnosis whose rivals this one should distinguish.
    reproduce
        The command that gives this again.
    """

    title: str
    table: Mapping[str, Effect]
    rules: Rules
    seed: int
    alone: Sequence[ChannelStudy] = ()
    before: DiagnosisRecord | None = None
    reproduce: str = ""


def outcome_of(
    read: CaseRead, found: Investigation, moved: tuple[Movement, ...], asked: DiagnosisRequest
) -> Outcome:
    """An investigation as everything that people and programs read of it.

    Parameters
    ----------
    read, found, moved
        The case, what the core found, and how the calibration moves with it.
    """
    short = nothing_testable(found) and most_informative(found) > 0.0
    if found.verdict is Verdict.NONE and (asked.alone or short):
        found = replace(found, verdict=Verdict.UNDERPOWERED)
    table, seed = asked.table, asked.seed
    answer = _answer(read, found, asked)
    became = after(found, asked.before, table)
    left = left_over(found, became)
    if became:
        answer = answer.with_detail(followed_words(became, left))
    if held := held_words(found.case):
        answer = answer.with_detail(held)
    record = record_of(found, answer, read, asked.rules, seed)
    followed = {
        "suspects": suspect_records(found, table), "after": followed_records(became),
        "survivors": left,
    }  # fmt: skip
    return Outcome(
        usable=record.verdict != "bad-data",
        diagnosis=record.verdict,
        title=f"{asked.title}: {read.case.experiment.name}",
        verdict=answer.verdict,
        pictures=pictures_of(found, table, moved, answer.menu, seed),
        lead_sheets=_leading(found, answer),
        sheets=_details(read, found, moved),
        findings=tuple(read.findings),
        footer=(
            f"To reproduce: {asked.reproduce}", asked.rules.sentence(), method_note(found, seed)
        ),
        rmse=None if found.verdict is Verdict.BAD_DATA else rmse_of(found),
        records={"diagnosis.json": record.model_copy(update=followed)},
    )  # fmt: skip


def _leading(found: Investigation, answer: Answer) -> tuple[Sheet, ...]:
    """Tables that hold the answer; sizes fitted to wrong readings are none."""
    if found.verdict is Verdict.BAD_DATA:
        return ()
    return (
        evidence_sheet(found), *card_sheets(found, answer.menu), *menu_sheets(answer.menu)
    )  # fmt: skip


def _details(
    read: CaseRead, found: Investigation, moved: tuple[Movement, ...]
) -> tuple[Sheet, ...]:
    """Tables that support it."""
    if found.verdict is Verdict.BAD_DATA:
        return ()
    return (
        *gain_sheets(found), *movement_sheets(moved), untested_sheet(found, read.untested)
    )  # fmt: skip


def _answer(read: CaseRead, found: Investigation, asked: DiagnosisRequest) -> Answer:
    """What is said first, and what to do next."""
    answer = answer_of(found, asked.table, read.findings, read.untested)
    if asked.alone:
        answer = _undecided(answer, found, asked.alone)
    if found.model is None:
        return answer
    causes = together(words(item.cause.signature.effect) for item in found.found)
    if found.verdict is Verdict.AMBIGUOUS:
        return answer.with_action(
            f"Until then {causes} stands for all of them in parameters_extended.json, next to "
            "this report (--parameters)."
        )
    return answer.with_action(
        "Start the next command from parameters_extended.json, next to this report "
        f"(--parameters): it holds {causes}."
    )


def _undecided(answer: Answer, found: Investigation, alone: Sequence[ChannelStudy]) -> Answer:
    """The answer where single cells need more than the diagnosis can name."""
    cells, named = len(found.case.logs), together(study.channel for study in alone)
    why = answer.verdict.sentence
    if found.verdict is Verdict.UNDERPOWERED and found.rounds[0].smallest_p <= (
        found.rounds[0].rules.alpha_name
    ):
        # all blocks would be enough, but not those of the cells that it is about
        blocks = {log.channels[0]: len(set(log.block.tolist())) for log in found.case.logs}
        own = together(f"{blocks[study.channel]} of {study.channel}" for study in alone)
        why = f"Too few blocks to name the cause: {own}."
    verdict = VerdictRecord(
        level="warning",
        sentence=(
            f"{f'{len(alone)} of {cells} cells need' if cells > 1 else 'The only cell needs'} more "
            f"than a scale and a bias: {named}. {why}"
        ),
        actions=("Record more sessions of these cells to have the cause named.",),
        details=(
            *(sentence for study in alone if (sentence := study_sentence(study)) is not None),
            "offline-fit finds the same in these rows, and its calibration holds it.",
        ),
    )
    return replace(answer, verdict=verdict)


def rmse_of(found: Investigation) -> RmseRecord:
    """Held-out errors of the baseline and of the extended model, per output."""
    rows = []
    for gain in found.gains:
        n = int((found.problem.output == found.problem.outputs.index(gain.output)).sum())
        for stage, value in (("before", gain.before), ("after", gain.after)):
            rows.append(
                RmseRow(
                    quantity=gain.output, unit=gain.unit, stage=stage, reference="the balance",
                    split="held_out", rmse=value, n=n,
                )
            )  # fmt: skip
    return RmseRecord(rows=tuple(rows))
