"""Weights on a foot whose zeros move meanwhile, and cells whose scale no weights measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.bench.cop_study import study_cop
from footcal_cli.core.bench.placement_rows import PlacementRows, holes_of
from footcal_cli.core.checks.holes import check_placed
from footcal_cli.core.parameters import FloatArray
from footcal_cli.intake.empty_plate import carried
from tests.core.bench_data import CELL_POS, CELLS, NAMEPLATE_SCALE, make_foot, placements

KNOWN_BIAS = 283.0


def believed(seed: int) -> tuple[FloatArray, FloatArray, PlacementRows]:
    """True scale over the nameplate's and true positions, and rows by the nameplate's scale."""
    rng = np.random.default_rng(seed)
    foot = make_foot(rng, position_m=0.003)
    foot = replace(foot, bias=np.full(4, KNOWN_BIAS) * foot.scale / NAMEPLATE_SCALE)
    weight, hole, counts = placements(foot, rng, 3)
    rows = PlacementRows(
        CELLS, NAMEPLATE_SCALE * counts + KNOWN_BIAS, CELL_POS, hole, weight, holes_of(hole),
        believed_scale=np.full(4, NAMEPLATE_SCALE),
    )  # fmt: skip
    return foot.scale / NAMEPLATE_SCALE, foot.pos, rows


def test_a_scale_that_no_weights_measured_is_found_by_placements() -> None:
    """What a cell passes on is its gain: recovered with honest sd, and no crosstalk is made up."""
    scale, place = list[FloatArray](), list[FloatArray]()
    for seed in range(12):
        gain, position, rows = believed(seed)
        found = study_cop(rows).chosen.parameters
        assert found is not None
        assert {name.rpartition(".")[2] for name in found.names} == {
            "cell_correction_x", "cell_correction_y", "scale",
        }  # fmt: skip
        names = [f"{cell}.scale" for cell in CELLS]
        value, sd = (np.array([ask(n) for n in names]) for ask in (found.__getitem__, found.sd_of))
        scale.append((value / NAMEPLATE_SCALE - gain) * abs(NAMEPLATE_SCALE) / sd)
        names = [f"{cell}.cell_correction_{axis}" for cell in CELLS for axis in "xy"]
        value, sd = (np.array([ask(n) for n in names]) for ask in (found.__getitem__, found.sd_of))
        place.append((value - (position - CELL_POS).ravel()) / sd)
    for errors in (scale, place):
        assert 0.6 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


def test_an_empty_plate_with_a_drifted_zero_has_no_centre_of_pressure() -> None:
    _, _, rows = believed(0)
    empty = replace(
        rows.select(rows.load_n == rows.load_n.max()),
        forces_n=np.full((int((rows.load_n == rows.load_n.max()).sum()), 4), 3.0),
        load_n=np.zeros(int((rows.load_n == rows.load_n.max()).sum())),
    )
    assert (empty.total_n > empty.min_force_n).all()
    assert not empty.valid.any()
    assert np.isnan(empty.raw_cop_m).all()


@pytest.mark.parametrize("drift_n", [0.0, 9.0])
def test_a_zero_that_moves_is_no_weight_on_its_way(drift_n: float) -> None:
    """A spell at the end, all cells 9 N up of 120 N, is empty; rows of the full weight are not."""
    spell = np.repeat([0, 1, 0, 1, 0], 100)
    force = 30.0 * spell[:, None] + drift_n / 4 * (np.arange(500) > 350)[:, None] * np.ones(4)
    noted = np.where(spell == 1, 120.0, 0.0)
    noted[195:205] = 0.0  # its label goes before it does, and comes late
    on_the_way = carried(force, noted)
    assert set(np.flatnonzero(on_the_way)) == set(range(195, 200))


@pytest.mark.parametrize(
    ("moved_n", "said"), [((0.0, 0.0), False), ((0.0, 5.0), True), ((0.0, 1.0), False),
                          ((0, 4, 5, 1, 0, 4, 3, 5), False), ((0, 0.4, 1, 2, 3, 3.2, 4, 5), True)],
)  # fmt: skip
def test_zeros_that_moved_between_empty_plates_are_said(
    moved_n: tuple[float, ...], said: bool
) -> None:
    """5 N of 100 N from the first to the last are more than a pair's 2 %, and than chance."""
    force = [[x + (100.0 if loaded else 0.0) / 3, *[100.0 * loaded / 3] * 2]
             for x in moved_n for loaded in (0, 1)]  # fmt: skip
    load = np.tile([0.0, 100.0], len(moved_n))
    found = [f for f in check_placed(np.array(force), CELLS[:3], load) if f.code == "zero_moves"]
    assert [f.where for f in found] == (["left_fl"] if said else [])
