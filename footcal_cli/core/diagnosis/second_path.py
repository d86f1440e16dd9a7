"""A part that touches beside one cell: the law of a cell that bends at a knee.

Of the room of the diagnosis; `diagnose` asks once an answer stands. A cover, a cable or an edge
that takes load at one corner takes it from the cell there: ``y = x − s · max(x − h, 0)``, whether
the cell bends or the load goes past it. Weights on the cell alone see the first and not the second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Cause, Verdict
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.rehearsal import usual
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait, is_six_axis
from footcal_cli.core.inference.case import channels_of

_OF_THE_SUM = having(Trait.OF_THE_SUM)


def with_second_path(found: Investigation, table: Mapping[str, Effect]) -> Investigation:
    """`found`, with a second load path as a rival of a knee at which one cell loses load.

    Parameters
    ----------
    table
        Effects by name that an answer may name.
    """
    if found.verdict not in (Verdict.NAMED, Verdict.AMBIGUOUS) or _has_no_sum(found):
        return found
    items = tuple(_beside(item, found.case.experiment.name, table) for item in found.found)
    if items == found.found:
        return found
    return replace(found, found=items, verdict=Verdict.AMBIGUOUS)


def _has_no_sum(found: Investigation) -> bool:
    """Whether outputs are wrenches, which hold no load of several cells together."""
    return is_six_axis(channels_of(found.case.logs))


def _beside(item: Found, experiment: str, table: Mapping[str, Effect]) -> Found:
    cause = item.cause
    said = list(_effects(cause))
    cells = [cell for _, units in cause.signature.owners for cell in units]
    if len(cells) != 1 or not CURVES.issuperset(said) or not _loses(item):
        return item
    knees = [table[n] for n in said if n in table and Trait.KNEE in table[n].traits]
    paths = {
        n for knee in knees for n in knee.mimics
        if n in _OF_THE_SUM and n in table and experiment in table[n].experiments
    }  # fmt: skip
    if not paths:
        return item
    rivals = [s for s in cause.rivals if s.effect not in paths]
    rivals += [usual(table[name], cells[0]) for name in sorted(paths)]
    # what was refitted is a path beside all cells of the foot
    compared = {name: other for name, other in cause.compared.items() if name not in paths}
    return replace(item, cause=replace(cause, rivals=tuple(rivals), compared=compared))


def _effects(cause: Cause) -> Iterable[str]:
    return (s.effect for s in (cause.signature, *cause.rivals))


def _loses(item: Found) -> bool:
    """Whether the cell shows less above than below; a size of one sign only is what is lost."""
    size, row = item.cause.size.value, item.effect.size
    return size > 0.0 if row.lower == row.neutral else size < 0.0
