"""The verdict of a diagnosis in words, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.diagnosis.answer import EffectStatus, Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.next_experiment import next_menu
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.quality import Finding, stopping
from footcal_cli.records.results import VerdictRecord
from footcal_cli.sheets.diagnosis.contract import Answer
from footcal_cli.sheets.diagnosis.experiment import experiment_words, next_experiment, sharpening
from footcal_cli.sheets.diagnosis.sentences import (
    ambiguous,
    named,
    none_found,
    partly_named,
    underpowered,
)
from footcal_cli.sheets.diagnosis.stopped import stopped
from footcal_cli.sheets.diagnosis.unknown import unknown
from footcal_cli.sheets.diagnosis.words import rival_groups

_ASKS = (Verdict.AMBIGUOUS, Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN)
"""Verdicts that an experiment would sharpen."""


def answer_of(
    found: Investigation,
    table: Mapping[str, Effect],
    findings: Sequence[Finding],
    untested: Mapping[str, str],
) -> Answer:
    """Turn an investigation into its sentence."""
    kind = found.verdict
    if kind is Verdict.BAD_DATA:
        return stopped(found, stopping(findings))
    menu = next_menu(found, table) if kind in _ASKS else None
    experiment = next_experiment(found, table, menu)
    speak = {
        Verdict.NONE: none_found,
        Verdict.NAMED: named,
        Verdict.AMBIGUOUS: ambiguous,
        Verdict.NAMED_UNKNOWN: partly_named,
        Verdict.UNKNOWN: unknown,
        Verdict.UNDERPOWERED: underpowered,
    }[kind]
    sentence, details = speak(found, untested)
    tested = any(r.status is not EffectStatus.NOT_TESTABLE for r in found.rounds[0].effects)
    if experiment is not None and kind is Verdict.AMBIGUOUS:
        details.insert(0, f"Run next: {experiment_words(experiment)}.")
    elif menu is not None and menu.prospects:
        details.insert(0, f"What would sharpen it: {' – or '.join(sharpening(menu))}.")
    return Answer(
        VerdictRecord(
            level="good" if kind is Verdict.NONE and tested else "warning",
            sentence=sentence,
            details=tuple(details),
        ),
        rival_groups(found),
        experiment,
        menu,
    )
