"""One cell of a foot whose gain is unlike the others': the simplest thing that placements show.

Room: core/bench; `offline-fit` and `diagnose` ask. Under a rigid plate the forces of four cells
follow the two coordinates of the load, so that gains and places of all cells explain each other; a
model of them spreads one wrong gain over all. What one number explains needs no twelve.
"""

from __future__ import annotations

from dataclasses import dataclass

from footcal_cli.core.bench.cop_kinds import GAINS_AND_PLACES, NONE, ONE_GAIN
from footcal_cli.core.bench.cop_study import CopStudy, gain_between, study_cop
from footcal_cli.core.bench.placement_rows import PlacementRows
from footcal_cli.core.quality import Finding

SHARE = 0.85
"""Of what any physical model explains at left-out placements, in CoP and force, one gain does."""
_SURE = 6.0
"""Its sd by which it must differ from the others."""


@dataclass(frozen=True)
class OddGain:
    """A cell that reads too much or too little next to the others.

    Parameters
    ----------
    cell
        Its channel.
    reads
        By which share it reads too much, and its sd.
    sd
        By leaving out one placement after the other.
    share
        The smaller one of what this gain explains of CoP and of force, as a share of the squared
        errors that the best physical model explains.
    """

    cell: str
    reads: float
    sd: float
    share: float


def odd_gain_of(rows: PlacementRows) -> OddGain | None:
    """`odd_gain` where no corrections were compared yet."""
    return odd_gain(study_cop(rows, (NONE, ONE_GAIN, GAINS_AND_PLACES)), rows)


def odd_gain(study: CopStudy, rows: PlacementRows) -> OddGain | None:
    """The one cell whose gain explains nearly all; None where none does, or several must.

    Parameters
    ----------
    study, rows
        Corrections compared on placements, and these.
    """
    by_name = {result.name: result for result in study.results}
    none, one = by_name.get(NONE.name), by_name.get(ONE_GAIN.name)
    if none is None or one is None or study.physical is None or one.parameters is None:
        return None
    best, shares = study.results[study.physical], list[float]()
    for before, after, least in (
        (none.left_out, one.left_out, best.left_out),
        (none.left_out_total, one.left_out_total, best.left_out_total),
    ):
        bought = gain_between(before, after)[0]
        if not bought > 0.0:
            return None
        shares.append(bought / max(gain_between(before, least)[0], bought))
    cell = max(range(len(rows.cells)), key=lambda k: abs(one.fit.shares[k] - 1.0))
    scale, sd = one.parameters.values[cell], one.parameters.sd[cell]
    if min(shares) < SHARE or rows.believed_scale is None:
        return None
    believed = float(rows.believed_scale[cell])
    reads, sd = believed / scale - 1.0, believed * sd / scale**2
    return OddGain(rows.cells[cell], reads, sd, min(shares)) if abs(reads) > _SURE * sd else None


def gain_finding(odd: OddGain) -> Finding:
    """The warning that names the cell."""
    more = "more" if odd.reads > 0 else "less"
    return Finding(
        "cell_gain", "warning", odd.cell,
        f"it reads {100 * abs(odd.reads):.2g} ± {100 * odd.sd:.2g} % {more} than the scale that is "
        f"believed, which all other cells keep: this one gain explains {100 * odd.share:.0f} % of "
        "what any gains and places of all cells do",
        "put known weights on this cell alone, and look at the setting of its amplifier",
    )  # fmt: skip
