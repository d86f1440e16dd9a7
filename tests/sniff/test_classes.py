"""Classes of strangers' logs: the loaded cell, headings, hung and stood, joined files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.errors import UsageError
from footcal_cli.recipe import Recipe
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.several import parts_of
from tests.strangers.rigs import G, cell
from tests.strangers.thirty_first_robots import numbered_legs_and_hips
from tests.strangers.thirty_first_stands import _stances


@pytest.mark.parametrize("called", ["which", "Welche", "№"])
def test_the_loaded_cell_is_found_whatever_its_column_is_called(
    tmp_path: Path, called: str
) -> None:
    rng = np.random.default_rng(0)
    cells, lines = [cell(rng), cell(rng), cell(rng)], [f"{called};kg;a;b;c"]
    for on in range(3):
        for kg in (0, 1, 2, 5):
            read = [c.read(np.array(kg * G * (i == on)), rng) for i, c in enumerate(cells)]
            said = str(on + 7) if kg == 0 or called == "which" else ""
            lines.append(";".join([said, str(kg), *(f"{v:.0f}" for v in read)]))
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    plan = plan_of(guess_file(tmp_path / "a.csv"))
    assert plan is not None
    assert "one of 3 cells at a time" in plan.kind
    assert list(plan.wide) == ["7", "8", "9"]


@pytest.mark.parametrize(
    "turn_deg", [0.0, -120.0, *(pytest.param(a, marks=pytest.mark.slow) for a in (90.0, 180.0))]
)
def test_the_heading_of_feet_is_found_by_where_they_stand(tmp_path: Path, turn_deg: float) -> None:
    stand = _stances(np.random.default_rng(1))
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    head = [f"{n}_{a}" for n in ("com", "left_foot", "right_foot") for a in "xyz"]
    places = [at @ turn.T for at in (stand.com, stand.feet[:, 0], stand.feet[:, 1])]
    cells = [f"{side}_{p}" for side in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    table = np.hstack([stand.time[:, None], np.round(1e4 * stand.cells), *places])
    lines = [",".join(["t", *cells, *head]), *(",".join(f"{v:.9g}" for v in row) for row in table)]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    plan = plan_of(guess_file(tmp_path / "a.csv"))
    assert plan is not None
    entry = plan.entries.get("left_foot_yaw_rad")
    found = 0.0 if entry is None or entry.value is None else float(entry.value)
    assert np.cos(found - np.radians(turn_deg)) == pytest.approx(1.0, abs=1e-4)


def test_hung_and_stood_under_the_same_names_are_two_logs(tmp_path: Path) -> None:
    made = numbered_legs_and_hips(tmp_path, np.random.default_rng(0))
    parts, others = parts_of([guess_file(path) for path in made.paths])
    assert not others
    assert [part.plan.role for part in parts] == ["hang", "poses"]
    said = [line for table in parts[1].plan.robot for line in table.splitlines()]
    assert sum(line.startswith("position_m = [") for line in said) == 6


def test_a_file_that_is_joined_to_itself_is_refused(tmp_path: Path) -> None:
    for name in ("LF.txt", "imu.txt"):
        (tmp_path / name).write_text("1 2\n")
    files = [{"match": "*.txt", "join": [{"file": "imu.txt", "by": "row"}]}]
    with pytest.raises(UsageError, match="joined to itself"):
        Recipe.model_validate({"files": files}).reading(tmp_path / "LF.txt")
    apart = [{"match": "imu.txt"}, *files]
    assert Recipe.model_validate({"files": apart}).reading(tmp_path / "LF.txt").joins


@pytest.mark.parametrize(
    ("name", "axis"),
    [
        ("linker Fuß Gier [°]", "yaw"),
        ("Nick (deg)", "pitch"),
        ("Wank [°]", "roll"),
        ("Lacet", "yaw"),
    ],
)
def test_angles_bear_their_axis_in_words(name: str, axis: str) -> None:
    assert (name_guess(name).quantity, name_guess(name).axis) == ("angle", axis)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("center of pressure x", "cop"), ("Druckpunkt X", "cop"), ("centro de presión y", "cop"),
        ("centre of mass z", "com"), ("Schwerpunkt X", "com"), ("baricentro y (m)", "com"),
    ],
)  # fmt: skip
def test_centres_of_mass_and_of_pressure_are_kept_apart(name: str, quantity: str) -> None:
    assert name_guess(name).quantity == quantity


@pytest.mark.parametrize("sideways", [False, True])
def test_the_heading_of_feet_that_walk_is_the_way_they_go(tmp_path: Path, sideways: bool) -> None:
    t = np.arange(400) / 50
    ahead = 0.2 * t
    left, right = np.zeros((400, 3)), np.zeros((400, 3))
    left[:, 0], right[:, 0] = -0.1, 0.1  # the left one on the left of a robot that faces y
    for foot in (left, right):
        foot[:, 0 if sideways else 1] += ahead
    com = (left + right) / 2 + [0.0, 0.0, 0.8]
    rng = np.random.default_rng(2)
    cells = [f"{side}_{p}" for side in ("left", "right") for p in ("fl", "fr", "rl", "rr")]
    head = [f"{n}_{a}" for n in ("com", "left_foot", "right_foot") for a in "xyz"]
    table = np.hstack([t[:, None], rng.integers(1000, 9000, (400, 8)), com, left, right])
    lines = [",".join(["t", *cells, *head]), *(",".join(f"{v:.9g}" for v in row) for row in table)]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    plan = plan_of(guess_file(tmp_path / "a.csv"))
    assert plan is not None
    assert ("left_foot_yaw_rad" in plan.entries) is not sideways
