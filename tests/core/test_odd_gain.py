"""One cell of a foot whose gain is off, by placements: named, sized, and not seen where it is not.

Under a stiff plate the forces of four cells follow the load and its two moments: gains and places
of all cells explain one another, and only what needs one number says which cell it is.
"""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.bench.cop_kinds import GAIN_MODELS, GAINS
from footcal_cli.core.bench.cop_models import fit_cop
from footcal_cli.core.bench.cop_study import study_cop
from footcal_cli.core.bench.odd_gain import odd_gain, odd_gain_of
from footcal_cli.core.bench.placement_rows import PlacementRows
from footcal_cli.core.bench.shared_loads import zeros_seen
from footcal_cli.core.parameters import FloatArray

CELLS_M = np.array([[0.1, 0.06], [0.1, -0.06], [-0.1, -0.06], [-0.1, 0.06]])
HOLES = np.stack(np.meshgrid(np.linspace(-0.08, 0.08, 7), np.linspace(-0.05, 0.05, 5)), -1)
LOAD_N, PLAY_M, NOISE_N = 118.0, 3e-4, 0.05


def rows(seed: int, gain: FloatArray, rounds: int = 3) -> PlacementRows:
    """Placements on a stiff plate whose cells sit within 0.2 mm of the drawing."""
    rng = np.random.default_rng(seed)
    hole = np.tile(HOLES.reshape(-1, 2), (rounds, 1))
    at = hole + PLAY_M * rng.standard_normal(hole.shape)
    cells = CELLS_M + 2e-4 * rng.standard_normal(CELLS_M.shape)
    carried = np.vstack([np.ones(4), cells.T])
    uneven = 1.0 + 0.05 * rng.standard_normal(4)  # springs below the corners
    share = uneven[:, None] * carried.T @ np.linalg.inv((carried * uneven) @ carried.T)
    force = LOAD_N * np.column_stack([np.ones(len(at)), at]) @ share.T
    read = force * gain + NOISE_N * rng.standard_normal(force.shape)
    number = np.tile(np.arange(35), rounds)
    return PlacementRows(
        ("f1", "f2", "f3", "f4"), read, CELLS_M, hole, np.full(len(at), LOAD_N), number,
        believed_scale=np.ones(4),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_the_cell_is_named_with_its_gain(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    gain = 1.0 + 0.001 * rng.standard_normal(4)
    cell = int(rng.integers(4))
    off = float(rng.choice([-1, 1]) * rng.uniform(0.03, 0.06))
    gain[cell] += off
    placed = rows(seed, gain)
    odd = odd_gain(study_cop(placed, GAIN_MODELS), placed)
    assert odd is not None
    assert odd.cell == f"f{cell + 1}"
    others = np.delete(gain, cell).mean()
    assert odd.reads == pytest.approx(gain[cell] / others - 1.0, abs=0.004)
    assert odd_gain_of(placed) is not None, "without the other corrections, too"


@pytest.mark.parametrize("seed", range(6))
def test_ordinary_cells_are_left_alone(seed: int) -> None:
    gain = 1.0 + 0.003 * np.random.default_rng(200 + seed).standard_normal(4)
    assert odd_gain_of(rows(seed, gain)) is None


def test_two_cells_are_no_single_one() -> None:
    assert odd_gain_of(rows(3, np.array([1.05, 1.0, 0.95, 1.0]))) is None


def test_gains_of_cells_that_sit_where_the_drawing_has_them_err_as_stated() -> None:
    ratios = []
    for seed in range(24):
        gain = 1.0 + 0.02 * np.random.default_rng(300 + seed).standard_normal(4)
        placed = rows(seed, gain)
        one = next(r for r in study_cop(placed, (GAINS,)).results if r.fit.model == GAINS)
        assert one.parameters is not None
        scale, sd = one.parameters.values, one.parameters.sd
        ratios.append((scale - 1.0 / gain) / sd)
    assert 0.7 < np.sqrt(np.mean(np.square(ratios))) < 2.0, "places 0.2 mm off are no part of sd"
    assert fit_cop(GAINS, rows(0, np.ones(4))).shares == pytest.approx(np.ones(4), abs=0.003)


def test_zeros_are_seen_by_loads_of_several_sizes() -> None:
    rng = np.random.default_rng(0)
    hole = np.repeat(np.array([[0, 0], [0.07, 0.03], [0.07, -0.03], [-0.07, -0.03]]), 6, axis=0)
    load = np.tile([3.4, 52.5, 101.5, 150.6, 199.7, 248.7], 4)
    share = np.linalg.lstsq(np.vstack([np.ones(4), CELLS_M.T]), np.eye(3), rcond=None)[0]
    force = load[:, None] * np.column_stack([np.ones(24), hole]) @ share.T
    zero = np.array([-21000.0, 86000.0, -36000.0, 81000.0])
    counts = zero + 2150.0 * force + 30.0 * rng.standard_normal(force.shape)
    found = zeros_seen(counts, load, hole)
    assert found is not None
    assert found == pytest.approx(zero, abs=60.0)
    assert zeros_seen(counts, np.full(24, 100.0), hole) is None, "of one weight no zero is seen"
