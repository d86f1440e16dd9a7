"""Pieces of guessing whose mistakes would pass for a calibration."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from footcal_cli.core.hang.intake import between_holds, held_still
from footcal_cli.sniff.names import orientation_in
from footcal_cli.sniff.tokens import number_signs
from footcal_cli.tables.canonical import unwrapped
from footcal_cli.tables.logfiles import RawColumn
from footcal_cli.tables.plates import cells_of
from footcal_cli.tables.sources import at_rows


@pytest.mark.parametrize(
    ("texts", "separator", "signs"),
    [
        (["0,5", "8.388.607"], ";", (",", ".")),
        (["1,000", "8,388,607"], ",", (".", ",")),
        (["0,500", "1,000"], ";", (",", "")),
        (["1.000", "2.000"], ",", (".", "")),
        (["1,234.5", "12.5"], ";", (".", ",")),
        (["0,5 kg", "8388607"], ";", (",", "")),
        (["8 388 607", "0,5"], ";", (",", " ")),
    ],
)
def test_signs_of_numbers(texts: list[str], separator: str, signs: tuple[str, str]) -> None:
    assert number_signs(texts, separator) == signs


@pytest.mark.parametrize(
    ("name", "axis"),
    [
        ("hang_plus_x.csv", "+x"), ("minus_z", "-z"), ("x_up", "-x"), ("ft_y_down", "+y"),
        ("-X down", "-x"), ("-z up", "+z"),
        ("+x", "+x"), ("z-", "-z"), ("neg y", "-y"), ("xylophone", None), ("run_3", None),
    ],
)  # fmt: skip
def test_orientations_in_names(name: str, axis: str | None) -> None:
    assert orientation_in(name) == axis


def test_noise_of_an_attitude_is_averaged_and_a_turn_is_kept() -> None:
    rng = np.random.default_rng(5)
    holds = np.repeat(np.array([[0, 0, -1.0], [0.6, 0, -0.8], [0, 1, 0]]), 200, axis=0)
    found = held_still(9.81 * (holds + rng.normal(0, 1e-3, holds.shape)))
    assert np.unique(found, axis=0).shape[0] <= 6
    assert np.abs(found - holds).max() < 4e-3
    angle = np.linspace(0, np.pi, 1000)
    turning = np.column_stack([np.sin(angle), 0 * angle, -np.cos(angle)])
    assert np.arccos(np.clip((held_still(turning) * turning).sum(axis=1), -1, 1)).max() < 0.011


def test_a_counter_that_wraps_goes_on_counting_and_a_reset_does_not_pass_for_one() -> None:
    counted = (4_294_960_000 + 2500 * np.arange(9)) % 2**32
    assert np.array_equal(np.diff(unwrapped(counted, 2.0**32)), np.full(8, 2500))
    small = np.array([65_500, 65_530, 24, 54])
    assert np.array_equal(unwrapped(small, 2.0**16), [65_500, 65_530, 65_560, 65_590])


def test_topics_that_take_turns_are_brought_to_the_times_of_one() -> None:
    stamps = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    nan = np.nan
    force, angle = np.array([1.0, nan, 2.0, nan, 3.0]), np.array([nan, 10.0, nan, 30.0, nan])
    raw = {n: RawColumn("number", v, np.isnan(v)) for n, v in (("f", force), ("a", angle))}
    found = at_rows(raw, ~np.isnan(force), stamps, 0.15)
    assert np.array_equal(found["f"].values, [1.0, 2.0, 3.0])
    assert np.allclose(found["a"].values, [10.0, 20.0, 30.0])
    assert np.isnan(at_rows(raw, ~np.isnan(force), stamps, 0.05)["a"].values).all()


def test_rows_between_holds_are_found_and_an_attitude_that_always_turns_has_none() -> None:
    axes = np.vstack([np.eye(3), -np.eye(3)])
    path = [np.repeat(axes, 50, axis=0)]
    for a, b in pairwise(axes):
        path.append(np.linspace(a, b, 12)[1:-1] + 1e-9)
    direction = np.concatenate(path)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    found = between_holds(held_still(direction))
    assert not found[:300].any()
    assert found[300:].mean() > 0.9
    angle = np.linspace(0, 6, 400)
    turning = np.column_stack([np.sin(angle), np.cos(angle), 0.5 * np.sin(2 * angle)])
    assert not between_holds(held_still(turning)).any()


def test_three_cells_are_as_much_as_force_and_cop_and_a_lifted_foot_is_spread_evenly() -> None:
    places = np.array([[-0.1, -0.05], [-0.1, 0.05], [0.15, 0.0]])
    force = np.array([300.0, 500.0, 2.0])
    cop = np.array([[0.02, 0.01], [-0.3, 0.2], [np.nan, np.nan]])
    cells = cells_of(force, cop, places)
    assert np.allclose(cells.sum(axis=1), force)
    assert np.allclose((cells @ places)[:2], force[:2, None] * cop[:2])
    assert np.allclose(cells[2], 2.0 / 3.0)
