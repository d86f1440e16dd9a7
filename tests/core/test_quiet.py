"""Stances of a stand of which nothing but the forces is known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from footcal_cli.core.quiet import _cut, _shifted

PERIOD_S = 0.01


def standing(shares: list[float], noise_n: float, rng: np.random.Generator) -> np.ndarray:
    """Forces of two cells: holds of 3 s, weight moved within 0.6 s between them."""
    parts = [np.full(300, shares[0])]
    for before, after in pairwise(shares):
        parts += [np.linspace(before, after, 60), np.full(300, after)]
    share = np.concatenate(parts)
    force = 700.0 * np.column_stack([share, 1.0 - share])
    return force + noise_n * rng.normal(size=force.shape)


def test_weight_that_moves_makes_another_stance_and_noise_makes_none() -> None:
    rng = np.random.default_rng(1)
    still = np.ones(1020, dtype=bool)
    moved = _shifted(standing([0.3, 0.5, 0.7], 2.0, rng), PERIOD_S)
    holds = _cut(still, moved, 140)
    edges = np.flatnonzero(np.diff(holds.astype(int)))
    assert edges.size == 4
    assert np.all(np.abs(edges - [300, 360, 660, 720]) < 40)
    quiet = _shifted(standing([0.5, 0.5, 0.5], 10.0, rng), PERIOD_S)
    assert _cut(still, quiet, 140).all()


def test_a_person_who_always_sways_keeps_one_stance() -> None:
    share = 0.5 + 0.2 * np.sin(np.arange(1000) * PERIOD_S * 4.0)
    moved = _shifted(700.0 * np.column_stack([share, 1.0 - share]), PERIOD_S)
    assert _cut(np.ones(1000, dtype=bool), moved, 140).all()
