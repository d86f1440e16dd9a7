"""A part that touches at one cell: the law of a cell that bends.

Of the room of the diagnosis; `diagnose` asks once an answer stands. A cover, a cable or an edge
that takes load at one corner takes it from the cell there: ``y = x − s · max(x − h, 0)``, whether
the cell bends or the load goes past it. Weights on the cell alone see the first and not the second.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.rehearsal import usual
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait, is_six_axis
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.log import Log
from footcal_cli.core.quality import Finding

_OF_THE_SUM = having(Trait.OF_THE_SUM)
_STEPS = 101
_BEYOND = 2.0
_RCOND = 1e-9


@dataclass(frozen=True)
class StraightCell:
    """What weights on a cell alone have shown.

    Parameters
    ----------
    load_n
        The largest of them.
    spread_n
        Between the lowest and the highest error of a line through all.
    """

    load_n: float
    spread_n: float


def with_second_path(
    found: Investigation, table: Mapping[str, Effect], straight: Mapping[str, StraightCell]
) -> Investigation:
    """`found`, with a second load path as a rival of a curve by which one cell loses load.

    Of one with a knee; and of any that weights on the cell exclude.

    Parameters
    ----------
    table
        Effects by name that an answer may name.
    straight
        Cells that were calibrated with weights.
    """
    if found.verdict not in (Verdict.NAMED, Verdict.AMBIGUOUS):
        return found
    items = tuple(_beside(item, found, table, straight) for item in found.found)
    if items == found.found:
        return found
    return replace(found, found=items, verdict=Verdict.AMBIGUOUS)


def against_the_bench(
    found: Investigation, straight: Mapping[str, StraightCell]
) -> Iterator[Finding]:
    """Curves of an answer that weights on the cell would have shown."""
    for item in found.found:
        cell = _bent_cell(item)
        bend_n = _bend_n(item, found, straight.get(cell))
        if bend_n:
            seen = straight[cell]
            ways = "look for a part that touches there; " if _loses(item) else ""
            yield Finding(
                "curve_unlike_bench", "warning", cell,
                f"on the bench loads up to {seen.load_n:.0f} N were within {seen.spread_n:.2g} N "
                f"of a line, and this curve would be off by {bend_n:.2g} N",
                f"{ways}put weights on this cell again, as it is mounted",
            )  # fmt: skip


def _beside(
    item: Found,
    found: Investigation,
    table: Mapping[str, Effect],
    straight: Mapping[str, StraightCell],
) -> Found:
    cause, cell = item.cause, _bent_cell(item)
    if not cell or not _loses(item):
        return item
    known = [table[n] for n in cause.effects if n in table]
    bent = known if _bend_n(item, found, straight.get(cell)) else [
        effect for effect in known if Trait.KNEE in effect.traits
    ]  # fmt: skip
    experiment = found.case.experiment.name
    paths = {
        n for effect in bent for n in effect.mimics
        if n in _OF_THE_SUM and n in table and experiment in table[n].experiments
    } - cause.effects  # fmt: skip
    if not paths:
        return item
    rivals = [*cause.rivals, *(usual(table[name], cell) for name in sorted(paths))]
    # what was refitted is a path past all cells of the foot
    compared = {name: other for name, other in cause.compared.items() if name not in paths}
    return replace(item, cause=replace(cause, rivals=tuple(rivals), compared=compared))


def _bent_cell(item: Found) -> str:
    """The one load cell that a cause says to bend, whatever its curve; empty for all else."""
    cells = [cell for _, units in item.cause.signature.owners for cell in units]
    one = len(cells) == 1 and not is_six_axis(cells)
    bends = item.effect.name in CURVES and item.cause.effects <= CURVES | _OF_THE_SUM
    return cells[0] if one and bends else ""


def _loses(item: Found) -> bool:
    """Whether the cell shows less above than below; a size of one sign only is what is lost."""
    size, row = item.cause.size.value, item.effect.size
    return size > 0.0 if row.lower == row.neutral else size < 0.0


def _bend_n(item: Found, found: Investigation, seen: StraightCell | None) -> float:
    """By how much a curve leaves its line over the loads of the bench, N; 0 where that may be."""
    if seen is None or found.model is None:
        return 0.0
    values, owner = found.model.values, item.owner
    load = np.linspace(0.0, seen.load_n, _STEPS)[:, None]
    of_rows = np.arange(_STEPS)
    ramp = Log("weights", (_bent_cell(item),), of_rows.astype(float), load, {}, 0 * of_rows)
    theta = {p.name: np.array([values[f"{owner}.{p.name}"]]) for p in item.effect.parameters}
    shown, _ = item.effect.apply(ramp, theta, None)
    bend = float(np.ptp(left_by(np.hstack([np.ones_like(load), load]), shown.readings, _RCOND)))
    return bend if bend > _BEYOND * seen.spread_n else 0.0
