"""What a set of linear rows can tell: rank, weakest directions in words, what would show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray

RANK_TOLERANCE = 1e-6
"""Singular values below this share of the largest are zero."""
_SHARE_NAMED = 0.8
_MOST_NAMED = 4
_WHOLLY_UNSEEN = 0.99
_CELLS = ("fl", "fr", "rl", "rr")
_FOOT_PATTERNS: Mapping[str, tuple[int, int, int, int]] = {
    "common part": (1, 1, 1, 1),
    "front against rear": (1, 1, -1, -1),
    "left against right": (1, -1, 1, -1),
    "diagonal twist": (1, -1, -1, 1),
}
"""Patterns over the cells fl, fr, rl, rr."""
_KINDS = {"gain": "gains", "bias": "biases"}


@dataclass(frozen=True)
class Observability:
    """Rank of a row matrix with columns in prior sd.

    Parameters
    ----------
    rank, unknowns
        Directions seen, and in all.
    singular_values
        Largest first, rows in noise sd: the prior sd of a direction over the sd the data alone
        would leave.
    directions
        Unit vectors in prior sd, shape (unknowns, unknowns), in the order of the singular values.
    """

    rank: int
    unknowns: int
    singular_values: FloatArray
    directions: FloatArray
    names: tuple[str, ...]

    def weakest(self, count: int = 3) -> list[str]:
        """What the rows cannot see or see worst, in words.

        Patterns that are wholly unseen come first; what else is unseen, or the weakest seen
        directions where nothing is, follows.
        """
        basis, labels = _pattern_basis(self.names)
        unseen = self.directions[self.rank :] @ basis
        whole = np.sum(unseen**2, axis=0) > _WHOLLY_UNSEEN
        words = [labels[i] for i in np.flatnonzero(whole)][::-1]
        left = np.where(whole, 0.0, unseen)
        _, size, rest = np.linalg.svd(left, full_matrices=False)
        others = [basis @ v for v, s in zip(rest, size, strict=True) if s > 0.5]
        if not len(unseen):
            others = list(self.directions[::-1])
        words += [describe_direction(v, self.names) for v in others[: max(count - len(words), 0)]]
        return words[:count]


def observability(whitened: FloatArray, names: Sequence[str]) -> Observability:
    """Rank and directions of whitened rows.

    Parameters
    ----------
    whitened
        Rows in units of their noise, columns in units of the prior sd, shape (m, p).
    names
        Of the p unknowns.
    """
    p = len(names)
    if whitened.shape[0] < p:
        whitened = np.vstack([whitened, np.zeros((p - whitened.shape[0], p))])
    _, values, right = np.linalg.svd(whitened, full_matrices=False)
    rank = int(np.sum(values > RANK_TOLERANCE * max(values.max(initial=0.0), 1e-300)))
    return Observability(rank, p, values, right, tuple(names))


def describe_direction(direction: FloatArray, names: Sequence[str]) -> str:
    """A direction of parameter space in words.

    "left foot: diagonal twist of the biases" where one pattern of one foot holds 80 % of it, else
    the patterns that hold 80 % together, largest first, at most four.

    Parameters
    ----------
    direction
        Unit vector in prior sd, shape (p,).
    names
        ``<foot>_<cell>.<gain | bias>`` or other parameters.
    """
    basis, labels = _pattern_basis(names)
    weight = direction @ basis
    order = np.argsort(-np.abs(weight))
    needed = int(np.searchsorted(np.cumsum(weight[order] ** 2), _SHARE_NAMED)) + 1
    words = ""
    for place, i in enumerate(order[: min(needed, _MOST_NAMED)]):
        joined = " with " if weight[i] * weight[order[0]] > 0 else " against "
        words += (joined if place else "") + labels[i]
    return words + (" and others" if needed > _MOST_NAMED else "")


def _pattern_basis(names: Sequence[str]) -> tuple[FloatArray, list[str]]:
    """Orthonormal patterns as columns (p, p), and their names.

    Patterns of a foot's gains and of its biases, or single parameters where a foot has other than
    four cells.
    """
    groups: dict[tuple[str, str], dict[str, int]] = {}
    for i, name in enumerate(names):
        owner, _, kind = name.rpartition(".")
        foot, _, cell = owner.partition("_")
        if kind in _KINDS and cell in _CELLS:
            groups.setdefault((foot, kind), {})[cell] = i
    basis, labels = np.eye(len(names)), list(names)
    for (foot, kind), cells in groups.items():
        if len(cells) == len(_CELLS):
            at = [cells[cell] for cell in _CELLS]
            for column, (pattern, signs) in zip(at, _FOOT_PATTERNS.items(), strict=True):
                basis[at, column] = np.array(signs) / 2.0
                labels[column] = f"{foot} foot: {pattern} of the {_KINDS[kind]}"
    return basis, labels


@dataclass(frozen=True)
class NextStep:
    """What an addition to the data would bring.

    Parameters
    ----------
    gain_nats
        Expected information about the unknowns.
    rank
        Of the old and new rows together.
    sd_ratio
        Largest reduction among directions: sd after over sd before of the direction that gains
        most.
    """

    name: str
    gain_nats: float
    rank: int
    sd_ratio: float
    direction: str


def rank_candidates(
    whitened: FloatArray,
    prior_correlation: FloatArray,
    candidates: Mapping[str, FloatArray],
    names: Sequence[str],
) -> list[NextStep]:
    """Order candidate experiments by what they would teach, best first.

    ``½ log det(I + P Hᵀ H)`` with P the covariance after the data in hand.

    Parameters
    ----------
    whitened
        Rows in hand, shape (m, p).
    prior_correlation
        Prior covariance in units of the prior sd, shape (p, p).
    candidates
        Name -> rows it would add, in units of their noise, shape (k, p).
    """
    covariance = np.linalg.inv(np.linalg.inv(prior_correlation) + whitened.T @ whitened)
    root = np.linalg.cholesky(0.5 * (covariance + covariance.T))
    steps = []
    for name, rows in candidates.items():
        # eigenvalues of the information in units of what is still unknown
        values, vectors = np.linalg.eigh(root.T @ (rows.T @ rows) @ root)
        values = np.clip(values, 0.0, None)
        learnt = root @ vectors[:, -1]
        norm = float(np.linalg.norm(learnt))
        steps.append(
            NextStep(
                name=name,
                gain_nats=float(0.5 * np.sum(np.log1p(values))),
                rank=observability(np.vstack([whitened, rows]), names).rank,
                sd_ratio=float(1.0 / np.sqrt(1.0 + values[-1])),
                direction=describe_direction(learnt / max(norm, 1e-300), names),
            )
        )
    return sorted(steps, key=lambda step: -step.gain_nats)
