"""What a recipe says of files: layouts, constants, file names, wide tables, joins, attitudes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.commands import option_tables
from footcal_cli.core.bench.moving import align
from footcal_cli.core.bench.plateaus import PlateauOptions, why_no_hold
from footcal_cli.errors import DataError, UsageError
from footcal_cli.recipe import Recipe, read_recipe
from footcal_cli.tables.columns import hang_table, poses_table, weights_stream_table, weights_table
from footcal_cli.tables.table import Table, read_table
from footcal_cli.tables.units import load_list

G = 9.80665


def recipe(folder: Path, text: str) -> Recipe:
    path = folder / "r.toml"
    path.write_text(text, encoding="utf-8")
    return read_recipe(path, option_tables())


def test_layout_constant_and_name_of_the_file(tmp_path: Path) -> None:
    log = tmp_path / "fl_500g.txt"
    log.write_bytes("Prüfstand 3\n# leer\nt;ADC\nms;-\n0;1,5\n20;2,5\n".encode("latin-1"))
    said = recipe(
        tmp_path,
        """
        [[files]]
        match = "*_*g.txt"
        separator = ";"
        decimal = ","
        encoding = "latin-1"
        comment = "#"
        skip_rows = 1
        skip_below = 1
        [columns]
        channel = { value = "fl" }
        load_n = { file_name = '_(\\d+)g', unit = "g" }
        counts = "ADC"
        time_s = { column = "t", unit = "ms" }
    """,
    )
    table = read_table(log, weights_table(), said.reading(log), gravity_mps2=G)
    np.testing.assert_allclose(table.number("load_n"), [0.5 * G] * 2)
    np.testing.assert_allclose(table.number("counts"), [1.5, 2.5])
    np.testing.assert_allclose(table.number("time_s"), [0.0, 0.02])
    assert list(table.text("channel")) == ["fl", "fl"]


def test_a_wide_row_becomes_a_row_per_entry(tmp_path: Path) -> None:
    log = tmp_path / "wide.csv"
    log.write_text("load_kg,a,b\n0,1,2\n1,3,4\n")
    said = recipe(
        tmp_path,
        """
        [[files]]
        wide = { fl = { counts = "a" }, fr = { counts = "b" } }
    """,
    )
    table = read_table(log, weights_table(), said.reading(log), gravity_mps2=G)
    assert list(table.text("channel")) == ["fl", "fl", "fr", "fr"]
    np.testing.assert_allclose(table.number("counts"), [1, 3, 2, 4])


def side_by_side(folder: Path, into: str) -> Table:
    """Two rows of a cell, whose two readings each stand side by side, taken into a column."""
    log = folder / "wide.csv"
    log.write_text("cell,load_kg,a,b\nfl,0,1,2\nfl,1,3,4\n")
    said = recipe(
        folder,
        f"""
        [columns]
        channel = "cell"
        [[files]]
        wide_into = "{into}"
        wide = {{ 1 = {{ counts = "a" }}, 2 = {{ counts = "b" }} }}
    """,
    )
    return read_table(log, weights_table(), said.reading(log), gravity_mps2=G)


def test_readings_of_one_cell_stay_in_their_row(tmp_path: Path) -> None:
    table = side_by_side(tmp_path, "reading")
    np.testing.assert_allclose(table.number("counts"), [1, 2, 3, 4])
    np.testing.assert_allclose(table.number("load_n"), [0, 0, G, G])


def test_a_wide_table_into_a_column_that_nothing_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="wide_into = 'readings' is no column of this table"):
        side_by_side(tmp_path, "readings")


def test_a_join_by_time_interpolates_and_leaves_out_what_is_too_far(tmp_path: Path) -> None:
    log = tmp_path / "cell.csv"
    log.write_text("counts\n" + "".join(f"{i}\n" for i in range(6)))
    (tmp_path / "press.csv").write_text("time_ms,force_kn\n100,1\n300,3\n")
    said = recipe(
        tmp_path,
        """
        [[files]]
        match = "cell.csv"
        rate_hz = 10
        join = [{ file = "press.csv", offset_s = 0.1, tolerance_s = 0.11 }]
        [files.columns]
        load_n = { column = "press.force_kn", unit = "kN" }
        c_counts = "counts"
    """,
    )
    stream = weights_stream_table(("c",))
    table = read_table(log, stream, said.reading(log), gravity_mps2=G)
    # press stamps 0.2 and 0.4 s on the cell's clock, between them a straight line
    expected = [np.nan, 1000, 1000, 2000, 3000, 3000]
    np.testing.assert_allclose(table.number("load_n"), expected)
    assert tmp_path / "press.csv" in table.beside


def test_an_attitude_reads_the_same_in_every_form(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    turned = Rotation.random(5, rng=rng)
    wrench = "fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm"
    forms = {
        "q": ([f"body_q{a}" for a in "xyzw"], turned.as_quat()),
        "e": (["body_roll_deg", "body_pitch_deg", "body_yaw_deg"],
              turned.as_euler("xyz", degrees=True)),
        "m": ([f"body_r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)],
              turned.as_matrix().reshape(5, 9)),
    }  # fmt: skip
    found = {}
    for name, (columns, values) in forms.items():
        path = tmp_path / f"{name}.csv"
        lines = [f"{i},fl,0,0,0,0,0,0,0," + ",".join(f"{v:.12f}" for v in row)
                 for i, row in enumerate(values)]  # fmt: skip
        head = f"pose,leg,phase_rad,{wrench},{','.join(columns)}"
        path.write_text("\n".join([head, *lines]) + "\n")
        table = read_table(path, poses_table(), gravity_mps2=G)
        q = table.numbers([f"body_q{a}" for a in "xyzw"])
        found[name] = q * np.sign(q[:, 3:])
    np.testing.assert_allclose(found["e"], found["q"], atol=1e-9)
    np.testing.assert_allclose(found["m"], found["q"], atol=1e-9)


def test_a_hanging_log_without_any_attitude_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "hang.csv"
    path.write_text("time_s,leg,fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm\n0,fl,0,0,0,0,0,0\n")
    with pytest.raises(DataError, match=r"orientation.*gravity_x"):
        read_table(path, hang_table(), gravity_mps2=G)


def test_loads_are_written_with_their_unit() -> None:
    # NIST SP 811: 1 lb = 0.45359237 kg
    np.testing.assert_allclose(load_list("[0, 1, 2] lb", G), np.arange(3) * 0.45359237 * G)
    with pytest.raises(UsageError, match="list of loads"):
        load_list("1, 2, 5", G)


def test_the_lag_behind_a_moving_reference_is_found() -> None:
    """Closed form: a sine read 35 ms late."""
    t = np.arange(3000) / 100
    load = 20 + 10 * np.sin(2 * np.pi * 0.3 * t)
    late = 20 + 10 * np.sin(2 * np.pi * 0.3 * (t - 0.035))
    found = align(t, load, -250 * late + 7, np.ones(t.size, dtype=bool), 7)
    assert found.lag_s == pytest.approx(0.035, abs=2e-4)
    assert found.attenuation < 1e-4


def test_a_hold_that_is_too_short_names_the_length_that_would_take_it() -> None:
    t = np.arange(400) / 20
    reading = np.where((t > 6) & (t < 8), 500.0, 100 * t) + np.sin(40 * t)
    problem, remedy = why_no_hold(t, reading, PlateauOptions(window_s=0.5, min_hold_s=3.0))
    assert "less than min_hold_s = 3 s" in problem
    assert "min_hold_s = 1" in remedy


def test_numbers_may_be_called_by_names_as_words_are(tmp_path: Path) -> None:
    """A setup 0, 1, 2: in a table of numbers as much as in a text."""
    axes = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
    log = pd.DataFrame(
        {"setup": [0.0, 1.0, 1.0], "leg": ["a"] * 3, "time_s": [0.0, 0.1, 0.2]}
        | dict.fromkeys(axes, 1.0)
    )
    log.to_parquet(tmp_path / "log.parquet")
    log.to_csv(tmp_path / "log.csv", index=False)
    said = recipe(
        tmp_path,
        """
        [columns]
        orientation = { column = "setup", names = { "0" = "+x", "1.0" = "-z" } }
    """,
    )
    for name in ("log.parquet", "log.csv"):
        path = tmp_path / name
        table = read_table(path, hang_table(), said.reading(path), gravity_mps2=G)
        assert list(table.text("orientation")) == ["+x", "-z", "-z"]
