"""What a diagnosis says: the verdict in words, rivals, what to run next."""

from __future__ import annotations

from dataclasses import dataclass, replace

from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.records.diagnosis import NextExperimentRecord
from footcal_cli.records.results import VerdictRecord


@dataclass(frozen=True)
class Answer:
    """The verdict in words and what to do next.

    Parameters
    ----------
    verdict
        Sentence and details.
    rivals
        Groups of effects that these data cannot distinguish.
    experiment
        What to run next.
    menu
        The menu judged for the first group of rivals, or for what comes nearest to the unknown.
    """

    verdict: VerdictRecord
    rivals: tuple[tuple[str, ...], ...] = ()
    experiment: NextExperimentRecord | None = None
    menu: Menu | None = None

    def with_action(self, words: str) -> Answer:
        """The same with one more thing to do, after the others."""
        actions = (*self.verdict.actions, words)
        return replace(self, verdict=self.verdict.model_copy(update={"actions": actions}))

    def with_detail(self, words: str) -> Answer:
        """The same with one more thing said, first of all."""
        details = (words, *self.verdict.details)
        return replace(self, verdict=self.verdict.model_copy(update={"details": details}))
