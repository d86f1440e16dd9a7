"""Which of two columns of loads that differ is meant: the one that all readings follow, or asked.

Room: sniff; asked by experiment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from footcal_cli.core.readings import straightness
from footcal_cli.sniff.cells import toml_key
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.loads import unlike
from footcal_cli.sniff.plan import UNIT_ASKED, Blank, LogPlan

_FOLLOWED, _NOT = 0.999, 0.9
"""How much of each reading's variance the load that is meant explains, and another at most."""


@dataclass(frozen=True)
class Meant:
    """The loads to plan with, what is to be filled in, and what could be otherwise."""

    loads: list[ColumnGuess]
    blank: Blank | None = None
    warning: str = ""

    def said_in(self, plan: LogPlan) -> LogPlan:
        """The plan, with what these loads leave open."""
        if self.blank is not None:
            kept = (blank for blank in plan.blanks if blank is not UNIT_ASKED)
            plan = replace(plan, sure="guess", blanks=(self.blank, *kept))
        warnings = (*plan.warnings, self.warning) if self.warning else plan.warnings
        return replace(plan, warnings=warnings)


def meant(loads: list[ColumnGuess], cells: Sequence[ColumnGuess]) -> Meant:
    """The one load that explains all readings where others do not; else the first, asked for."""
    apart = [] if len(loads) == len(cells) > 1 else unlike(loads, list(cells))
    if not apart:
        return Meant(loads)
    left = [min(straightness(numbers_of(load), numbers_of(c)) for c in cells) for load in loads]
    most = max(left)
    if most > _FOLLOWED and sorted(left)[-2] < _NOT:
        own = loads[left.index(most)]
        others = ", ".join(c.column for c in loads if c is not own)
        said = f"{others}: left out, the readings follow {own.column} alone"
        return Meant([replace(own, why="the readings follow it alone of all loads")], None, said)
    one, other = loads[0].column, apart[0].column
    blank = Blank(
        (
            f'# in [columns]: column of load_n is "{one}" or "{other}", and its unit in place of '
            '"?"; or',
            f'# one comes on top: load_n = {{ column = "{one}", unit = "…", plus = '
            f'{{ {toml_key(other)} = "…" }} }}',
        ),
        f"two columns of loads, {one} and {other}, that do not agree",
    )
    return Meant([replace(loads[0], unit=None)], blank)
