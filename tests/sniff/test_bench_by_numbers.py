"""What numbers and notes say of a bench: gravity, ways, runs of one cell, series in columns."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.derived import IS_SCATTER
from footcal_cli.sniff.listed_places import places_in
from footcal_cli.sniff.said_gravity import gravity_in
from footcal_cli.sniff.units import known_unit
from tests.conftest import Run

UP, DOWN = (0, 2, 5, 10, 15, 20), (15, 10, 5, 2, 0)


@pytest.mark.parametrize(
    ("line", "g"),
    [
        ("Sala 23 C. g = 9,786.", 9.786), ("g = 9,8156 m/s2 her i huset", 9.8156),
        ("g_loc: 9.7980 N/kg", 9.798), ("Erdbeschleunigung am Ort 9,8087 m/s²", 9.8087),
        ("local gravity is 9.80665 m/s^2", 9.80665), ("重力加速度 9.798", 9.798),
        ("acceleration up to 9.81 m/s3", None), ("mass 9.81 kg", None), ("g = 9.1 m/s2", None),
        ("weights of 9.8 g", None), ("version 9.81.2 of g", None),
    ],
)  # fmt: skip
def test_gravity_in_words(line: str, g: float | None) -> None:
    said = gravity_in([line])
    assert (None if said is None else said[0]) == g


def test_two_gravities_say_none() -> None:
    assert gravity_in(["g = 9.81", "g = 9.79"]) is None


@pytest.mark.parametrize(("text", "unit"), [("℃", "°C"), ("㎏", "kg"), ("ｍｍ", "mm")])
def test_units_that_are_one_sign(text: str, unit: str) -> None:
    assert known_unit(text) == unit


def test_places_by_the_index_of_a_list() -> None:
    text = "Order: [0] (0.085, 0.035), [1] (0.085, -0.035), [2] (-0.05, 0.032) m. Loads (1, 2)."
    sheet = places_in(Path("notes.md"), f"# Robot\n\n{text}\nRepeats (1, 2) in random order.")
    assert sheet is not None
    assert sheet.columns[0].words == ("[0]", "[1]", "[2]")
    assert sheet.columns[1].unit == "m"


def recipe_of(run: Run, folder: Path, *files: Path) -> dict[str, Any]:
    """The recipe that init writes for some files."""
    answer = run("init", *files, "-o", folder / "my.toml")
    assert answer.exit_code == 0, answer.err
    return tomllib.loads((folder / "my.toml").read_text(encoding="utf-8"))


def ladder(
    folder: Path, words: Sequence[str], loads: Sequence[Sequence[float]], temperature: str = ""
) -> Path:
    """Two cells under ladders whose parts have a word each."""
    rng = np.random.default_rng(3)
    lines = [f"celda;kam;kg;cuentas{temperature and ';' + temperature}"]
    for cell, scale in (("a", 1.9e3), ("b", 2.1e3)):
        for word, part in zip(words, loads, strict=True):
            for kg in part:
                read = scale * kg + 500 + rng.normal(0, 3)
                warm = f";{21 + rng.normal(0, 0.3):.1f}" if temperature else ""
                lines.append(f"{cell};{word};{kg};{read:.0f}{warm}")
    path = folder / "bench.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("words", [("vzhuru", "dolu"), ("가압", "감압"), ("q", "z")])
def test_two_words_beside_a_load_are_its_ways(
    run: Run, words: tuple[str, str], tmp_path: Path
) -> None:
    up, down = words
    log = ladder(tmp_path, (up, down) * 2, (UP, DOWN) * 2, "t (℃)")
    columns = recipe_of(run, tmp_path, log)["columns"]
    assert columns["direction"] == {"column": "kam", "names": {up: "1", down: "-1"}}
    assert columns["temperature_degc"] == {"column": "t (℃)", "unit": "°C"}


@pytest.mark.parametrize(
    ("words", "loads"),
    [
        (("q", "z"), (UP + DOWN, UP + DOWN)),  # two operators
        (("q", "z", "q", "z"), (UP, (15, 10), (15, 20), (15, 10, 5, 2, 0))),  # a ladder in another
        (("q", "z"), ((0, 10, 5, 20), (15, 2, 10, 0))),
    ],
)
def test_other_words_beside_a_load_are_no_ways(
    run: Run, words: Sequence[str], loads: Sequence[Sequence[float]], tmp_path: Path
) -> None:
    columns = recipe_of(run, tmp_path, ladder(tmp_path, words, loads))["columns"]
    assert "direction" not in columns


def test_two_words_in_a_file_of_one_cell_are_ways_and_no_cells(run: Run, tmp_path: Path) -> None:
    """A sheet for each cell, which its name gives."""
    rng, files = np.random.default_rng(5), []
    for cell, scale in (("48213", 0.0201), ("48216", 0.0199), ("48219", 0.0202)):
        rows = [
            f"{series};{word};{kg};{scale * kg + 0.008 + rng.normal(0, 1e-4):.4f}".replace(".", ",")
            for series in (1, 2, 3) for word, part in (("fel", UP), ("le", DOWN)) for kg in part
        ]  # fmt: skip
        files.append(tmp_path / f"erocella_{cell}.csv")
        head = f"Merocella gy.sz.;{cell}\n\nsorozat;irany;tomeg_kg;kijelzes_mV/V\n"
        files[-1].write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    made = recipe_of(run, tmp_path, *files)
    assert [name[-5:] for name in made["robot"]["channels"]] == ["48213", "48216", "48219"]
    assert made["columns"]["direction"]["names"] == {"fel": "1", "le": "-1"}


@pytest.mark.parametrize(("mean", "scatter"), [("F_{}_N", "std_{}_N"), ("kracht_{}", "sd_{}")])
def test_scatter_next_to_means_under_another_prefix(
    tmp_path: Path, mean: str, scatter: str
) -> None:
    rng = np.random.default_rng(6)
    cells = ("LV", "RV", "RA", "LA")
    table = pd.DataFrame({mean.format(c): rng.uniform(5.0, 90.0, 40).round(2) for c in cells})
    for cell in cells:
        table[scatter.format(cell)] = rng.uniform(0.1, 0.3, 40).round(2)
    table.to_csv(tmp_path / "plate.csv", index=False)
    guessed = {c.column: c for c in guess_file(tmp_path / "plate.csv").columns}
    for cell in cells:
        assert guessed[mean.format(cell)].quantity in ("reading", "unknown")
        assert guessed[scatter.format(cell)].why == IS_SCATTER


SCALES = {"A": 4.1e-4, "B": 4.3e-4, "C": 4.2e-4}


def runs(folder: Path, names: str) -> list[Path]:
    """Three cells that were loaded twice each, a file for each cell and run."""
    rng = np.random.default_rng(4)
    made = []
    for cell, scale in SCALES.items():
        for number in (1, 2):
            zero = rng.normal(0, 500)
            rows = [f"{kg};{kg * 9.80665 / scale + zero + rng.normal(0, 5):.0f}"
                    for kg in UP + DOWN]  # fmt: skip
            path = folder / names.format(cell=cell, run=number)
            path.write_text("\n".join(["kg;raw", *rows]) + "\n", encoding="utf-8")
            made.append(path)
    return made


@pytest.mark.parametrize("names", ["celula_{cell}_rep{run}.csv", "run{run}_{cell}.csv",
                                   "b-{cell}-go{run}.csv"])  # fmt: skip
def test_a_file_for_each_cell_and_run(run: Run, names: str, tmp_path: Path) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    made = recipe_of(run, tmp_path, *runs(tmp_path, names))
    assert made["robot"]["channels"] == ["A", "B", "C"]
    run("offline-fit", "--recipe", recipe, "--out", out, "--quiet")
    found = json.loads((out / "parameters.json").read_text())["parameters"]
    for cell, scale in SCALES.items():
        assert found[f"{cell}.scale"]["value"] == pytest.approx(scale, rel=1e-3)


def sheets(folder: Path, *, by_file: bool) -> list[Path]:
    """Four sheets of three columns: series of one cell each, or three cells in four sessions."""
    rng = np.random.default_rng(5)
    own = 1.0 + 3e-3 * rng.normal(size=(4, 3))
    scale = np.repeat(own[:, :1], 3, axis=1) if by_file else np.repeat(own[:1], 4, axis=0)
    made = []
    for i, number in enumerate((71, 72, 75, 80)):
        zero = rng.normal(0, 2e-3, 3)
        lines = ["Trin;Retning;Lod [kg];R 1 (0°) [mV/V];R 2 (120°) [mV/V];R 3 (240°) [mV/V]"]
        for word, part in (("op", UP), ("ned", DOWN)):
            for kg in part:
                read = 0.04 * scale[i] * kg + zero + rng.normal(0, 3e-5, 3)
                said = ";".join(f"{x:.5f}" for x in read)
                lines.append(f"{len(lines)};{word};{kg};{said}".replace(".", ","))
        path = folder / f"Skema_U9C-44{number}.csv"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        made.append(path)
    return made


def test_columns_are_series_of_the_cell_of_their_file(run: Run, tmp_path: Path) -> None:
    notes = tmp_path / "notes.md"
    notes.write_text("# Kontrol\n\n`Lod [kg]` er massen. g = 9,8156 m/s2 her.\n")
    made = recipe_of(run, tmp_path, *sheets(tmp_path, by_file=True), notes)
    channels = [f"U9C-44{n}" for n in (71, 72, 75, 80)]
    assert made["robot"]["channels"] == channels
    assert made["robot"]["gravity_mps2"] == 9.8156
    assert made["files"][0]["wide_into"] == "session"
    assert made["columns"]["direction"]["names"] == {"op": "1", "ned": "-1"}
    done = run("offline-fit", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "o", "--quiet")
    assert done.exit_code == 0, done.err


def test_columns_of_cells_stay_cells(run: Run, tmp_path: Path) -> None:
    made = recipe_of(run, tmp_path, *sheets(tmp_path, by_file=False))
    assert made["files"][0]["wide_into"] == "channel"
    assert len(made["robot"]["channels"]) == 3


def test_a_word_between_typed_loads_is_none_of_them(tmp_path: Path) -> None:
    """Where nothing on the cell is typed as 0, ``MOV`` says that a weight is being changed."""
    load = np.repeat([0, 1000, 2000, 1000, 0], 40)
    said = np.where(np.arange(load.size) % 40 < 3, "MOV", load.astype(str))
    counts = np.rint(8e3 + 20.0 * load + 5.0 * np.random.default_rng(3).standard_normal(load.size))
    log = tmp_path / "CEL_A.txt"
    pd.DataFrame(
        {"millis": 100 * np.arange(load.size), "leitura": counts.astype(int), "carga_g": said}
    ).to_csv(log, index=False)
    column = next(c for c in guess_file(log).columns if c.column == "carga_g")
    assert (column.quantity, column.unit, column.missing) == ("load", "g", ("MOV",))
    assert column.values is not None
    assert np.isnan(column.values[said == "MOV"]).all()
