"""Pieces of guessing whose mistakes would pass for a calibration."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.hang.intake import between_holds, held_still
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.sides import orientation_in
from footcal_cli.sniff.tokens import number_signs
from footcal_cli.tables.canonical import unwrapped
from footcal_cli.tables.plates import cells_of
from footcal_cli.tables.rawcolumn import RawColumn
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


WALKS = {
    "beams": (
        [f"{s}_{p}_raw" for s in "lr" for p in ("toe_in", "toe_out", "heel_in", "heel_out")],
        [f"com_{a}_mm" for a in "xyz"], [f"com_acc_{a}" for a in "xyz"], ["Ldot_x", "Ldot_y"],
        [f"{s}foot_{a}" for s in "lr" for a in ("x", "y", "z", "yaw_deg")],
    ),
    "nao": (
        [f"{s}Fsr{p}" for s in "LR" for p in ("FL", "FR", "RL", "RR")],
        [f"CoM.{a}" for a in "xyz"], [f"CoMAcc.{a}" for a in "xyz"], [],
        [f"{s}Foot.{a}" for s in "LR" for a in "xyz"],
    ),
    "ros": (
        [f"/{s}_foot/cell_{i}/data" for s in ("left", "right") for i in range(4)],
        [f"/com/position/{a}" for a in "xyz"],
        [f"/com/{q}/{a}" for q in ("acceleration", "velocity") for a in "xyz"], [],
        [f"/{s}_foot/pose/position/{a}" for s in ("left", "right") for a in "xyz"],
    ),
    "soles": (
        [f"{s}_FSR{i}" for s in ("left", "right") for i in range(1, 5)],
        [f"com_pos_{a}" for a in "xyz"],
        [f"com_{q}_{a}" for q in ("vel", "acceleration") for a in "xyz"],
        ["angular_momentum_rate_x", "angular_momentum_rate_y"],
        [f"{s}_sole_{a}" for s in "lr" for a in "xyz"],
    ),
}  # fmt: skip
"""Readings, CoM, its rates, angular momentum, feet, as four groups call them in one table."""


@pytest.mark.parametrize("names", WALKS.values(), ids=WALKS.keys())
def test_a_walk_on_cells_with_the_body_in_one_table(
    tmp_path: Path, names: tuple[list[str], ...]
) -> None:
    """No column of the motion is a reading; eight cells of two feet remain."""
    rng, log = np.random.default_rng(1), tmp_path / "walk.csv"
    cells, *motion = names
    body = [name for group in motion for name in group]
    table = np.hstack([
        np.arange(200)[:, None] / 100.0, rng.integers(8_000_000, 8_400_000, (200, 8)),
        0.2 + 0.1 * rng.standard_normal((200, len(body))),
    ])  # fmt: skip
    np.savetxt(log, table, "%.10g", ",", header=",".join(["time_s", *cells, *body]), comments="")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.command == "online-replay"
    assert [
        e.column.column for n, e in plan.entries.items() if n.endswith("_counts") and e.column
    ] == cells
    feet = {f"{s}_foot_{a}_m" for s in ("left", "right") for a in "xyz"}
    com = {f"com_{a}_m" for a in "xyz"} | {f"com_acc_{a}_mps2" for a in "xyz"}
    assert feet | com <= set(plan.entries)
    assert len(names[3]) == sum(name.startswith("angmom") for name in plan.entries)
    assert {name.partition("_")[0] for name in plan.channels} == {"left", "right"}


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
