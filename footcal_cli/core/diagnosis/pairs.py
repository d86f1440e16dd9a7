"""Two causes at once, where one at a time leads astray.

Of two effects that share their drivers neither may be the best single explanation: a third name
that resembles both takes the first step, and what is left then fits nothing. All pairs of
candidates together are as cheap to compare as all singles, on the same inner products.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.effects.contract import Effect, Stage, Trait

_SPREAD = 3.0  # sd of its own by which a size may lie beyond its bounds


def likely_pairs(lib: Library, rules: Rules) -> list[tuple[int, int]]:
    """Candidates that together explain most, best first; of pairs that resemble each other one.

    With ``z`` the scores of two candidates in units of their sd and ``c`` their cosine, calibration
    projected off, they explain ``(z₁² + z₂² − 2 c z₁ z₂)/(1 − c²)`` at the sizes
    ``(z₁ − c z₂)/(1 − c²)``. Pairs that look alike are left out: together they may copy a third;
    so are sizes that cannot be, half a swap of two channels.

    Returns
    -------
    Numbers of candidates, the one that explains more on its own first.
    """
    found = lib.alone
    power = np.diag(lib.products)
    shown = np.flatnonzero(lib.testable & (power > 0) & (found.inside == 0))
    if shown.size < 2:
        return []
    sd = np.sqrt(power[shown])
    z = found.score.sum(axis=0)[shown] / sd
    cos = lib.products[np.ix_(shown, shown)] / np.outer(sd, sd)
    effects = np.array([lib.problem.signatures[i].effect for i in shown])
    like = np.abs(cos)
    apart = (like < rules.alike_together) & (effects[:, None] != effects)
    rest = np.maximum(1.0 - cos**2, 1.0 - rules.alike_together**2)
    size = (z[:, None] - cos * z) / rest / sd[:, None]
    spread = _SPREAD / (sd[:, None] * np.sqrt(rest))
    allowed = [lib.problem.signatures[i] for i in shown]
    lower, upper = (np.array([getattr(s, e) for s in allowed])[:, None] for e in ("lower", "upper"))
    possible = (size >= lower - spread) & (size <= upper + spread)
    both = z[:, None] ** 2 + z**2 - 2.0 * cos * np.outer(z, z)
    gain = np.where(apart & possible & possible.T, both / rest, 0.0)
    pairs: list[tuple[int, int]] = []
    while len(pairs) < rules.most_pairs and gain.max() > 0:
        i, j = (int(n) for n in np.unravel_index(int(np.argmax(gain)), gain.shape))
        pairs.append((i, j) if abs(z[i]) >= abs(z[j]) else (j, i))
        # what resembles these two is their rival, and each is compared with it
        one, other = like[i] > rules.look_alike, like[j] > rules.look_alike
        gain[np.outer(one, other) | np.outer(other, one)] = 0.0
    return [(int(shown[first]), int(shown[second])) for first, second in pairs]


def in_same_cells(
    table: Mapping[str, Effect], causes: Sequence[Cause], *, at_once: bool = True
) -> list[tuple[int, int]]:
    """Numbers of each two causes that distort what the same cells show of their own loads.

    A loop of another form than the table's is a loop and a curve in the same cells, a curve of
    another form two curves. What a cell hears of others is the form of neither; nor, where one was
    found after the other, is what is surely in further cells too.

    Parameters
    ----------
    at_once
        Whether the causes were looked for together, so that a small one may count.
    """
    own = [
        i for i, cause in enumerate(causes)
        if table[cause.signature.effect].stage is Stage.CELL
        and Trait.MIXTURE not in table[cause.signature.effect].traits
    ]  # fmt: skip

    def same(first: Cause, later: Cause) -> bool:
        mine, its = (
            {member for _, members in cause.signature.owners for member in members}
            for cause in (first, later)
        )
        return not mine.isdisjoint(its) and (at_once or its <= mine or bool(later.places))

    return [(i, k) for i, k in itertools.combinations(own, 2) if same(causes[i], causes[k])]
