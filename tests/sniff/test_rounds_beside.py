"""Readings of one cell side by side: up and down beside a name, rounds of placements in a row."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.listed_places import places_in
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of
from tests.conftest import Run

CELLS = {"A12": (0.0, 62.0), "A15": (-53.7, -31.0), "A19": (53.7, -31.0)}
LOADS = (0, 1, 2, 5, 8)


def bench(folder: Path, ways: tuple[str, str], label: str = "canale") -> Path:
    """A ladder of each cell three times, up and down beside each other; the top has no way down."""
    rng = np.random.default_rng(5)
    lines = [f"{label},ciclo,massa [kg],{ways[0]} [N],{ways[1]} [N]"]
    for cell in CELLS:
        for cycle in (1, 2, 3):
            for m in LOADS:
                up, down = 9.81 * m + rng.normal(0, 0.02, 2)
                lines.append(f"{cell},{cycle},{m},{up:.2f}," + f"{down:.2f}" * (m < max(LOADS)))
    path = folder / "bench.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def plate(folder: Path, name: str) -> Path:
    """Two weights on 12 holes of a round plate in four rounds side by side."""
    rng, at = np.random.default_rng(6), np.array([*CELLS.values()])
    columns = [name.format(cell=c, round=r) for r in (1, 2, 3, 4) for c in CELLS]
    lines = ["foro,x [mm],y [mm],massa [kg]," + ",".join(f"{c} [N]" for c in columns)]
    for kg in (3.0, 8.0):
        for i in range(12):
            angle, radius = np.radians(30.0 * i), 14.0 if i % 2 else 30.0
            hole = np.round([radius * np.cos(angle), radius * np.sin(angle)], 1)
            share = np.linalg.solve(np.vstack([np.ones(3), at.T]), [1.0, *hole])
            read = np.tile(9.81 * kg * share, 4) + rng.normal(0, 0.05, 12)
            numbers = ",".join(f"{v:.2f}" for v in read)
            lines.append(f"H{i},{hole[0]},{hole[1]},{kg},{numbers}")
    path = folder / "plate.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def by_role(paths: list[Path]) -> dict[str, LogPlan]:
    return {p.plan.role: p.plan for p in parts_of([guess_file(path) for path in paths])[0]}


@pytest.mark.parametrize(
    "ways", [("salita", "discesa"), ("up", "down"), ("Belasten", "Entlasten"), ("opp", "ned")]
)
@pytest.mark.parametrize("name", ["{cell}_r{round}", "{cell} giro {round}", "run{round}_{cell}"])
def test_ways_and_rounds_are_no_cells(tmp_path: Path, ways: tuple[str, str], name: str) -> None:
    found = by_role([bench(tmp_path, ways), plate(tmp_path, name)])
    cells = ("foot_a12", "foot_a15", "foot_a19")
    assert found["weights"].wide_into == "direction"
    assert {*found["weights"].wide} == {"1", "-1"}
    assert found["weights"].channels == found["placements"].channels == cells
    assert found["placements"].wide_into == "repeat"
    assert [*found["placements"].wide] == ["1", "2", "3", "4"]
    assert {*found["placements"].read} == {"a12_counts", "a15_counts", "a19_counts"}


def test_two_feet_of_numbered_cells_are_no_rounds(tmp_path: Path) -> None:
    path = plate(tmp_path, "{cell}_r{round}")
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    swapped = [",".join([*(r := row.split(","))[:4], *r[4:10], *r[14:16], *r[10:14]])
               for row in rows]  # fmt: skip
    path.write_text("\n".join([head, *swapped]) + "\n", encoding="utf-8")
    assert not by_role([path])["placements"].wide


def test_a_column_of_names_beside_readings_that_differ_is_said(tmp_path: Path) -> None:
    rows = [f"{who},{m},{100 * m + k},{70 * m - k}" for k, who in enumerate(("Ada", "Bo"))
            for m in (0, 1, 2, 5, 2, 1, 0)]  # fmt: skip
    path = tmp_path / "b.csv"
    path.write_text("\n".join(["who,mass_kg,adc_p,adc_q", *rows]) + "\n", encoding="utf-8")
    said = by_role([path])["weights"].warnings
    assert any(line.startswith("who (Ada, Bo) is not used") for line in said)


def test_places_behind_their_angles() -> None:
    text = ("Celle da disegno (raggio 62 mm): A12 a 90 gradi (x=0, y=62), A15 a 210 gradi "
            "(x=-53.7, y=-31.0), A19 330° (x=53.7, y=-31.0).")  # fmt: skip
    sheet = places_in(Path("notes.md"), text)
    assert sheet is not None
    assert sheet.columns[0].words == (*CELLS,)


def test_the_printed_command_calibrates_the_plate(tmp_path: Path, run: Run) -> None:
    notes = tmp_path / "notes.md"
    notes.write_text("Celle in mm: " + ", ".join(
        f"{c} a {a} gradi (x={x}, y={y})"
        for (c, (x, y)), a in zip(CELLS.items(), (90, 210, 330), strict=True)
    ) + "\n", encoding="utf-8")  # fmt: skip
    logs = [bench(tmp_path, ("salita", "discesa")), plate(tmp_path, "{cell}_r{round}")]
    recipe = tmp_path / "r.toml"
    assert run("init", *logs, notes, "-o", recipe).exit_code == 0
    assert "TO FILL IN" not in recipe.read_text(encoding="utf-8")
    done = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out", "--quiet")
    assert done.exit_code == 0
    assert "foot_a15" in (tmp_path / "out" / "parameters.json").read_text(encoding="utf-8")
    text = recipe.read_text(encoding="utf-8")
    placed = re.sub(r"\[robot\.feet\.foot\.cells\]\n(?:a1.*\n)+", "", text)
    recipe.write_text(placed, encoding="utf-8")
    said = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "alone")
    assert "these placements are not used" in said.out
