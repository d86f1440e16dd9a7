"""How often a hidden effect could be found and told from every other name, by who knows all else.

The oracle knows the form, place, sign and size of what may be hidden and the law of the noise; what
calibration is (where it wanders: by which random walk) it does not know. It may be wrong in one
trial of a hundred. After calibration is fitted too, an effect has the signature s⊥, and among all
tests that calibration cannot sway none finds it more often than ``s⊥ᵀC⁻¹y > z₀.₉₉ ‖s⊥‖``, with
C the covariance of the noise and ``‖s⊥‖² = s⊥ᵀC⁻¹s⊥ = d₀²`` (Neyman and Pearson): its power is
``Φ(d₀ − z₀.₉₉)``, one-sided since the sign is known. Against another effect of any size d₀ becomes
d₁, what that one's best fit leaves of s⊥; against several the power is at most that against the
nearest. So no answer that names wrongly once in a hundred is right more often than
``Φ(d₀ − z₀.₉₉)`` or exact more often than ``Φ(d₁ − z₀.₉₉)``, ``d₁ ≤ d₀``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from tests.blind.rivals import ONE_WAY, Rival, rivals
from tests.blind.wandering import follower
from tests.blind.whitening import Whitening, inputs_of, whitened
from tests.blind.world import Array, Ints, World
from tests.blind.yardstick import Yardstick, wandering_rates

WRONG = 0.01
"""Share of wrong names that is allowed."""
ABSORBED = 1e-8
"""A signature of which calibration leaves less than this share (of its square) is none."""


def attained(distance: float) -> float:
    """How often an effect is told at that distance, by a test that is wrong once in a hundred."""
    return float(stats.norm.cdf(distance - stats.norm.isf(WRONG)))


@dataclass(frozen=True)
class Gram:
    """Products of signatures, over the noise, after calibration was fitted.

    Parameters
    ----------
    products
        Shape (p, p).
    whole
        Squared norms before, shape (p,).
    """

    products: Array
    whole: Array

    def left(self, column: int, beside: Sequence[int], one_way: Sequence[int] = ()) -> float:
        """Squared norm of a signature after others, of any size, were fitted.

        Parameters
        ----------
        one_way
            One of those beside, if any, that counts with a positive size only.
        """
        own = float(self.products[column, column])
        others = [i for i in beside if self.products[i, i] > ABSORBED * self.whole[i]]
        if not others:
            return own
        scale = np.sqrt(self.products[others, others])
        inner = self.products[np.ix_(others, others)] / np.outer(scale, scale)
        shared = self.products[others, column] / scale
        sizes = np.linalg.pinv(inner, 1e-9, hermitian=True) @ shared
        if any(i in one_way and size < 0.0 for i, size in zip(others, sizes, strict=True)):
            return self.left(column, [i for i in beside if i not in one_way])
        return max(own - float(shared @ sizes), 0.0)


def limits(
    clean: World,
    stick: Yardstick,
    alone: Sequence[World],
    right: Sequence[Sequence[str]],
) -> dict[str, Any]:
    """What the oracle reaches in one trial.

    Parameters
    ----------
    alone
        The clean world with each hidden effect alone.
    right
        The right names of each.

    Returns
    -------
    dict
        ``d0`` and ``d1`` of each effect beside the others, the ``nearest`` other name, and the
        shares of ``right`` and ``exact`` answers.
    """
    inputs = inputs_of(clean, stick)
    law = Whitening(clean, stick, inputs)
    hidden = [law.entries(stick.maker.error(world) - stick.clean_error) for world in alone]
    names, numbers, columns = _columns(law, rivals(clean, stick, inputs))
    gram = gram_of(law, np.column_stack([*hidden, *columns]))
    whole, near, nearest = [], [], []
    for i, mine in enumerate(right):
        beside = [j for j in range(len(hidden)) if j != i]
        found, best, who = gram.left(i, beside), np.inf, ""
        for name, group in zip(names, numbers, strict=True):
            theirs = (group + len(hidden)).tolist()
            bound = theirs if name in ONE_WAY else []
            left = np.inf if name in mine else gram.left(i, [*beside, *theirs], bound)
            best, who = (left, name) if left < best else (best, who)
        whole.append(float(np.sqrt(found)))
        near.append(float(np.sqrt(min(best, found))))
        nearest.append(who)
    return {
        "d0": whole,
        "d1": near,
        "nearest": nearest,
        "right": attained(min(whole)),
        "exact": attained(min(near)),
    }


def _columns(law: Whitening, found: Iterable[Rival]) -> tuple[list[str], list[Ints], list[Array]]:
    """Signatures of all rivals that show at all, with the columns of each."""
    names: list[str] = []
    numbers: list[Ints] = []
    columns: list[Array] = []
    for name, group in found:
        seen = [column for column in map(law.entries, group) if column.any()]
        if seen:
            names.append(name)
            numbers.append(len(columns) + np.arange(len(seen)))
            columns += [column / np.sqrt(np.mean(column**2)) for column in seen]
    return names, numbers, columns


def gram_of(law: Whitening, columns: Array) -> Gram:
    """Products of signatures (entries, p) after the calibration was fitted, or followed."""
    moves = np.stack([law.entries(move * law.stick.noise) for move in law.stick.moves], axis=1)
    sizes = np.sqrt(np.mean(moves**2, axis=0)) + 1e-300
    moves /= sizes
    wanders = any(law.world.drift_per_root_s)
    rates = sizes * wandering_rates(law.world) if wanders else None
    follow = None if rates is None else follower(law.time_s, rates.tolist())
    size = follow.size if follow else moves.shape[1]
    inner, across = np.zeros((size, size)), np.zeros((size, columns.shape[1]))
    products = np.zeros((columns.shape[1], columns.shape[1]))
    for block in law.blocks():
        if follow:
            own, loose = follow.columns(moves[block.entries], block.entries)
        else:
            own, loose = np.arange(size), moves[block.entries]
        white = whitened(block, np.hstack([loose, columns[block.entries]]))
        free, fixed = white[:, : own.size], white[:, own.size :]
        inner[np.ix_(own, own)] += free.T @ free
        across[own] += free.T @ fixed
        products += fixed.T @ fixed
    if follow:
        inner += follow.prior
    scale = np.sqrt(np.diag(inner)) + 1e-300
    inverse = np.linalg.pinv(inner / np.outer(scale, scale), 1e-11, hermitian=True)
    across /= scale[:, None]
    return Gram(products - across.T @ inverse @ across, np.diag(products).copy())
