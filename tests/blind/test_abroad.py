"""Causes hidden in the foreign world on development seeds, calibrated and diagnosed by commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.blind.abroad_bench import TRIALS, answer, diagnosed, named_sets, seed_of
from tests.blind.abroad_fleet import fleet_trials, mixed
from tests.foreign import placements
from tests.foreign.biped import draw_biped

SEEN = (
    ("placements clean", 310),
    ("placements cell", 310),
    ("placements drift", 300),
    ("pose clean", 320),
    ("pose half turn", 301),
    ("pose drift", 301),
    ("pose plugs", 300),
)
"""Kind and number: causes ended unnamed or absorbed before, clean logs were left alone."""


ANKLES = (
    pytest.param("ankles mirrored", 717, marks=pytest.mark.slow),
    pytest.param("ankles jump", 701, marks=pytest.mark.slow),
    ("ankles clean", 702),
    ("stance clean", 701),
    ("stance clean", 834),
)
"""Walks on six-axis ankles: named cross coupling, unknown, and unknown
(clean) before; one stand ended in an internal error, of the other an error of 6 Nm in stances left
out mattered, which is that of a calibration that eleven stances do not know."""


@pytest.mark.parametrize(("name", "number"), ANKLES)
def test_a_walk_on_ankles_is_read_like_one_on_cells(name: str, number: int, tmp_path: Path) -> None:
    trial = TRIALS[name]
    record = diagnosed(trial, seed_of("development", name, number), tmp_path)
    assert answer(trial, record) == "right", record.get("sentence")


ALIKE = (("ankles gain", 717), pytest.param("stand curve", 717, marks=pytest.mark.slow))
"""Certainly named a curve and the mass before: look-alikes lost next to nothing, or were stopped by
a bound."""


@pytest.mark.parametrize(("name", "number"), ALIKE)
def test_what_loses_next_to_nothing_stays_in_the_set(
    name: str, number: int, tmp_path: Path
) -> None:
    record = diagnosed(TRIALS[name], seed_of("development", name, number), tmp_path)
    assert answer(TRIALS[name], record) in ("right", "set"), record.get("sentence")


def test_a_transducer_whose_zero_drifts_is_warned_of_and_in_the_set(tmp_path: Path) -> None:
    """It shows in the swings alone: a tracked calibration follows it, and *none* was the answer."""
    record = diagnosed(
        TRIALS["ankles drift"], seed_of("development", "ankles drift", 812), tmp_path
    )
    assert answer(TRIALS["ankles drift"], record) == "set", record.get("sentence")
    (cause,) = record["causes"]
    assert cause["ci95"][0] > 0.0
    moved = [f["where"] for f in record["findings"] if f["code"] == "zero_moves"]
    assert {"left.fx", "left.fz"} <= set(moved)


STANDS = (("stand crosstalk", 421), ("stand clean", 431))
"""One was certainly named mass and cell position before, the clean one cell position."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number"), STANDS)
def test_no_cause_of_a_stand_is_surely_named_that_is_not_there(
    name: str, number: int, tmp_path: Path
) -> None:
    record = diagnosed(TRIALS[name], seed_of("development", name, number), tmp_path)
    assert answer(TRIALS[name], record) in ("right", "set", "unknown"), record.get("sentence")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number"), SEEN)
def test_a_hidden_cause_is_named_and_a_clean_log_left_alone(
    name: str, number: int, tmp_path: Path
) -> None:
    trial = TRIALS[name]
    record = diagnosed(trial, seed_of("development", name, number), tmp_path)
    assert answer(trial, record) == "right", record.get("sentence")


def test_a_refusal_that_names_the_plugs_answers_wrong_wiring_alone() -> None:
    refused = {"verdict": "refused", "said": "ml sits elsewhere. Remedy: check which plug"}
    assert answer(TRIALS["pose plugs"], refused) == "right"
    assert answer(TRIALS["pose plugs"], {**refused, "said": "the log is empty"}) == "error"
    assert answer(TRIALS["pose clean"], refused) == "error"


def test_a_set_counts_its_classes_and_whether_it_holds_the_cause() -> None:
    """Of a knee two curves are one class, a late stream and a lag another; a wrong set is none."""
    rivals = [["hinge", "dead_zone", "delay", "lag"]]
    said = {"verdict": "ambiguous", "rivals": rivals, "causes": [], "effects": []}
    assert named_sets(TRIALS["walk curve"], said) == [(True, 2)]
    assert named_sets(TRIALS["walk crosstalk"], said) == [(False, 2)]
    assert named_sets(TRIALS["walk clean"], said) == []
    told = [answer(TRIALS[f"walk {name}"], said) for name in ("curve", "crosstalk", "clean")]
    assert told == ["set", "wrong set", "wrong set"]
    assert named_sets(TRIALS["walk curve"], {**said, "verdict": "unknown"}) == []


def test_the_fleet_hides_each_cause_in_robots_of_every_make() -> None:
    """Three, four and six cells; of each number every cause is in the mix once."""
    fleet = fleet_trials()
    kinds = {(trial.experiment, trial.cause) for trial in fleet.values()}
    for number in range(2):
        mix = [trial for name, trial in fleet.items() if mixed(name, number)]
        assert {(t.experiment, t.cause) for t in mix} == kinds
        assert len(mix) == len(kinds)


@pytest.mark.parametrize(("make", "under"), [(7202, 3), (7204, 4), (7005, 6)])
def test_the_cells_under_a_foot_carry_a_weight_where_it_lies(make: int, under: int) -> None:
    """Sum and moments of what the cells feel are those of the weight, within pins and noise."""
    robot, recorded = draw_biped(make), placements(make, rounds=1)
    table = recorded.logs["placements"].query("foot == 'left'")
    assert len(robot.cells) == under
    counts = table[[f"{cell}_counts" for cell in robot.cells]].to_numpy()
    force = (counts - robot.zero[:under]) * robot.scale[:under]
    load = table["load_n"].to_numpy()
    np.testing.assert_allclose(force.sum(axis=1), load, atol=0.02 * load.max())
    where = force @ robot.cells_m / load[:, None]
    apart = where - table[["hole_x_m", "hole_y_m"]].to_numpy()
    assert np.abs(apart).max() < 0.05 * np.ptp(robot.cells_m)


def test_what_a_make_truly_has_is_neither_wrong_nor_the_hidden_cause() -> None:
    clean, late = TRIALS["fleet walk 7010 clean"], TRIALS["fleet walk 7010 late"]
    said = {"verdict": "named", "rivals": [], "causes": [{"effect": "mass"}], "effects": []}
    assert [answer(trial, said) for trial in (clean, late)] == ["right", "none"]
    assert answer(TRIALS["fleet walk 7001 clean"], said) == "WRONG"
