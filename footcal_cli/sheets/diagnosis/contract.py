"""What a diagnosis says: the verdict in words, rivals, what to run next."""

from __future__ import annotations

from dataclasses import dataclass

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.records import NextExperimentRecord, VerdictRecord


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
        The menu judged for the first group of rivals, or for what comes nearest to the unknown.
    """

    kind: Verdict
    verdict: VerdictRecord
    rivals: tuple[tuple[str, ...], ...] = ()
    experiment: NextExperimentRecord | None = None
    menu: Menu | None = None
