"""Names of feet in other tongues and cases, dead cells, temperatures, and tables noted by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.recipe_text import next_step, recipe_text
from footcal_cli.sniff.several import parts_of

LADDER = [0, 10, 20, 40, 60, 80, 60, 40, 20, 10] * 7


def guess(path: Path, names: str, *columns: object) -> FileGuess:
    """What a CSV of these columns is taken for."""
    rows = [",".join(map(str, row)) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([names, *rows]) + "\n", encoding="utf-8")
    return guess_file(path)


@pytest.mark.parametrize(
    ("name", "unit"),
    [("T_F", "degF"), ("T [°F]", "°F"), ("temp_F", "degF"), ("T_C", "degC"), ("T [degC]", "degC")],
)
def test_a_degree_makes_a_temperature_and_says_its_unit(name: str, unit: str) -> None:
    found = name_guess(name)
    assert found.quantity == "temperature"
    assert found.unit == unit


@pytest.mark.parametrize(
    ("name", "unit"), [("sec", "s"), ("Sekunden", "s"), ("t_sec", "s"), ("ms", "ms")]
)
def test_the_name_of_a_unit_of_time_is_time(name: str, unit: str) -> None:
    found = name_guess(name)
    assert found.quantity == "time"
    assert found.unit == unit
    assert name_guess("T").quantity == "time"
    assert name_guess("t_k").quantity == "time"


def test_one_cell_noted_weight_by_weight_keeps_its_days(tmp_path: Path) -> None:
    """70 rows 15 s apart are no recording; a load cell read at 10 Hz is one, and keeps them too."""
    days = np.repeat(["day 1", "day 2"], 35)
    counts = [1000 * load + 7 * i % 13 for i, load in enumerate(LADDER)]
    typed = guess(tmp_path / "a.csv", "day,time_s,load_n,counts", days, np.arange(70) * 15.0,
                  LADDER, counts)  # fmt: skip
    plan = plan_of(typed)
    assert plan is not None
    assert plan.role == "weights"
    assert {"session", "time_s", "channel"} <= set(plan.entries)
    held = np.repeat(LADDER[:10], 30)
    log = guess(tmp_path / "b.csv", "day,time_s,load_n,counts", np.repeat(["a", "b"], 150),
                np.arange(300) / 10, held, 1000 * held + np.arange(300) % 7)  # fmt: skip
    plan = plan_of(log)
    assert plan is not None
    assert plan.role == "weights_stream"
    assert "session" in plan.entries


def test_whole_steps_from_weight_to_weight_are_seconds(tmp_path: Path) -> None:
    """12 between weights that were put on by hand are no milliseconds, in however many rows."""
    cells = np.repeat(["fl", "fr"], 70)
    log = guess(tmp_path / "a.csv", "t,cell,load_n,raw", 12 * np.tile(np.arange(70), 2), cells,
                LADDER * 2, [1000 * load + 5 for load in LADDER * 2])  # fmt: skip
    (time,) = log.of("time")
    assert time.unit == "s"


def walk(tmp_path: Path, cells: list[str], feet: list[str]) -> list[str]:
    """Canonical columns of a log of cells and a log of the body with these feet."""
    rng = np.random.default_rng(3)
    at = np.arange(80) / 50
    one = guess(tmp_path / "cells.csv", ",".join(["time_s", *cells]), at,
                *rng.integers(0, 10**6, (len(cells), 80)))  # fmt: skip
    names = ["time_s", "CoM.x [m]", "CoM.y [m]", "CoM.z [m]"]
    names += [f"{foot}{axis}" for foot in feet for axis in ("x [mm]", "y [mm]", "z [mm]")]
    two = guess(tmp_path / "body.csv", ",".join(names), at,
                *rng.normal(0, 1, (len(names) - 1, 80)).round(4))  # fmt: skip
    parts, others = parts_of([one, two])
    assert not others
    return [name for part in parts for name in part.plan.entries]


@pytest.mark.parametrize("feet", [["left.pos.", "right.pos."], ["L.", "R."], ["LF_", "RF_"]])
def test_a_place_beside_a_com_is_that_of_a_foot(tmp_path: Path, feet: list[str]) -> None:
    found = walk(tmp_path, ["links_1_counts", "links_2_counts", "rechts_1_counts",
                            "rechts_2_counts"], feet)  # fmt: skip
    assert {f"{side}_foot_{axis}_m" for side in ("left", "right") for axis in "xyz"} <= set(found)
    assert {"left_1_counts", "left_2_counts", "right_1_counts", "right_2_counts"} <= set(found)


@pytest.mark.parametrize("behind", ["R", "H"])
def test_the_feet_of_a_quadruped_in_capitals(tmp_path: Path, behind: str) -> None:
    legs = ["FL", "FR", f"{behind}L", f"{behind}R"]
    found = walk(tmp_path, legs, [f"{leg}_foot_" for leg in legs])
    assert {f"{leg.lower()}_foot_{axis}_m" for leg in legs for axis in "xyz"} <= set(found)
    assert {f"{leg.lower()}_foot_counts" for leg in legs} <= set(found)


def test_a_cell_that_stands_still_among_others_is_read_and_said(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    counts = rng.integers(0, 10**6, (8, 80))
    counts[5] = 8388607
    names = [f"{side}_{at}_counts" for side in ("left", "right") for at in ("fl", "fr", "rl", "rr")]
    log = guess(tmp_path / "a.csv", ",".join(["time_s", *names]), np.arange(80) / 50, *counts)
    plan = plan_of(log)
    assert plan is not None
    assert len(plan.channels) == 8
    assert any("right_fr_counts: never changes" in said for said in plan.warnings)


def test_weights_come_before_the_stand_that_needs_them(tmp_path: Path) -> None:
    """Whatever the order on the command line: the stand starts from the scales of the weights."""
    rng = np.random.default_rng(5)
    stand = guess(tmp_path / "a_cells.csv", "time_s,c1,c2,c3,c4", np.arange(80) / 40,
                  *rng.integers(0, 10**6, (4, 80)))  # fmt: skip
    names = np.repeat(["c1", "c2", "c3", "c4"], 10)
    weights = guess(tmp_path / "weights.csv", "channel,load_n,counts", names, LADDER[:10] * 4,
                    [1000 * load + 5 for load in LADDER[:10] * 4])  # fmt: skip
    parts, _ = parts_of([stand, weights])
    said = next_step(parts, "--recipe r.toml")
    assert said.startswith("footcal offline-fit --recipe r.toml; after it static-init")
    last = "with the parameters.json written last"
    assert said.endswith(f"; then diagnose (experiment stand), {last}, says what the model lacks")
    text = recipe_text(parts, tmp_path / "r.toml", "--recipe r.toml")
    assert text.endswith('[diagnose]\nexperiment = "stand"    # or weights\n')
