"""Stands whose feet are two words of a language, with a number of the stance and zeros beside."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.cells import WHERE
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.recipe_text import recipe_text
from footcal_cli.sniff.said_above import as_said_above
from footcal_cli.sniff.several import parts_of

CORNERS = ("on_dis", "on_ic", "arka_dis", "arka_ic")
ORDER = (3, 1, 2, 5)


def logs(folder: Path, feet: tuple[str, str], sole: str, stance: str) -> list[Path]:
    """Counts of four stances, means of a robot in the air, and a bench of the same cells."""
    rng = np.random.default_rng(3)
    cells = [f"{foot}_{corner}" for foot in feet for corner in CORNERS]
    poses = [f"{f}_{sole}_{n}" for f in feet for n in ("x_mm", "y_mm", "yaw_deg")]
    lines = [",".join(["t_s", stance, *cells, "com_x_mm", "com_y_mm", *poses])]
    for i, number in enumerate(ORDER):
        load, step = rng.uniform(1000, 4000, 8), rng.uniform(-5, 5)
        for k in range(60):
            read = (load + rng.normal(0, 20, 8)).round().astype(int)
            at = [rng.normal(3, 0.1), rng.normal(2, 0.1), step, 100, 0.5, -step, -100, -0.5]
            time = 10.0 * i + 0.02 * k
            lines.append(",".join([f"{time:.3f}", f"{number}", *map(str, read),
                                   *(f"{v:.2f}" for v in at)]))  # fmt: skip
    texts = {"stand.csv": lines}
    texts["air.csv"] = [",".join(["when", *cells])] + [
        f"{when}," + ",".join(str(v) for v in rng.integers(-900, 900, 8)) for when in "ab"
    ]
    texts["bench.csv"] = ["cell,run,mass_kg,adc"] + [
        f"{c},{run},{m},{8 + 312 * m}" for c in cells for run in (1, 2) for m in (0, 2, 5, 10, 0)
    ]
    for name, rows in texts.items():
        (folder / name).write_text("\n".join(rows) + "\n", encoding="utf-8")
    return [folder / name for name in texts]


def plans(folder: Path, *said: str) -> dict[str, LogPlan]:
    parts, left = parts_of([guess_file(path) for path in said_paths(folder, *said)])
    assert not left
    return {part.plan.role: part.plan for part in parts}


def said_paths(folder: Path, *said: str) -> list[Path]:
    first, second, sole, stance = said
    return logs(folder, (first, second), sole, stance)


@pytest.mark.parametrize(
    "said",
    [("sol", "sag", "taban", "durus"), ("sx", "dx", "suola", "posa"),
     ("bal", "jobb", "talp", "allas")],
)  # fmt: skip
def test_two_words_that_split_all_cells_and_poses_are_the_feet(
    tmp_path: Path, said: tuple[str, ...]
) -> None:
    found = plans(tmp_path, *said)
    cells = tuple(f"{foot}_{corner}" for foot in ("left", "right") for corner in CORNERS)
    assert {*found["cells"].channels} == {*found["weights"].channels} == {*cells}
    assert {*found["zeros"].entries} == {f"{cell}_counts" for cell in cells}
    entries = found["cells"].entries
    for foot, word in (("left", said[0]), ("right", said[1])):
        place, yaw = entries[f"{foot}_foot_x_m"], entries[f"{foot}_foot_yaw_rad"]
        assert place.column is not None
        assert yaw.column is not None
        assert place.column.column == f"{word}_{said[2]}_x_mm"
        assert place.unit == "mm"
        assert yaw.column.column == f"{word}_{said[2]}_yaw_deg"
        assert entries[f"{foot}_foot_z_m"].value == "0.0"


def test_one_of_the_words_alone_is_no_foot(tmp_path: Path) -> None:
    path = tmp_path / "soil.csv"
    rows = [f"{0.1 * i:.1f},{100 + i % 7},{200 + i % 5}" for i in range(40)]
    path.write_text("\n".join(["t_s,sol_a,sol_b", *rows]) + "\n", encoding="utf-8")
    assert {c.name.side for c in guess_file(path).columns} == {""}


def test_places_are_asked_for_once(tmp_path: Path) -> None:
    parts, _ = parts_of([guess_file(p) for p in logs(tmp_path, ("sol", "sag"), "taban", "durus")])
    stand = next(part for part in parts if part.plan.role == "cells")
    asked = next(blank for blank in stand.plan.blanks if blank.why == WHERE)
    more = replace(asked, lines=(asked.lines[0], "# more = {}"))
    text = recipe_text(
        [stand, replace(stand, plan=replace(stand.plan, blanks=(more,)))], tmp_path / "r.toml", ""
    )
    assert text.count("[robot.feet.left.cells]") == 1
    assert "# more = {}" in text


@pytest.mark.parametrize(
    "line",
    ["Robot hung on the crane scale that morning: 41.3 kg with battery and feet.",
     "robot: 41.3 kg (incl. both legs)", "Roboter: 41,3 kg mit Fuß",
     "peso del robot 41,3 kg con piede"],
)  # fmt: skip
def test_a_mass_with_all_that_was_weighed(tmp_path: Path, line: str) -> None:
    stand = plans(tmp_path, "sol", "sag", "taban", "durus")["cells"]
    file = replace(stand.file, text=replace(stand.file.text, above=(line,)))
    assert any(x.startswith("mass_kg = 41.3 ") for x in as_said_above(
        replace(stand, file=file)).robot)  # fmt: skip
