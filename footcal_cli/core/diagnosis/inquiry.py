"""A walk that is asked once more, about fewer effects and along fewer directions.

Of the room of the diagnosis; the modules that ask so (known_gain, moved_gain, moved_zero) and
`diagnose` import it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from footcal_cli.core.diagnosis.bridge import Describe, problem_from
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.path import Path, beginning, grown
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Advance, Subject, uncounted
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.tracking import Direction


@dataclass(frozen=True)
class Inquiry:
    """How logs are investigated; see `investigate`.

    Parameters
    ----------
    table
        Effects by name that an answer may name.
    describe
        Gives the recorded signals of a case.
    rules, seed
        Thresholds, and of sign patterns.
    advance
        Called with how many more refits are done.
    """

    table: Mapping[str, Effect]
    describe: Describe
    rules: Rules = field(default_factory=Rules)
    seed: int = 0
    advance: Advance = uncounted

    def about(
        self, found: Investigation, directions: Sequence[Direction], asked: Mapping[str, Effect]
    ) -> tuple[Subject, Path]:
        """A case whose calibration may differ along some directions, and a path with no cause.

        Parameters
        ----------
        asked
            Effects that are looked for.
        """
        case = replace(found.case, directions=tuple(directions))
        problem = problem_from(case, found.problem, asked.values(), self.describe)
        subject = Subject(case, problem, self.table, self.describe, self.advance)
        return subject, beginning(problem, self._one, self.seed)

    def one_cause(
        self, found: Investigation, directions: Sequence[Direction], asked: Mapping[str, Effect]
    ) -> tuple[Subject, Path]:
        """The same, and the one cause that the walk then shows."""
        subject, begun = self.about(found, directions, asked)
        return subject, grown(subject, begun, self._one, self.seed)

    @property
    def _one(self) -> Rules:
        return replace(self.rules, most_effects=1)
