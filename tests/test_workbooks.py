"""Workbooks are read as the text of their fullest sheet."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.errors import DataError, UsageError
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from footcal_cli.tables.textfiles import first_bytes
from footcal_cli.tables.workbooks import other_sheets, sheet_text
from tests.conftest import Run
from tests.packed_workbook import Cell, packed_workbook


def test_rows_keep_their_numbers_and_cells_their_digits(tmp_path: Path) -> None:
    rows: list[list[Cell]] = [["Force log"], [], ["t", "Fz, N"], [0.25, 8388607.0], [0.5, "1,5"]]
    book = packed_workbook(tmp_path / "a.xlsx", {"notes": [["by hand"]], "data": rows})
    assert sheet_text(book).decode().splitlines() == [
        "Force log,", ",", 't,"Fz, N"', "0.25,8388607", "0.5,1.5"
    ]  # fmt: skip
    assert other_sheets(book) == ("notes",)
    assert first_bytes(book, 9) == b"Force log"


def test_what_is_no_workbook_is_refused_with_a_way_on(tmp_path: Path) -> None:
    book = tmp_path / "a.xlsx"
    book.write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(DataError, match="workbook") as refused:
        sheet_text(book)
    assert "CSV" in str(refused.value.remedy)
    with pytest.raises(DataError, match="no sheet has any cell"):
        sheet_text(packed_workbook(tmp_path / "b.xlsx", {"empty": [[]]}))


def test_without_the_library_its_install_command_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    with pytest.raises(UsageError) as refused:
        sheet_text(packed_workbook(tmp_path / "a.xlsx", {"data": [[1.0]]}))
    assert "footcal[excel]" in str(refused.value.remedy)


def test_weights_in_a_workbook_become_a_calibration(tmp_path: Path, run: Run) -> None:
    rng, scale, zero = np.random.default_rng(4), 3.2e-5, 8.39e6
    rows: list[list[Cell]] = [
        ["Load cell, left foot", None, "12 May"], [], ["No.", "Mass", "Reading"],
        [None, "g", "counts"],
    ]  # fmt: skip
    for k, grams in enumerate((0.0, 500.0, 1000.0, 2000.0, 1000.0, 500.0, 0.0) * 3):
        read = zero + grams * 1e-3 * 9.80665 / scale + rng.normal(0.0, 20.0)
        rows.append([k + 1.0, grams, float(np.round(read))])
    book = packed_workbook(tmp_path / "cell.xlsx", {"Calibration": rows, "Notes": [["calm"]]})
    recipe = tmp_path / "my.toml"
    made = run("init", book, "-o", recipe)
    assert made.exit_code == 0
    assert "Notes" in made.out
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "fit").exit_code == 0
    found = read_record(ParametersRecord, tmp_path / "fit" / "parameters.json").parameters
    (fitted,) = (one for name, one in found.items() if name.endswith(".scale"))
    assert fitted.sd is not None
    assert abs(fitted.value - scale) < 4.0 * fitted.sd < 0.01 * scale


def test_every_sheet_becomes_a_file_of_its_own(tmp_path: Path, run: Run) -> None:
    sheets: dict[str, list[list[Cell]]] = {
        cell: [["g", "counts"], [0.0, 8e6 + k], [500.0, 8.1e6]] for k, cell in enumerate("AB")
    }
    book = packed_workbook(tmp_path / "cells.xlsx", {**sheets, "empty": [[]]})
    made = run("convert", book, "--out", tmp_path / "csv")
    assert made.exit_code == 0
    assert sorted(path.name for path in (tmp_path / "csv").iterdir()) == ["A.csv", "B.csv"]
    assert (tmp_path / "csv" / "B.csv").read_text() == "g,counts\n0,8000001\n500,8100000\n"
    again = run("convert", book, "--out", tmp_path / "csv")
    assert (again.exit_code, "--overwrite" in again.err) == (2, True)
    mixed = run("convert", book, tmp_path / "csv" / "A.csv", "--out", tmp_path / "all")
    assert (mixed.exit_code, (tmp_path / "all").exists()) == (2, False)


def test_sheets_that_would_get_one_name_are_refused(tmp_path: Path, run: Run) -> None:
    rows: list[list[Cell]] = [["g", "counts"], [0.0, 8e6], [500.0, 8.1e6]]
    book = packed_workbook(tmp_path / "cells.xlsx", {"left A": rows, "left.A": rows})
    refused = run("convert", book, "--out", tmp_path / "csv", "--overwrite")
    assert (refused.exit_code, "left_A.csv" in refused.err) == (2, True)
    assert not (tmp_path / "csv").exists()
