"""Layouts, units, names and texts of logs as people write them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.errors import DataError
from footcal_cli.sniff.clocks import even, increases, restarts, since_1970, usual_step
from footcal_cli.sniff.encodings import encoding_of
from footcal_cli.sniff.freeform import carried_between, free_form
from footcal_cli.sniff.header import with_units_said
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.silent import no_reading
from footcal_cli.sniff.text import TextGuess, guess_text
from footcal_cli.sniff.texts import numbers_as_labels
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import looks_like_units, split_unit
from footcal_cli.tables.delimited import text_table, upright
from footcal_cli.tables.reading import BLANKS


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("Tx_lbf-in", "Tx", "lbf*in"), ("Mz N.mm", "Mz", "N*mm"),
        ("Torque X (N-m)", "Torque X", "N*m"), ("Kraft [kN]", "Kraft", "kN"),
        ("tx_kgfcm", "tx", "kgf*cm"), ("Mx [ft-lbs]", "Mx", "lbf*ft"), ("Mz (N·mm)", "Mz", "N*mm"),
        ("load_kg", "load", "kg"), ("pos_n_m", "pos_n", "m"), ("t_min", "t", "min"),
        ("leg_L", "leg_L", None), ("counts", "counts", None),
    ],
)  # fmt: skip
def test_units_of_names(name: str, stem: str, unit: str | None) -> None:
    assert split_unit(name)[:2] == (stem, unit)


def test_a_row_of_units_is_no_row_of_names() -> None:
    assert looks_like_units(["s", "N", "mm", "V"])
    assert not looks_like_units(["Load (kg)", "Counts"])


@pytest.mark.parametrize(
    ("name", "quantity", "axis"),
    [
        ("bank_deg", "angle", "roll"), ("Nickwinkel [deg]", "angle", "pitch"),
        ("FL_Wellenwinkel", "phase", ""), ("heading", "angle", "yaw"),
        ("Mx(Nmm)", "force", "tx"), ("Température (°C)",
         "temperature", ""), ("qw", "quaternion", "w"),
    ],
)  # fmt: skip
def test_quantities_of_names(name: str, quantity: str, axis: str) -> None:
    guess = name_guess(name)
    assert (guess.quantity, guess.axis) == (quantity, axis)


def test_names_stand_where_the_units_are_said() -> None:
    names = (4, ["Zeit [s]", "Kraft [N]", "DMS [mV/V]"])
    types, last = (5, ["50 Hz", "Standard", "350 Ohm"]), (6, ["", "CH 1", "CH 2"])
    assert with_units_said([names, types, last]) == names
    assert with_units_said([types, last]) == last


def test_words_with_blanks_in_them_are_one_field(tmp_path: Path) -> None:
    log = tmp_path / "a.txt"
    log.write_text("Position\tFx\tFy\nX down\t1,5\t2,5\nY up\t3,5\t4,5\nZ up\t5,5\t6,5\n")
    layout = guess_text(log).layout
    assert (layout.separator, layout.decimal) == ("\t", ",")
    log.write_text("".join(f"{i} {i * i}\n" for i in range(9)))
    assert guess_text(log).layout.separator == BLANKS


SERIAL = {
    "tabs": (["raw:\t{}\t| avg:\t{}"], ["raw", "avg"]),
    "labels": (["cell=fl raw={}i,load_g={} {}", "cell=fr raw={}i,load_g={} {}"],
               ["cell", "raw", "load_g", "reading"]),
    "stamped": (["14:02:0{} -> {}\t{}"], ["time", "reading", "reading_2"]),
}  # fmt: skip


@pytest.mark.parametrize("case", SERIAL)
def test_patterns_find_every_line(tmp_path: Path, case: str) -> None:
    shapes, names = SERIAL[case]
    lines = [shapes[i % len(shapes)].format(*(i + j for j in range(3))) for i in range(8)]
    layout = free_form(lines, "utf-8")
    assert layout is not None
    log = tmp_path / "a.txt"
    log.write_text("\n".join(lines) + "\n")
    frame, _ = text_table(log, layout, ())
    assert len(frame) == 8
    assert list(frame) == names


def test_loads_typed_behind_a_stamp_do_not_name_the_time_twice() -> None:
    lines = [f"14:02:0{i} -> {i}\t{i}" for i in range(8)]
    lines[4:4] = ["14:02:04 -> load 2 kg"]
    layout = free_form(["14:02:00 -> load 1 kg", *lines], "utf-8")
    assert layout is not None
    assert list(re.compile(layout.carried).groupindex) == ["load_kg"]


def test_lines_between_rows() -> None:
    assert "load" in carried_between(["# load 1 kg", "# load 2 kg"])
    assert carried_between(["# day 1", "hello"]) == ""


@pytest.mark.parametrize(
    ("cell", "found"),
    [
        ("ST,-0500.0  g", ("-0500.0", "g")),
        ("1,5 kg put on", ("1,5", "kg")),
        ("load 2 kg", ("2", "kg")),
        ("run 3", None),
    ],
)
def test_a_weight_among_words(cell: str, found: tuple[str, str] | None) -> None:
    every = IN_WORDS.findall(cell)
    assert every == ([] if found is None else [found])


def test_numbers_of_legs_are_labels_and_readings_are_none() -> None:
    legs = numbers_as_labels(np.tile([1.0, 2.0, 3.0], 20))
    assert legs is not None
    assert legs.words == ("1", "2", "3")
    assert numbers_as_labels(np.array([8_301_000.0, 8_301_200.0] * 20)) is None
    assert numbers_as_labels(np.array([1.5, 2.5] * 20)) is None
    assert numbers_as_labels(np.arange(60.0)) is None


def test_clocks() -> None:
    ns = np.asarray(1.7e18 + 1e8 * np.arange(50), dtype=np.float64)
    assert since_1970(ns) == "ns"
    assert since_1970(np.arange(50.0)) == ""
    assert since_1970(ns[::-1]) == ""
    assert increases(ns)
    assert even(ns)
    assert restarts(np.tile(np.arange(60.0), 3))
    assert not restarts(np.tile(np.arange(5.0), 3))


def test_what_is_no_table_is_refused_with_a_way_on(tmp_path: Path) -> None:
    for name, content, way in (
        ("a.xlsx", b"PK\x03\x04\x00\x00\x00", "CSV"), ("b.jsonl", b'{"a": 1}\n', "footcal convert"),
        ("c.csv", b"\n\n", "record or export"),
    ):  # fmt: skip
        log = tmp_path / name
        log.write_bytes(content)
        with pytest.raises(DataError) as refused:
            guess_text(log)
        assert way in str(refused.value.remedy)


def _guess(folder: Path, text: str) -> TextGuess:
    log = folder / "a.csv"
    log.write_text(text, encoding="utf-8")
    return guess_text(log)


ROWS = "0,7\n1,9\n2,8\n3,9\n"
BLOCKS = {
    "the header again": (f"Cell FL\nkg,raw\n{ROWS}\nCell FR\nkg,raw\n{ROWS}", ["FL", "FR"]),
    "rows alone": (f"kg,raw\n# cell A\n{ROWS}# cell B\n{ROWS}", ["A", "B"]),
    "marks": (f"=== L1 ===\nkg,raw\n{ROWS}=== R1 ===\nkg,raw\n{ROWS}", ["L1", "R1"]),
}


@pytest.mark.parametrize("case", BLOCKS)
def test_blocks_that_are_named_above_are_all_read(tmp_path: Path, case: str) -> None:
    """Of four blocks the first alone was read, and called good."""
    text, cells = BLOCKS[case]
    layout = _guess(tmp_path, text).layout
    assert layout.until == ""
    frame, _ = text_table(tmp_path / "a.csv", layout, ())
    assert frame["channel"].tolist() == [cells[0]] * 4 + [cells[1]] * 4
    assert frame.iloc[:, 1].tolist() == [7, 9, 8, 9] * 2


def test_remarks_name_no_cell(tmp_path: Path) -> None:
    text = "kg,raw\n0,7\n1,9\n# paused\n0,5\n1,8\n# resumed\n0,5\n1,8\n"
    assert _guess(tmp_path, text).layout.carried == ""


def test_what_stands_above_the_rows_is_not_skipped_twice(tmp_path: Path) -> None:
    text = "t,raw\nload 1 kg\n0,7\n1,7\nload 2 kg\n2,9\n3,9\n"
    layout = _guess(tmp_path, text).layout
    frame, lines = text_table(tmp_path / "a.csv", layout, ())
    assert frame["load"].tolist() == ["1 kg", "1 kg", "2 kg", "2 kg"]
    assert lines.tolist() == [3, 4, 6, 7]


def test_rows_that_are_left_out_are_counted(tmp_path: Path) -> None:
    text = f"kg,raw\n{ROWS * 3}Totals\nmean,sd\n5,8\n1,1\n"
    assert (
        "the table ends above 'Totals', 2 rows below it are not read" in _guess(tmp_path, text).said
    )


def test_a_matrix_for_each_frame_is_no_table(tmp_path: Path) -> None:
    frames = "".join(f"Frame {i}\n1,2,3\n4,5,{i}\n\n" for i in range(1, 9))
    with pytest.raises(DataError, match="a matrix of 2 lines for each of 8 frames"):
        _guess(tmp_path, "ROWS 2\n" + frames)


def test_a_sheet_on_its_side_is_turned(tmp_path: Path) -> None:
    guess = _guess(tmp_path, "Load [kg];0;0,5;1\nCell A;7;9;8\nCell B;5;4;2\n")
    assert guess.layout.turned
    frame, _ = text_table(tmp_path / "a.csv", guess.layout, ())
    assert frame["Load [kg]"].tolist() == [0.0, 0.5, 1.0]
    assert frame["Cell B"].tolist() == [5, 4, 2]
    assert upright(["a,1", "b,2,3"], ",") == ["a,b", "1,2", ",3"]
    assert not _guess(tmp_path, "cell,load_kg,raw\nfl,0,7\nfl,1,9\nfr,2,8\n").layout.turned


def test_frames_of_a_bus_are_to_be_decoded(tmp_path: Path) -> None:
    with pytest.raises(DataError) as refused:
        _guess(tmp_path, "".join(f"(17.{i:06d}) can0 181#00FF{i:04X}\n" for i in range(30)))
    assert "cantools" in str(refused.value.remedy)


def test_the_name_of_an_index_and_groups_above_statistics(tmp_path: Path) -> None:
    text = ",raw,raw\n,mean,std\nmass_kg,,\n0.0,7.5,0.1\n0.5,9.5,0.2\n1.0,8.5,0.1\n"
    assert _guess(tmp_path, text).layout.names == ("mass_kg", "raw mean", "raw std")


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("Масса, кг;Отсчёт АЦП\n", "cp1251"), ("ВРЕМЯ;нагрузка\n", "cp1251"),
        ("序号,质量(kg),读数\n", "gb18030"), ("Zählwert;Prüfstand;für Größe\n", "latin-1"),
        ("åäö våg avläsning\n", "latin-1"), ("Température – étalonnée\n", "cp1252"),
    ],
)  # fmt: skip
def test_encodings_by_their_words(text: str, encoding: str) -> None:
    assert encoding_of(text.encode(encoding)) == encoding


def test_minus_one_among_forces_is_a_lost_packet() -> None:
    rng = np.random.default_rng(1)
    force = np.round(rng.uniform(80.0, 90.0, 200), 2)
    force[[3, 50, 51, 52]] = -1.0
    assert no_reading(force) == ("-1",)
    counts = np.round(force * 1e5)
    counts[force < 0] = -1.0
    assert no_reading(counts) == ("-1",)
    around_zero = np.round(rng.normal(0.0, 1.5, 500))
    assert no_reading(around_zero) == ()
    assert no_reading(np.maximum(around_zero, -1.0)) == ()
    assert no_reading(np.repeat([-1.0, 0.0, 1.0, 2.0, 5.0], 4)) == ()


def test_the_rate_of_stamps_in_whole_milliseconds_is_that_of_the_clock() -> None:
    """80 Hz is 12 or 13 ms from row to row; a pause is no step."""
    stamps = np.round(np.concatenate([np.arange(400), 900 + np.arange(400)]) / 80.0, 3)
    assert 1.0 / usual_step(np.diff(stamps)) == pytest.approx(80.0, rel=1e-3)
    assert usual_step(np.zeros(3)) == 0.0
