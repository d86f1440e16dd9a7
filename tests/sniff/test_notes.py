"""What notes among the logs say: masses, rates, weights on holes, places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.geometry import _places
from footcal_cli.sniff.guesses import FileGuess, numbers_of
from footcal_cli.sniff.listed_places import grid_in, places_in
from footcal_cli.sniff.notes import notes_among, units_in, with_notes
from footcal_cli.sniff.plan import rate_said
from footcal_cli.sniff.said_above import _masses
from footcal_cli.sniff.text import TextGuess
from footcal_cli.tables.reading import Layout
from tests.conftest import Run


@pytest.mark.parametrize(
    "lines",
    [
        ["Places in mm:", "- FL: 60, 35", "- FR: 60, -35", "- RL: -60, 35"],
        ["| cell | x [mm] | y [mm] |", "|---|---|---|", "| FL | 60 | 35 |", "| FR | 60 | -35 |",
         "| RL | -60 | 35 |"],
        ["Cells (mm): FL (60, 35), FR (60, -35), RL (-60, 35)"],
        ["Zellen in cm", "* FL: 6; 3,5", "* FR: 6; -3,5", "* RL: -6; 3,5"],
        ["| celle | x | y |", "|---|---|---|", "| FL (venstre for) | 60 | 35 |",
         "| FR (højre for) | 60 | -35 |", "| bag til venstre (RL) | -60 | 35 |", "i mm"],
        ["| cell | where | x, mm | y |", "|--|--|--|--|", "| FL | front left | 60 | 35 |",
         "| FR | front right | 60 | -35 |", "| RL | rear left | -60 | 35 |"],
        ["Positions (mm)", "| | place | (x, y) |", "|--|--|--|", "| FL | front | 60, 35 |",
         "| FR | front | 60, -35 |", "| RL | rear | -60, 35 |"],
        ["FL: x = 60 mm, y = 35 mm", "FR: x = 60 mm, y = -35 mm", "RL: x = -60 mm, y = 35 mm"],
    ],
)  # fmt: skip
def test_places_that_notes_list(lines: list[str]) -> None:
    sheet = places_in(Path("notes.md"), "\n".join(["# Robot", "", *lines]))
    assert sheet is not None
    name, x, y = sheet.columns
    assert name.words == ("FL", "FR", "RL")
    metres = {"mm": 1e-3, "cm": 1e-2}[x.unit or ""]
    assert np.allclose(metres * numbers_of(x), [0.06, 0.06, -0.06])
    assert np.allclose(metres * numbers_of(y), [0.035, -0.035, 0.035])


@pytest.mark.parametrize("text", [
    "Places (m)\n| i | place | left (x, y) | right (x, y) |\n|---|---|---|---|\n"
    "| 0 | toe | 0.08, 0.02 | 0.08, -0.03 |\n| 1 | heel | -0.06, 0.02 | -0.06, -0.03 |\n",
    "In m. Left foot: 0 (0.08, 0.02), 1 (-0.06, 0.02); right foot: 0 (0.08, -0.03), "
    "1 (-0.06, -0.03)",
    "Cells in m\n| foot | i | x | y |\n|---|---|---|---|\n| L | 0 | 0.08 | 0.02 |\n"
    "| L | 1 | -0.06 | 0.02 |\n| R | 0 | 0.08 | -0.03 |\n| R | 1 | -0.06 | -0.03 |\n",
    "Linker Fuß, m\n| 0 | 0.08 | 0.02 |\n| 1 | -0.06 | 0.02 |\n\nRechter Fuß\n"
    "| 0 | 0.08 | -0.03 |\n| 1 | -0.06 | -0.03 |\n",
])  # fmt: skip
def test_places_of_both_feet_under_the_same_numbers(text: str) -> None:
    sheet = places_in(Path("notes.md"), text)
    assert sheet is not None
    name, x, y = sheet.columns
    assert x.unit == "m"
    found = {n: p for n, *p in zip(name.words, numbers_of(x), numbers_of(y), strict=True)}
    assert found == {"left 0": [0.08, 0.02], "left 1": [-0.06, 0.02],
                     "right 0": [0.08, -0.03], "right 1": [-0.06, -0.03]}  # fmt: skip


@pytest.mark.parametrize(("text", "name"), [
    ("rækkerne 1..3 ved x = -80, 0, 40; bogstav A: y = 35, B: y = -35 (mm), A1 er bagest", "B3"),
    ("Reihen 1-3: x = -80; 0; 40 mm, Spalten A bis B: y = 35; -35", "B3"),
    ("Rows A..C at x = -80,0,40 mm; columns 1 to 2 at y = 35, -35", "C2"),
    ("Rows 1 to 3 at x = -80, 0, 40 mm, A: y = 35, B: y = -35; hole 1A is at the heel", "3B"),
])  # fmt: skip
def test_holes_of_a_grid_that_notes_describe(text: str, name: str) -> None:
    sheet = grid_in(Path("notes.md"), text)
    assert sheet is not None
    names, x, y = sheet.columns
    at = names.words.index(name)
    assert (len(names.words), x.unit) == (6, "mm")
    assert (numbers_of(x)[at], numbers_of(y)[at]) == (40.0, -35.0)


@pytest.mark.parametrize("text", [
    "Tests 1..3 at x = 4, 5 mm", "A: y = 35, B: y = -35", "run 1-3, y = 2",
    "1..2 at x = 0, 4; x: y = 3",
])  # fmt: skip
def test_other_sentences_describe_no_grid(text: str) -> None:
    assert grid_in(Path("notes.md"), text) is None


@pytest.mark.parametrize(
    "text",
    [
        "10:32: 60, 35",
        "Loads: 0, 1, 2, 5 kg",
        "run 1: 3, 4\nrun 2: 5, 6",
        "| cell | kg |\n|--|--|\n| A | 12,004 |\n| B | 24,011 |\n| C | 24,5 |",
        "| cell | loads |\n|--|--|\n| A | 0, 2 |\n| B | 0, 5 |\n| C | 2, 5 |",
    ],
)
def test_other_numbers_are_no_places(text: str) -> None:
    assert places_in(Path("notes.md"), text) is None


@pytest.mark.parametrize(
    ("line", "mass_kg"),
    [
        ("Robottens masse er 5,2 kg.", 5.2), ("Der Roboter wiegt 5,2 kg", 5.2),
        ("Biped, 5.2 kg with battery.", 5.2), ("体重: 61.5 kg", 61.5), ("Masa robota: 5,2 kg", 5.2),
        ("Total mass with battery 5.2 kg.", 5.2), ("Robot: 5200 g", 5.2),
        ("Each foot has a mass of 0.3 kg", None), ("peso campione di 2,5 kg", None),
        ("Kalibriergewicht 2 kg", None),
        ("Massa total (balança do laboratório): 14,64 kg.", 14.64),
        ("Robot mass 5.2 kg (bilancia), feet included.", 5.2),
        ("robot 5,2 kg; incl. tool and sensors", 5.2), ("Robot 5.2 kg, without feet", None),
        ("The robot holds a 5.2 kg tool", None), ("Robot 5.2 kg, each foot 0.3 kg", 5.2),
        ("Robot with battery and feet: 5.2 kg on the scale.", 5.2),
        ("Mass of the robot 5.2 kg (without the 0.3 kg of the soles it would be 4.9)", 5.2),
    ],
)  # fmt: skip
def test_the_mass_of_a_robot_in_words(line: str, mass_kg: float | None) -> None:
    assert [*_masses([line])] == ([] if mass_kg is None else [mass_kg])


@pytest.mark.parametrize(
    ("line", "rate_hz"),
    [
        ("taxa de amostragem 100 Hz", 100.0), ("Fréquence;100 Hz", 100.0),
        ("sampled at 80 Hz", 80.0), ("low-pass at a frequency of 10 Hz", None),
    ],
)  # fmt: skip
def test_a_rate_in_words(line: str, rate_hz: float | None) -> None:
    file = FileGuess(Path("a.csv"), TextGuess(Layout(), above=(line,)), (), 0)
    assert rate_said(file) == rate_hz


def test_units_of_vectors_in_notes() -> None:
    assert units_in("F em N, M em N.mm; pcom em m") == {"force": "N", "torque": "N*mm"}
    behind = "`L_Fx.._Fz`, `R_Fx.._Fz` lbf; `L_Tx.._Tz` in-lbf about the centre"
    assert units_in(behind) == {"force": "lbf", "torque": "lbf*in"}


def test_a_table_of_places_below_prose_is_no_log(tmp_path: Path) -> None:
    log, notes = tmp_path / "walk.csv", tmp_path / "notes.md"
    log.write_text("t,LF1_V\n0,0.1\n1,0.2\n")
    rows = (f"| LF{i} | {i}.90 | 1.55 |" for i in (1, 2, 3))
    head = [
        "Robot weight incl. batteries 135.0 lb (scale).",
        "They are 1.00 in above the floor.",
    ]
    notes.write_text("\n".join([*head, "", "| cell | x | y |", "|---|---|---|", *rows]) + "\n")
    assert notes_among([log, notes]) == [notes]
    (made,) = with_notes([guess_file(log)], [notes])[:1]
    assert [*_masses(made.text.above)] == [pytest.approx(61.235, abs=1e-3)]


def test_a_table_below_a_sentence_with_a_unit_ends_in_no_crash(tmp_path: Path) -> None:
    notes = tmp_path / "notes.md"
    rows = (f"| LF{i} | {i}.90 | 1.5{i} |" for i in (1, 2, 3))
    head = ["Load buttons are 1.00 in above the floor.", "", "| cell | a | b |", "|---|---|---|"]
    notes.write_text("\n".join([*head, *rows]) + "\n")
    assert guess_file(notes).rows > 0


def test_notes_with_a_table_of_weights_are_a_log(tmp_path: Path, run: Run) -> None:
    log, notes = tmp_path / "bench.md", tmp_path / "notes.md"
    rows = (f"| {kg} | {round(8e6 - 1e5 * kg)} |" for kg in (0, 1, 2, 5, 10))
    log.write_text("\n".join(["| load_kg | counts |", "|---|---|", *rows]) + "\n")
    notes.write_text("| cell | x | y |\n|---|---|---|\n| a | 1 | 2 |\n")
    assert notes_among([log, notes]) == [notes]
    assert notes_among([log]) == []
    done = run("init", log, notes, "-o", tmp_path / "r.toml")
    assert "load_kg -> load_n in kg" in done.out


def test_a_sheet_with_a_column_for_the_foot_and_one_for_the_cell(tmp_path: Path) -> None:
    path = tmp_path / "capteurs.csv"
    path.write_text("capteur;pied;x_mm;y_mm\nbout;G;78;38\ntalon;G;-66;30\nbout;D;78;-38\n"
                    "talon;D;-66;-30\n")  # fmt: skip
    found = _places(guess_file(path), "xy", 0.5)
    assert found == {"left bout": (0.078, 0.038), "left talon": (-0.066, 0.03),
                     "right bout": (0.078, -0.038), "right talon": (-0.066, -0.03)}  # fmt: skip
