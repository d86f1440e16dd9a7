"""What wanders on a bench, on which no block shows two cells: alike in all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.wandering import wandering_columns, wandering_variance

CELLS, SESSIONS, ROWS = 5, 4, 16
GAIN_SD = 0.02


def bench(seed: int, gain_sd: float = GAIN_SD) -> Problem:
    """Ladders on cells in turn; a gain and a zero of each session, in units of the noise."""
    rng = np.random.default_rng(seed)
    load = np.tile(np.linspace(0.0, 200.0, ROWS), CELLS * SESSIONS)
    block = np.repeat(np.arange(CELLS * SESSIONS), ROWS)
    cell = block // SESSIONS
    gain = gain_sd * rng.standard_normal(CELLS * SESSIONS)
    residual = gain[block] * (load - 100.0) + rng.standard_normal(load.size)
    of_cell = cell[:, None] == np.arange(CELLS)
    calibration = np.hstack([of_cell * load[:, None] / 100.0, of_cell * 1.0])
    return Problem(
        residual=residual, calibration=calibration, columns=np.empty((load.size, 0)),
        signatures=(), block=block, output=np.zeros(load.size, dtype=np.int64), sequence=block,
        outputs=("force",), units=("N",), noise=np.ones(load.size), tolerance=np.ones(1),
    )  # fmt: skip


def test_the_columns_of_a_cell_are_its_own_and_no_rounding_mixes_them() -> None:
    problem = bench(0)
    near = 1.0 + 1e-12 * np.random.default_rng(1).standard_normal(problem.calibration.shape)
    turned = replace(problem, calibration=problem.calibration * near)
    one, other = (wandering_columns(p, p.law.whitener) for p in (problem, turned))
    assert one.shape[1] == 2 * CELLS
    cells = [np.unique(problem.block[np.abs(column) > 0] // SESSIONS) for column in one.T]
    assert all(own.size == 1 for own in cells)
    np.testing.assert_allclose(np.abs(other), np.abs(one), atol=1e-6 * np.abs(one).max())


@pytest.mark.parametrize("gain_sd", [0.0, GAIN_SD])
def test_few_sessions_of_many_cells_know_one_law(gain_sd: float) -> None:
    """The sd that all sessions show, in closed form: ``var(g) Σ(x − x̄)² + 1`` per direction."""
    spread, found = [], []
    for seed in range(20):
        problem = bench(seed, gain_sd)
        grams, _ = whitened_grams(problem, problem.columns)
        variance = wandering_variance(grams.rows, grams.calibration, grams.wandering, bench=True)
        z = wandering_columns(problem, problem.law.whitener)
        load = np.linspace(-100.0, 100.0, ROWS)
        # what a gain of one does to the two directions of a cell, by least squares
        mine = np.flatnonzero(problem.block == 0)
        part = z[mine][:, np.abs(z[mine]).max(axis=0) > 0]
        size = np.linalg.lstsq(part, load, rcond=None)[0]
        spread.append(gain_sd**2 * float(size @ size))
        at = np.flatnonzero(np.abs(z[mine]).max(axis=0) > 0)
        found.append(variance[at].sum())
    if gain_sd == 0.0:
        assert np.mean(found) < 0.5  # in units of what one session says of it
    else:
        # of maximum likelihood: the line of each cell takes one of its sessions
        expected = (1.0 - 1.0 / SESSIONS) * np.mean(spread)
        assert np.mean(found) == pytest.approx(expected, rel=0.3)
