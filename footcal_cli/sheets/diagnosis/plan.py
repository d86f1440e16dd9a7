"""``diagnose --plan``: only the next experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.diagnosis.menu import Menu, advice
from footcal_cli.core.effects.contract import Effect
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import NextExperimentRecord, PlanRecord
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.diagnosis.experiment import (
    experiment_record,
    experiment_words,
    menu_sheets,
    options_of,
    prospect_record,
)
from footcal_cli.sheets.diagnosis.words import together


def plan_outcome(menu: Menu, names: Sequence[str], table: Mapping[str, Effect]) -> Outcome:
    """The menu for the rivals that were named."""
    chosen = experiment_record(menu)
    if chosen is None:
        said = advice([table[n] for n in names]) or "nothing in the table of effects"
        chosen = NextExperimentRecord(id="", kind="", words=said, between=tuple(names))
    asked = together(words(n) for n in names)
    return Outcome(
        title=f"The next experiment: {asked}",
        verdict=VerdictRecord(
            level="good" if chosen.id else "warning",
            sentence=f"To distinguish {asked}, run: {experiment_words(chosen)}.",
            details=(f"Then: footcal diagnose … --experiment {options_of(chosen)}.",)
            if chosen.id
            else ("No experiment that footcal knows distinguishes them.",),
        ),
        lead_sheets=menu_sheets(menu),
        records={
            "plan.json": PlanRecord(
                between=tuple(names),
                next_experiment=chosen,
                menu=tuple(prospect_record(menu, p) for p in menu.prospects),
            )
        },
    )
