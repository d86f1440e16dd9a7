"""Chains: the order of the table, owners, chunks, and the way back."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, Link, Seen, chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Scope, columns_of, units_of
from footcal_cli.core.log import Log
from footcal_cli.core.simulation.gait import WalkPlan
from tests.contract.logs import CELLS, cell_log, difference, six_axis_log
from tests.core.test_simulation import walk_logs

NAMES = ("scale_bias", "delay", "hysteresis", "mass", "creep", "hanging_plate", "crosstalk")
VALUES = {
    **{f"{c}.scale": -3.4e-5 for c in CELLS},
    **{f"{c}.bias": 283.0 + i for i, c in enumerate(CELLS)},
    "left_rr.hysteresis_width": 0.6,
    "right_fl.creep": 0.05,
    "right_fl.creep_time": 4.0,
    "left_fl.crosstalk": 0.03,
    "left.plate_weight": 1.5,
    "robot.delay": 0.02,
    "robot.mass_correction": 0.2,
}


def whole_chain() -> Chain:
    return chain_of([link(TABLE[name], CELLS) for name in NAMES])


def test_links_stand_in_the_order_of_the_table_however_they_were_named() -> None:
    expected = [name for name in TABLE if name in NAMES]
    assert [item.effect.name for item in whole_chain().links] == expected
    chain = Chain(())
    for name in reversed(NAMES):
        chain = chain.with_link(link(TABLE[name], CELLS))
    assert [item.effect.name for item in chain.links] == expected
    with pytest.raises(ValueError, match="out of order"):
        Chain((link(TABLE["delay"], CELLS), link(TABLE["mass"], CELLS)))


def test_a_chain_is_undone_from_its_last_link_to_its_first() -> None:
    chain = whole_chain()
    truth = cell_log()
    shown, _ = chain.apply(truth, VALUES)
    assert difference(truth, shown) > 0.1
    restored, _ = chain.remove(shown, VALUES)
    # What the delay interpolates (the body's stream) is as exact as its tolerance.
    np.testing.assert_allclose(restored.readings, truth.readings, atol=1e-8)
    assert difference(truth, restored) < TABLE["delay"].tolerance


def test_a_chain_goes_chunk_by_chunk() -> None:
    chain = chain_of([link(TABLE[name], CELLS) for name in NAMES if name != "delay"])
    truth = cell_log()
    whole, _ = chain.apply(truth, VALUES)
    state = None
    parts = []
    for start in range(0, len(truth), 171):
        part, state = chain.apply(truth.rows(start, min(start + 171, len(truth))), VALUES, state)
        parts.append(part.readings)
    np.testing.assert_allclose(np.concatenate(parts), whole.readings, rtol=1e-12)


def test_an_owner_shares_its_value_with_all_its_members() -> None:
    shared = Link(TABLE["hinge"], {"left": tuple(c for c in CELLS if c.startswith("left"))})
    chain = Chain((shared,))
    assert set(shared.names()) == {"left.hinge", "left.hinge_load"}
    truth = cell_log()
    shown, _ = chain.apply(truth, {"left.hinge": 0.2, "left.hinge_load": 4.0})
    changed = np.abs(shown.readings - truth.readings).max(axis=0) > 0
    np.testing.assert_array_equal(changed, [c.startswith("left") for c in CELLS])


def test_parameters_start_neutral_and_shapes_are_not_free() -> None:
    parameters = chain_of([link(TABLE["hysteresis"], CELLS, ["left_fl"])]).parameters()
    assert parameters.names == ("left_fl.hysteresis_width", "left_fl.hysteresis_reach")
    np.testing.assert_array_equal(parameters.free, [True, False])
    assert parameters["left_fl.hysteresis_width"].value == 0.0
    truth = cell_log()
    untouched, state = whole_chain().apply(truth, {})
    assert untouched is truth
    assert state == {}


def test_an_owner_that_is_not_there_is_refused() -> None:
    with pytest.raises(KeyError, match="no channel named middle_fl"):
        link(TABLE["creep"], CELLS, ["middle_fl"])


def test_units_and_their_columns() -> None:
    assert units_of(Scope.FOOT, CELLS) == ("left", "right")
    assert [list(c) for c in columns_of(Scope.FOOT, CELLS)] == [[0, 1, 2, 3], [4, 5, 6, 7]]
    axes = six_axis_log().channels
    assert units_of(Scope.LEG, axes) == ("fl", "ml")
    assert [list(c) for c in columns_of(Scope.LEG, axes)] == [list(range(6)), list(range(6, 12))]
    assert units_of(Scope.ROBOT, axes) == ("robot",)


def test_six_axis_effects_leave_cells_alone_and_cell_effects_of_feet_leave_axes_alone() -> None:
    for name, log in (("mount_rotation", cell_log()), ("load_bypass", six_axis_log("walk"))):
        effect = TABLE[name]
        units = len(units_of(effect.scope, log.channels))
        theta = {p.name: np.full(units, p.neutral + 0.1) for p in effect.parameters}
        assert difference(log, effect.apply(log, theta, None)[0]) == 0.0


def test_the_whole_chain_on_a_simulated_walk_leaves_only_noise() -> None:
    logs = walk_logs(WalkPlan(duration_s=8.0))
    restored: Log = logs.cells.chain.remove(logs.cells.log, logs.cells.values)[0]
    error = restored.readings - logs.cells.truth.readings
    assert 0.02 < error.std() < 0.08


@pytest.mark.parametrize("names", [NAMES, ("scale_bias", "crosstalk"), ("scale_bias",)])
def test_what_was_removed_before_need_not_be_removed_again(names: tuple[str, ...]) -> None:
    """One value at a time moves and comes back, as in finite differences."""
    chain = chain_of([link(TABLE[name], CELLS) for name in names])
    log, _ = chain.apply(cell_log(), VALUES)
    seen = Seen()
    for moved in ("robot.delay", "left_rr.scale", "left_rr.hysteresis_width", "left_fl.crosstalk"):
        for factor in (1.0, 1.1, 1.0, 0.9):
            values = {**VALUES, moved: factor * VALUES[moved]}
            expected, truth = chain.remove(log, values)[0], chain.truth(log, values, seen)
            assert difference(truth, expected) < 1e-12
            total = seen.made_of(truth, lambda given: float(given.readings.sum()))
            assert total == pytest.approx(float(expected.readings.sum()), rel=1e-12)


def test_what_is_made_of_a_truth_that_stays_is_made_once() -> None:
    chain = chain_of([link(TABLE["scale_bias"], CELLS)])
    log, _ = chain.apply(cell_log(), VALUES)
    seen = Seen()
    made: list[Log] = []
    for factor in (1.0, 1.0, 1.0, 1.2):
        truth = chain.truth(log, {**VALUES, "left_rr.scale": factor * -3.4e-5}, seen)
        seen.made_of(truth, made.append)
    assert len(made) == 3


def test_what_follows_from_the_known_is_made_once_for_all_readings() -> None:
    log, asked = cell_log(), []

    def mass(given: Log) -> float:
        asked.append(given)
        return float(given.known["mass_kg"][0])

    other = log.with_readings(log.readings + 1.0)
    assert log.of_known(mass) == other.of_known(mass)
    assert len(asked) == 1
    heavier = other.with_known(mass_kg=2.0 * log.known["mass_kg"])
    assert heavier.of_known(mass) == 2.0 * log.of_known(mass)
    with pytest.raises(ValueError, match="readings have shape"):
        log.with_readings(log.readings[1:])


def test_what_follows_from_the_known_stays_where_what_it_read_stays() -> None:
    log, asked = cell_log(), []

    def mass(given: Log) -> float:
        asked.append("friction" in given.known)
        return float(given.known["mass_kg"][0])

    def twice(given: Log) -> float:
        return 2.0 * given.of_known(mass)

    assert log.of_known(twice) == 2.0 * log.known["mass_kg"][0]
    moved = log.with_known(com_m=log.known["com_m"] + 1.0)
    assert moved.of_known(twice) == log.of_known(twice)
    assert len(asked) == 1
    # what one function read through another counts, and so does what was looked for in vain
    heavier = moved.with_known(mass_kg=3.0 * log.known["mass_kg"])
    assert heavier.of_known(twice) == 3.0 * log.of_known(twice)
    assert log.with_known(friction=log.known["mass_kg"]).of_known(mass) == log.of_known(mass)
    assert asked[-2:] == [True, False]


def test_what_follows_from_the_stamps_serves_any_channels_of_the_same_rows() -> None:
    log, asked = cell_log(), []

    def span(given: Log) -> float:
        asked.append(given)
        return float(np.ptp(given.time_s))

    some = log.of_channels(np.array([2, 5]))
    assert some.channels == (CELLS[2], CELLS[5])
    np.testing.assert_array_equal(some.readings, log.readings[:, [2, 5]])
    assert some.of_time(span) == log.with_known(mass_kg=log.known["mass_kg"]).of_time(span)
    assert len(asked) == 1
    assert log.rows(0, 10).of_time(span) < log.of_time(span)
