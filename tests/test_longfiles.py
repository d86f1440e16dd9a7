"""Long logs read in pieces: the same rows, units and refusals as when they are read at once."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.errors import DataError
from footcal_cli.tables import longfiles
from footcal_cli.tables.columns import cells_table
from footcal_cli.tables.reading import ForeignColumn
from footcal_cli.tables.table import read_pieces, read_table

TABLE = cells_table(("left_fl", "left_fr"))
FOREIGN = {"time_s": ForeignColumn("stamp", "ms"), "left_fl_counts": ForeignColumn("FL", None)}
GRAVITY = 9.80665


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(longfiles, "PIECE_ROWS", 7)
    monkeypatch.setattr(longfiles, "PIECE_BYTES", 100)


def frame() -> pd.DataFrame:
    rng = np.random.default_rng(0)
    counts = rng.integers(-5_000_000, 9_000_000, (40, 2))
    return pd.DataFrame(
        {"stamp": 12.5 * np.arange(40), "FL": counts[:, 0], "left_fr_counts": counts[:, 1]}
    )


def write(folder: Path, ending: str) -> Path:
    path = folder / f"log{ending}"
    if ending == ".parquet":
        frame().to_parquet(path, index=False, row_group_size=11)
    elif ending == ".csv.gz":
        path.write_bytes(gzip.compress(frame().to_csv(index=False).encode()))
    elif ending == "_quoted.csv":
        header, lines = frame().to_csv(index=False).split("\n", 1)
        quoted = ",".join(f'"{name}"' for name in header.split(","))
        path.write_text(f"{quoted}\n{lines}")
    else:
        path.write_text(frame().to_csv(index=False).rstrip("\n"))  # no line end at the end
    return path


@pytest.mark.parametrize("ending", [".parquet", ".csv", "_quoted.csv", ".csv.gz"])
def test_pieces_are_the_whole(tmp_path: Path, ending: str) -> None:
    path = write(tmp_path, ending)
    whole = read_table(path, TABLE, FOREIGN, gravity_mps2=GRAVITY)
    pieces = list(read_pieces(path, TABLE, FOREIGN, gravity_mps2=GRAVITY))
    assert len(pieces) > 4
    joined = pd.concat([piece.data for piece in pieces], ignore_index=True)
    pd.testing.assert_frame_equal(joined, whole.data)
    assert {piece.digest for piece in pieces} == {whole.digest}


def test_a_bad_cell_of_a_late_piece_is_named_by_its_line_in_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, ".csv")
    lines = path.read_text().splitlines()
    lines[30] = "375.0,many,3"
    path.write_text("\n".join(lines))
    with pytest.raises(DataError, match=r"column FL, line 31: not a number \(value 'many'\)"):
        list(read_pieces(path, TABLE, FOREIGN, gravity_mps2=GRAVITY))


def test_a_line_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, ".csv")
    path.write_text(path.read_text().rpartition(",")[0])
    with pytest.raises(DataError, match="the last line is cut off"):
        list(read_pieces(path, TABLE, FOREIGN, gravity_mps2=GRAVITY))


def test_a_file_without_rows_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("stamp,FL,left_fr_counts\n")
    with pytest.raises(DataError, match="no rows"):
        list(read_pieces(path, TABLE, FOREIGN, gravity_mps2=GRAVITY))


def test_quoted_texts_are_read_at_once(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    table = frame().assign(note='a "b"\nc')
    table.to_csv(path, index=False)
    (whole,) = read_pieces(path, TABLE, FOREIGN, gravity_mps2=GRAVITY)
    assert len(whole) == 40


@pytest.mark.parametrize(("largest", "held"), [(2**30 - 1, np.int32), (2**30, np.int64)])
def test_counts_of_a_long_log_are_held_in_32_bits_that_hold_their_differences(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, largest: int, held: type
) -> None:
    monkeypatch.setattr(longfiles, "LONG_BYTES", 0)
    counts = np.array([-(2**30) + 1, largest, 0, 7])
    path = tmp_path / "log.parquet"
    log = {"time_s": np.arange(4.0), "left_fl_counts": counts, "left_fr_counts": counts // 2}
    pd.DataFrame(log).to_parquet(path, index=False)
    table = read_table(path, TABLE, gravity_mps2=GRAVITY)
    assert table.data["left_fl_counts"].dtype == held
    np.testing.assert_array_equal(table.number("left_fl_counts"), counts)
    np.testing.assert_array_equal(
        np.diff(table.data["left_fl_counts"].to_numpy()), np.diff(counts.astype(float))
    )


LATE_CELLS = {
    "integers": "7",
    "a number with a point": "7.5",
    "an empty cell": "",
    "above 64 bits of a sign": str(2**63 + 5),
    "a word": "many",
}


@pytest.mark.parametrize("late", LATE_CELLS.values(), ids=LATE_CELLS.keys())
def test_a_long_csv_read_in_pieces_is_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, late: str
) -> None:
    """Whatever stands in a late piece, a fault named by its line included."""
    path = write(tmp_path, ".csv")
    lines = path.read_text().splitlines()
    lines[30] = f"375.0,{late},3"
    path.write_text("\n".join(lines))
    said: list[object] = []
    for long_bytes in (0, 2**30):
        monkeypatch.setattr(longfiles, "LONG_BYTES", long_bytes)
        try:
            said.append(read_table(path, TABLE, FOREIGN, gravity_mps2=GRAVITY).data)
        except DataError as error:
            said.append(error.line())
    pieces, whole = said
    if isinstance(whole, pd.DataFrame):
        assert isinstance(pieces, pd.DataFrame)
        pd.testing.assert_frame_equal(pieces, whole, check_dtype=False)
    else:
        assert "line 31" in str(whole)
        assert pieces == whole
