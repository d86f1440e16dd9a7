"""How much worse the other names explain the data."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import Diagnosis
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.evidence import Interval, jackknife_interval
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sheets.diagnosis.words import words


def next_best(found: Investigation) -> str | None:
    """The best other name for the first cause, and by how much it is worse."""
    if not found.found:
        return None
    diagnosis, mine = found.rounds[0], found.found[0].cause.signature.effect
    taken = {f.cause.signature.effect for f in found.found}
    best = losses_with(diagnosis, mine)
    others = {
        effect: loss
        for effect in dict.fromkeys(cause[0] for cause in diagnosis.library.causes)
        if effect not in taken and (loss := losses_with(diagnosis, effect)) is not None
    }
    if best is None or not others:
        return None
    name = min(others, key=lambda effect: others[effect].sum())
    worse = _difference(best, others[name])
    return (
        f"The next best name, {words(name)}, leaves errors {_percent(worse)} larger than "
        f"{words(mine)} does."
    )


def against_rivals(found: Investigation) -> list[str]:
    """Difference of held-out errors between each named effect and its rivals."""
    lines = []
    for item in found.found:
        mine = item.cause.signature.effect
        best = losses_with(item.answer, mine)
        for rival in dict.fromkeys(r.effect for r in item.cause.rivals):
            loss = losses_with(item.answer, rival)
            if best is not None and loss is not None:
                lines.append(
                    f"{words(rival)} leaves errors {_percent(_difference(best, loss))} larger than "
                    f"{words(mine)}: no difference to rely on."
                )
    return [line[0].upper() + line[1:] for line in lines]


def losses_with(diagnosis: Diagnosis, effect: str) -> FloatArray | None:
    """Squared held-out error of each block with an effect where it explains most, shape (B,)."""
    evidence = diagnosis.search.first
    causes = [c for c, cause in enumerate(diagnosis.library.causes) if cause[0] == effect]
    if not causes:
        return None
    best = causes[int(np.argmax(evidence.gain.sum(axis=0)[causes]))]
    loss: FloatArray = diagnosis.before.loss - evidence.plain_gain[:, best]
    return loss


def _difference(best: FloatArray, other: FloatArray) -> Interval:
    """Relative excess of the RMS error, with its interval over blocks."""

    def excess(a: float, b: float) -> float:
        return float(np.sqrt(max(b, 1e-300) / max(a, 1e-300))) - 1.0

    a, b = best.sum(), other.sum()
    without = np.array([excess(a - x, b - y) for x, y in zip(best, other, strict=True)])
    return jackknife_interval(excess(a, b), without)


def _percent(interval: Interval) -> str:
    low, value, high = (100 * x for x in (interval.low, interval.value, interval.high))
    return f"{value:.1f} % [{low:.1f}, {high:.1f}]".replace("-", "−")
