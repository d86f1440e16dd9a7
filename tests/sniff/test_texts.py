"""Layouts, units, names and texts of logs as people write them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.errors import DataError
from footcal_cli.sniff.clocks import even, increases, restarts, since_1970
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_names import alike_part, called
from footcal_cli.sniff.freeform import carried_between, free_form
from footcal_cli.sniff.groups import channel_names, readings
from footcal_cli.sniff.header import with_units_said
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.text import guess_text
from footcal_cli.sniff.texts import numbers_as_labels
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import looks_like_units, split_unit
from footcal_cli.tables.delimited import text_table
from footcal_cli.tables.reading import BLANKS


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("Tx_lbf-in", "Tx", "lbf*in"), ("Mz N.mm", "Mz", "N*mm"),
        ("Torque X (N-m)", "Torque X", "N*m"), ("Kraft [kN]", "Kraft", "kN"),
        ("load_kg", "load", "kg"), ("pos_n_m", "pos_n", "m"),
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
        ("heading", "angle", "yaw"), ("Mx(Nmm)", "force", "tx"), ("Température (°C)",
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


def test_a_displacement_or_a_temperature_is_no_reading(tmp_path: Path) -> None:
    """They follow the load, or rise evenly: a calibration of them would look good."""
    log = tmp_path / "a.csv"
    lines = [f"{i / 10};{i};{i / 900:.4f};{22 + i / 100};{i * 0.7 + 3:.3f}" for i in range(60)]
    log.write_text("t [s];F [N];Weg [mm];T [°C];DMS [V]\n" + "\n".join(lines) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert [
        e.column.column for n, e in plan.entries.items() if n.endswith("counts") and e.column
    ] == ["DMS [V]"]


def test_siblings_of_a_reading_are_readings(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text(
        "load_N,A,B\n" + "\n".join(f"{i},{9 * i * i % 31},{7 * i % 5}" for i in range(9)) + "\n"
    )
    assert list(channel_names(readings(guess_file(log)))) == ["a", "b"]


def test_names_of_files_that_say_a_load_in_any_unit(tmp_path: Path) -> None:
    logs = []
    for name in ("cell2_zero.csv", "cell2_8oz.csv", "cell2_16oz.csv"):
        logs.append(tmp_path / name)
        logs[-1].write_text("reading\n" + "\n".join(f"{7000 + 3 * i % 7}" for i in range(9)) + "\n")
    part = alike_part([guess_file(log) for log in logs])
    assert part is not None
    load = part.plan.entries["load_n"]
    assert load.unit == "oz"
    assert set(load.names.values()) == {"0", "8", "16"}


def test_logs_named_alike_are_called_after_their_folders(tmp_path: Path) -> None:
    paths = [tmp_path / "0g" / "log.csv", tmp_path / "500g" / "log.csv"]
    assert called(paths) == ["0g/log.csv", "500g/log.csv"]
    assert called(paths[:1]) == ["log.csv"]


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
