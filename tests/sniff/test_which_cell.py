"""Columns and names of files that say which cell a row is of; Parquet as CSV."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of
from tests.conftest import Run
from tests.sniff.test_placed import CELLS_M, HOLES_M, Bench

G = 9.80665
LADDER = (0, 1, 2, 4, 6, 4, 2, 1, 0)


def only_plan(*paths: Path) -> LogPlan:
    parts, others = parts_of([guess_file(path) for path in paths])
    assert others == []
    assert len(parts) == 1
    return parts[0].plan


def columns_of(plan: LogPlan) -> dict[str, str]:
    return {n: e.column.column for n, e in plan.entries.items() if e.column is not None}


def written(path: Path, header: str, rows: Sequence[Sequence[object]]) -> Path:
    lines = [header, *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("cell", ["cell_no", "zelle_nr", "sensor_number", "cell_bangou"])
@pytest.mark.parametrize("read", ["denatsu_uV", "bridge_uV", "out_uV"])
def test_a_number_of_cells_is_no_reading(tmp_path: Path, cell: str, read: str) -> None:
    rng = np.random.default_rng(1)
    rows = [
        (c, run, 1000 * kg, f"{20 * c + 300 * kg + rng.normal(0, 0.3):.1f}", 22.9 + 0.1 * run)
        for c in (1, 2, 3, 4) for run in (1, 2) for kg in LADDER
    ]  # fmt: skip
    log = written(tmp_path / "log.csv", f"{cell},run,load_g,{read},ondo_C", rows)
    plan = only_plan(log)
    assert plan.channels == ("1", "2", "3", "4")
    found = columns_of(plan)
    assert (found["channel"], found["counts"]) == (cell, read)
    assert found["temperature_degc"] == "ondo_C"
    assert plan.entries["counts"].unit == "uV"


@pytest.mark.parametrize("day", ["2023-10-0{}", "0{}.10.2023", "2023/10/0{}"])
@pytest.mark.parametrize("ways", ["ud", "id", "UD"])
def test_days_are_sessions_and_letters_are_ways(tmp_path: Path, day: str, ways: str) -> None:
    rng = np.random.default_rng(2)
    up = (0, 1, 2, 4, 6)
    rows = [
        (day.format(d), f"N{c}", way, kg, round(1e4 * c + 3e4 * kg + rng.normal(0, 50)),
         f"{20 + 0.3 * d + rng.normal(0, 0.1):.1f}")
        for d in (4, 5, 6) for c in (1, 2, 3)
        for way, loads in zip(ways, (up, up[::-1]), strict=True) for kg in loads
    ]  # fmt: skip
    plan = only_plan(written(tmp_path / "cal.csv", "date,id,way,m_kg,raw,t_C", rows))
    assert plan.channels == ("N1", "N2", "N3")
    found = columns_of(plan)
    assert (found["channel"], found["session"]) == ("id", "date")
    assert (found["direction"], found["temperature_degc"]) == ("way", "t_C")
    assert dict(plan.entries["direction"].names) == {ways[0]: "1", ways[1]: "-1"}


@pytest.mark.parametrize("none", ["-", "none", "0"])
def test_the_loaded_cell_beside_a_word_for_none(tmp_path: Path, none: str) -> None:
    rng = np.random.default_rng(3)
    zero, slope = np.array([10.0, 35.0, 42.0, -33.0]), np.array([50.0, 52.0, 49.0, 51.0])
    rows, t = [], 0
    for cell in (0, 1, 2, 3) * 2:
        for kg in (0, 2, 5, 8):
            for _ in range(30):
                load = np.where(np.arange(4) == cell, kg, 0.0)
                read = zero + slope * load + rng.normal(0, 0.2, 4)
                rows.append((t, f"ch{cell + 1}" if kg else none, kg, *(f"{v:.3f}" for v in read)))
                t += 1
    log = written(tmp_path / "log.csv", "time,cell_loaded,kg,ch1,ch2,ch3,ch4", rows)
    plan = only_plan(log)
    assert plan.channels == ("ch1", "ch2", "ch3", "ch4")
    for name, own in plan.wide.items():
        assert own["load_n"].only_where == {"cell_loaded": name}
    assert plan.ready


@pytest.mark.parametrize(("stem", "cells"), [("cell_", 3), ("Zelle", 3), ("run_", 1), ("log", 1)])
def test_files_named_after_cells(tmp_path: Path, stem: str, cells: int) -> None:
    rng = np.random.default_rng(4)
    paths = []
    for c in (1, 2, 3):
        loads = np.repeat([0.0, 7.5, 15.0, 7.5, 0.0], 120)
        rows = [(f"{0.25 * i:.2f}", kg, f"{0.2 * c + 0.1 * kg + rng.normal(0, 0.0005):.5f}")
                for i, kg in enumerate(loads)]  # fmt: skip
        paths.append(written(tmp_path / f"{stem}{c}.csv", "t,weight_kg,mV", rows))
    plan = only_plan(*paths)
    assert len(plan.channels) == cells
    if cells > 1:
        channel = plan.entries["channel"]
        said = [re.fullmatch(channel.file_name or "", path.name) for path in paths]
        assert [channel.names[f[1]] for f in said if f] == list(plan.channels)


def test_cells_called_t_and_a_number_are_no_clock(tmp_path: Path) -> None:
    bench = Bench(5, 0.05, 4)
    names = [f"A{i}" for i in range(len(HOLES_M))]
    made = bench.placed("set,hole,kg,T1,T2,H1,H2", names, empty="-", kg=(6.0,))
    (tmp_path / "plate.csv").write_text(made, encoding="utf-8")
    (tmp_path / "bench.csv").write_text(
        bench.alone("cell,run,kg,mV", ["T1", "T2", "H1", "H2"]), encoding="utf-8"
    )
    parts, _ = parts_of([guess_file(tmp_path / f"{n}.csv") for n in ("bench", "plate")])
    plans = {part.plan.role: part.plan for part in parts}
    assert plans["placements"].channels == plans["weights"].channels
    assert len(plans["weights"].channels) == 4


def test_named_holes_of_a_parquet_file_run(tmp_path: Path, run: Run) -> None:
    """What init writes for a text column of Parquet is run, and its numbers are those of CSV."""
    bench = Bench(6, 0.05, 4)
    names = [f"s{i}" for i in range(len(HOLES_M))]
    made = bench.placed("run,hole,mass_kg,mV_k1,mV_k2,mV_k3,mV_k4", names, empty="-", kg=(6.0,))
    (tmp_path / "plate.csv").write_text(made, encoding="utf-8")
    pd.read_csv(tmp_path / "plate.csv").to_parquet(tmp_path / "plate.parquet")
    (tmp_path / "bench.csv").write_text(
        bench.alone("cell,rep,mass_kg,mV", ["k1", "k2", "k3", "k4"]), encoding="utf-8"
    )
    holes = [(n, 1e3 * x, 1e3 * y) for n, (x, y) in zip(names, HOLES_M, strict=True)]
    sheet = written(tmp_path / "holes.csv", "hole,x_mm,y_mm", holes)
    figures = []
    for end in ("csv", "parquet"):
        recipe = tmp_path / f"{end}.toml"
        answer = run("init", tmp_path / "bench.csv", tmp_path / f"plate.{end}", sheet, "-o", recipe)
        assert answer.exit_code == 0, answer.err
        text = recipe.read_text(encoding="utf-8").replace("# [robot.feet", "[robot.feet")
        for i, (x, y) in enumerate(CELLS_M, 1):
            text = re.sub(rf"# (m_v_k_{i}) = .*", rf"\1 = {{ x_m = {x}, y_m = {y} }}", text)
        recipe.write_text(text, encoding="utf-8")
        out = tmp_path / f"out_{end}"
        done = run("offline-fit", "--recipe", recipe, "--out", out, "--quiet", "--no-pictures")
        assert done.exit_code == 0, done.err
        figures.append((out / "rmse.json").read_text(encoding="utf-8"))
    assert figures[0] == figures[1]


@pytest.mark.parametrize("changed", ["-1", "-999", "-1.0"])
def test_a_number_while_the_load_is_changed(tmp_path: Path, changed: str) -> None:
    rng = np.random.default_rng(8)
    rows, t, on = [], 0, 0.0
    for cell in (0, 1, 2) * 2:
        for kg in (*LADDER, 0):
            for at in range(40):
                # a hand takes the weights off, then puts others on
                put = on * (1 - at / 5) if at < 5 else kg * min((at - 5) / 5, 1.0)
                volt = 0.2 * cell - 0.08 * np.where(np.arange(3) == cell, put, 0.0)
                word = "" if at < 2 else f"AI{cell}"
                mass = changed if at < 10 else f"{1000 * kg}"
                volt += rng.normal(0, 1e-3, 3)
                rows.append((f"{0.1 * t:.2f}", word, mass, *(f"{v:.5f}" for v in volt)))
                t += 1
            on = kg
    log = written(tmp_path / "log.csv", "time,under_test,mass_g,AI0_V,AI1_V,AI2_V", rows)
    plan = only_plan(log)
    assert plan.channels == ("AI0", "AI1", "AI2")
    for name, own in plan.wide.items():
        assert own["load_n"].only_where == {"under_test": name}
        assert own["load_n"].missing == (changed.removesuffix(".0"),)


def test_a_load_below_nothing_is_one(tmp_path: Path) -> None:
    rng = np.random.default_rng(9)
    rows = [
        (cell, newton, f"{80 * at + 3 * newton + rng.normal(0, 0.05):.3f}")
        for at, cell in enumerate(("toe", "heel")) for newton in (-1, -1, 0, 2, 5, 5, 2, 0, -1, -1)
    ]  # fmt: skip
    plan = only_plan(written(tmp_path / "log.csv", "cell,force_applied_N,reading_mV", rows))
    assert plan.entries["load_n"].missing == ()
