"""Reading logs: units, foreign names, and one clear line for every fault."""

from __future__ import annotations

import gzip
import os
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pint
import pytest

from footcal_cli.errors import DataError, FootcalError, UsageError
from footcal_cli.tables.columns import (
    UNIT_SUFFIXES,
    Column,
    TableType,
    body_table,
    cells_table,
    converts,
    legs_table,
    weights_table,
)
from footcal_cli.tables.logfiles import digest
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import ForeignColumn, Join, Reading
from footcal_cli.tables.sources import _at_times
from footcal_cli.tables.table import Table, read_table, refusal_of, write_parquet
from footcal_cli.tables.units import SPELLINGS, conversion, parse_unit

G = 9.80665
GOOD = "channel,load_kg,counts\na,0,8300000\na,0.5,8200000\n"


def read(path: Path, **columns: ForeignColumn) -> Table:
    return read_table(path, weights_table(), columns, gravity_mps2=G)


def written(folder: Path, text: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


# NIST SP 811 (2008), appendix B: 1 kgf = 9.80665 N, 1 lbf = 4.4482216152605 N
@pytest.mark.parametrize(
    ("unit", "to", "one"),
    [
        ("kg", "N", 9.80665), ("g", "N", 9.80665e-3), ("kgf", "N", 9.80665),
        ("lbf", "N", 4.4482216152605), ("mN", "N", 1e-3), ("mm", "m", 1e-3),
        ("deg", "rad", np.pi / 180), ("ms", "s", 1e-3), ("lb", "N", 0.45359237 * 9.80665),
    ],
)  # fmt: skip
def test_units_convert_as_nist_says(unit: str, to: str, one: float) -> None:
    convert = conversion(unit, to, G)
    np.testing.assert_allclose(convert(np.array([0.0, 1.0, 3.0])), [0.0, one, 3 * one], rtol=1e-12)


def test_fahrenheit_has_an_offset() -> None:
    converted = conversion("degF", "degC", G)(np.array([32.0, 212.0]))
    np.testing.assert_allclose(converted, [0, 100], atol=1e-9)


def test_sizes_of_units_are_those_of_pint() -> None:
    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    compound = ["m/s^2", "deg/s", "kg*m^2/s", "kgf*cm", "N/m*s", "Nm^2", "lbf*in/s", "grams"]
    unlike = {"count", "counts", "degC", "°C", "degF", "°F", "K"}  # no number; another zero
    known = [word for word in (*SPELLINGS, *compound) if word not in unlike]
    for unit, to in product(known, known):
        source, target = (registry.Unit(parse_unit(word).name) for word in (unit, to))
        weighed = source.is_compatible_with("kg") and target.is_compatible_with("N")
        if weighed:
            expected = registry.Quantity(1.0, source).to("kg") * registry.Quantity(G, "m/s^2")
        else:
            expected = registry.Quantity(1.0, source)
        if not weighed and not source.is_compatible_with(target):
            with pytest.raises(UsageError):
                conversion(unit, to, G)
            continue
        found = conversion(unit, to, G)
        assert found.slope == pytest.approx(expected.to(target).magnitude, rel=1e-14)
        assert found.weighed == weighed


def test_a_unit_suffix_is_read_and_counts_stay_integers(tmp_path: Path) -> None:
    table = read(written(tmp_path, GOOD))
    np.testing.assert_allclose(table.number("load_n"), [0.0, 0.5 * G])
    assert table.data["counts"].dtype == np.int64
    assert table.source["load_n"] == "load_kg"


def test_a_unit_suffix_of_another_quantity_is_another_column(tmp_path: Path) -> None:
    """``left_fl_n`` is the true force of a cell, not its counts in newtons."""
    true = written(tmp_path, "time_s,left_fl_n\n0,1.5\n1,2.5\n", "true_loads.csv")
    assert refusal_of(true, cells_table(("left_fl",)), {}) is not None
    with pytest.raises(DataError, match="left_fl_counts"):
        read_table(true, cells_table(("left_fl",)), {}, gravity_mps2=G)
    millis = written(tmp_path, "time_ms,left_fl_counts\n0,1\n5,2\n", "cells.csv")
    assert refusal_of(millis, cells_table(("left_fl",)), {}) is None


def test_foreign_names_and_units_are_mapped(tmp_path: Path) -> None:
    path = written(tmp_path, "Zelle,Masse,AD\na,0,1\na,500,2\n")
    table = read(
        path,
        channel=ForeignColumn("Zelle"),
        load_n=ForeignColumn("Masse", "g"),
        counts=ForeignColumn("AD"),
    )
    np.testing.assert_allclose(table.number("load_n"), [0.0, 0.5 * G])


def test_csv_gz_parquet_and_a_bom_read_the_same(tmp_path: Path) -> None:
    plain = read(written(tmp_path, GOOD)).data
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(GOOD.encode()))
    marked = tmp_path / "bom.csv"
    marked.write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    parquet = tmp_path / "log.parquet"
    write_parquet(pd.read_csv(tmp_path / "log.csv"), parquet)
    for path in (packed, marked, parquet):
        pd.testing.assert_frame_equal(read(path).data, plain)


def test_the_same_table_is_written_as_the_same_bytes(tmp_path: Path) -> None:
    data = pd.DataFrame({"time_s": [0.0, 0.1], "counts": [1, 2]})
    for name in ("a.parquet", "b.parquet"):
        write_parquet(data, tmp_path / name)
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


FAULTS: dict[str, tuple[str, type[FootcalError], tuple[str, ...]]] = {
    "empty file": ("", DataError, ("empty",)),
    "header only": ("channel,load_kg,counts\n", DataError, ("no rows",)),
    "text in a number": (GOOD + "a,1,oops\n", DataError, ("counts", "line 4", "'oops'")),
    "NaN": (GOOD + "a,nan,5\n", DataError, ("load_kg", "line 4", "NaN")),
    "empty cell": (GOOD + "a,1,\n", DataError, ("counts", "line 4")),
    "infinite": (GOOD + "a,inf,5\n", DataError, ("load_kg", "line 4", "infinite")),
    "missing column": ("channel,load_kg,count\na,0,1\n", DataError, ("counts", "'count'")),
    "column twice": ("channel,load_kg,load_kg,counts\na,0,0,1\n", DataError, ("twice",)),
    "decimal comma": ("channel,load_kg,counts\na,0,1\na,0,5,2\n", DataError, ("fields",)),
    "decimal commas": ("channel,load_kg,counts\na,0,5,2\na,0,5,2\n", DataError, ("fields",)),
}


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_is_one_line_that_says_where(tmp_path: Path, name: str) -> None:
    text, kind, words = FAULTS[name]
    with pytest.raises(kind) as caught:
        read(written(tmp_path, text))
    line = caught.value.line()
    assert "\n" not in line
    assert "log.csv" in line
    assert "Remedy:" in line
    for word in words:
        assert word in line, line


def test_a_missing_file_an_unknown_unit_and_a_wrong_quantity_are_usage_errors(
    tmp_path: Path,
) -> None:
    with pytest.raises(UsageError, match="no such file"):
        read(tmp_path / "absent.csv")
    path = written(tmp_path, "channel,w,counts\na,0,1\na,1,2\n")
    with pytest.raises(UsageError, match="unknown unit 'klio'"):
        read(path, load_n=ForeignColumn("w", "klio"))
    with pytest.raises(UsageError, match="same quantity"):
        read(path, load_n=ForeignColumn("w", "mm"))


def test_a_truncated_parquet_file_and_a_cut_gzip_are_named(tmp_path: Path) -> None:
    whole = tmp_path / "whole.parquet"
    write_parquet(pd.DataFrame({"channel": ["a"] * 500, "load_n": 1.0, "counts": 1}), whole)
    cut = tmp_path / "cut.parquet"
    cut.write_bytes(whole.read_bytes()[:-40])
    with pytest.raises(DataError, match=r"cut\.parquet.*truncated"):
        read(cut)
    packed = gzip.compress((GOOD * 400).encode())
    (tmp_path / "cut.csv.gz").write_bytes(packed[: len(packed) // 2])
    with pytest.raises(DataError, match=r"cut\.csv\.gz"):
        read(tmp_path / "cut.csv.gz")


def test_lost_samples_of_a_stream_are_kept_as_nan(tmp_path: Path) -> None:
    stream = TableType("s", (Column("time_s", "t"), Column("a_counts", "a", missing="keep")))
    path = written(tmp_path, "time_s,a_counts\n0.0,5\n0.1,\n0.2,7\n")
    table = read_table(path, stream, gravity_mps2=G)
    np.testing.assert_array_equal(table.number("a_counts"), [5.0, np.nan, 7.0])


def test_suffixes_convert_where_their_units_do() -> None:
    """The table that names columns agrees with the library that converts them."""
    for suffix, unit in UNIT_SUFFIXES.items():
        for other, target in UNIT_SUFFIXES.items():
            try:
                conversion(unit, target, G)
            except UsageError:
                possible = False
            else:
                possible = True
            assert converts(suffix, other) == possible, (suffix, other)


def test_a_unit_in_the_name_of_a_mapped_column_counts_unless_the_recipe_says_another(
    tmp_path: Path,
) -> None:
    path = tmp_path / "weights.csv"
    path.write_text("channel,weight_g,counts\na,1000,1\na,2000,2\n", "utf-8")
    for place, newtons in ((ForeignColumn("weight_g"), G), (ForeignColumn("weight_g", "N"), 1e3)):
        table = read_table(path, weights_table(), {"load_n": place}, gravity_mps2=G)
        assert table.number("load_n") == pytest.approx([newtons, 2 * newtons])


@pytest.mark.parametrize(
    ("name", "newtons"),
    [("load (g)", G), ("Kraft [kN]", 1e6), ("F_kN", 1e6), ("Gewicht [lb]", 1e3 * 0.45359237 * G),
     ("F [N]", 1e3), ("load_fl", 1e3), ("F (left)", 1e3), ("n_m", 1e3)],
)  # fmt: skip
def test_a_unit_in_brackets_or_at_the_end_of_a_name_is_the_unit(
    tmp_path: Path, name: str, newtons: float
) -> None:
    path = tmp_path / "weights.csv"
    path.write_text(f"channel,{name},counts\na,1000,1\na,2000,2\n", "utf-8")
    table = read_table(path, weights_table(), {"load_n": ForeignColumn(name)}, gravity_mps2=G)
    assert table.number("load_n") == pytest.approx([newtons, 2 * newtons])


@pytest.mark.parametrize("name", ["weight_gr", "Masse [gr]", "load kp", "load_lb"])
def test_a_unit_that_is_not_clear_at_the_end_of_a_name_is_asked_for(
    tmp_path: Path, name: str
) -> None:
    path = tmp_path / "weights.csv"
    path.write_text(f"channel,{name},counts\na,1000,1\na,2000,2\n", "utf-8")
    with pytest.raises(UsageError, match="is not clear") as refused:
        read_table(path, weights_table(), {"load_n": ForeignColumn(name)}, gravity_mps2=G)
    assert refused.value.remedy is not None
    assert f'load_n = {{ column = "{name}", unit = "…" }}' in refused.value.remedy
    said = ForeignColumn(name, "N")
    table = read_table(path, weights_table(), {"load_n": said}, gravity_mps2=G)
    assert table.number("load_n") == pytest.approx([1000, 2000])


def test_half_a_vector_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "body.csv"
    kind = body_table(())
    names = [c.name for c in kind.columns if not c.optional]
    whole = [*names, "imu_acc_x_mps2", "imu_acc_y_mps2", "imu_acc_z_mps2"]
    for header in (names, whole):
        path.write_text(",".join(header) + "\n" + ",".join("1" * len(header)) + "\n", "utf-8")
        assert "com_x_m" in read_table(path, kind, gravity_mps2=G)
    path.write_text(",".join(whole[:-1]) + "\n" + ",".join("1" * (len(whole) - 1)) + "\n", "utf-8")
    with pytest.raises(DataError, match="missing column 'imu_acc_z_mps2'"):
        read_table(path, kind, gravity_mps2=G)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are a matter of Unix")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "log.csv")
    with pytest.raises(UsageError, match="pipe"):
        digest(tmp_path / "log.csv")


def test_a_stream_of_legs_needs_no_contacts(tmp_path: Path) -> None:
    names = ["time_s", "leg", "phase_rad", "fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"]
    names += ["body_qx", "body_qy", "body_qz", "body_qw"]
    path = written(tmp_path, f"{','.join(names)}\n0,fl,0,0,0,6,0,0,0,0,0,0,1\n")
    assert refusal_of(path, legs_table(), {}) is None


def test_rows_beyond_the_other_files_last_stamp_take_its_last_value_as_far_as_allowed() -> None:
    raw = RawColumn("number", np.array([5.0, 6.0, 7.0]), np.zeros(3, dtype=bool))
    for how in ("nearest", "previous"):
        join = Join(Path("other.csv"), Reading({}), how=how, tolerance_s=0.5)
        ours = np.array([0.0, 2.25, 9.0])
        found = _at_times(ours, np.array([0.0, 1.0, 2.0]), raw, np.arange(3), join)
        np.testing.assert_array_equal(found.values, [5.0, 7.0, np.nan])
