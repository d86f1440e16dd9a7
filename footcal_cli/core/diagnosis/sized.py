"""Whether what was named surely has a size.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks.
"""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.growth import chance_of_nothing
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.signatures import SWITCHES


def is_sized(
    effect: Effect,
    cause: Cause,
    intervals: Mapping[str, Interval],
    model: Refit | None,
    blocks: int,
    alpha: float,
) -> bool:
    """Whether a size of a single name is as surely not nothing as a name is to be.

    One of them at ``1 − α``; or all together where no block follows the one before. What changes
    with time is fitted to noise that drifts, whose blocks are alike: all sizes together follow it
    where none is known for itself. Switches are on or off.

    Parameters
    ----------
    effect, cause
        With the interval of its size, which holds what a calibration known before is off by.
    intervals
        95 % intervals of all sizes and shapes, by name.
    model
        On which they were fitted.
    blocks, alpha
        Of the log; α.
    """
    size = next(p for p in effect.sizes if p.name == cause.signature.parameter)
    if effect.name in SWITCHES or size.neutral != 0.0 or model is None:
        return True
    free = max(blocks - 1, 1)
    wider = float(chances.t_ppf(1.0 - 0.5 * alpha, free) / chances.t_ppf(0.975, free))
    others = {p.name for p in effect.sizes} - {size.name}
    sure = [i.sureness for name, i in intervals.items() if name.rsplit(".", 1)[1] in others]
    if max([cause.size.sureness, *sure]) >= wider:
        return True
    together = len(effect.sizes) > 1 and Trait.TIMED not in effect.traits
    return together and chance_of_nothing(effect, model) < alpha
