"""Logs kept by hand: dates, weights typed early or late, holes by their names, cells unloaded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.bench.plateaus import PlateauOptions
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import find_loads
from footcal_cli.core.bench_rows import check_stuck_reading
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import clock_of
from footcal_cli.recipe import Robot
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.session.inspection import inspect
from footcal_cli.session.unloaded import over_logs
from footcal_cli.sheets.streams import without_pauses
from footcal_cli.tables.columns import cells_table, weights_table
from footcal_cli.tables.table import Table, read_table
from tests.cli.walk_files import write_belief, write_stand
from tests.conftest import Run
from tests.core.walk_data import make_standing

G = 9.80665
LADDER = (0.0, 3.0, 6.0, 9.0, 12.0, 6.0, 0.0)


def dated(stamp: str, every_s: float = 72.0) -> pd.DataFrame:
    """Two cells on a shelf, four sessions a day for five days; the second one's zero is warm."""
    rng = np.random.default_rng(5)
    rows = []
    for session in range(20):
        begin = pd.Timestamp("2023-05-02 08:00:00") + pd.Timedelta(hours=24 * (session // 4))
        begin += pd.Timedelta(hours=3 * (session % 4))
        warm = 20.0 + 3.0 * rng.standard_normal()
        for number, kg in enumerate(LADDER):
            at = begin + pd.Timedelta(seconds=every_s * number + rng.uniform(-5.0, 5.0))
            for cell, slope in (("front", 0.0), ("back", 0.05)):
                force = kg * G + slope * (warm - 20.0) + 0.02 * rng.standard_normal()
                seconds = at.timestamp() - 1.683e9
                when = {
                    "iso": at.isoformat(sep=" ", timespec="seconds"),
                    "german": at.strftime("%d.%m.%Y %H:%M:%S"),
                    "number": f"{seconds:.0f}",
                }[stamp]
                rows.append((when, cell, kg, round(7000 * force - 5e4), round(warm, 1)))
    return pd.DataFrame(rows, columns=["when", "cell", "kg", "raw", "room"])


RECIPE = """[robot]
channels = ["front", "back"]
[columns]
load_n = {{ column = "kg", unit = "kg" }}
time_s = {time}
temperature_degc = {{ column = "room", unit = "degC" }}
channel = "cell"
counts = "raw"
[data]
weights = ["log.csv"]
"""


@pytest.mark.parametrize(
    ("stamp", "time"),
    [
        ("iso", '"when"'),
        ("german", '{ column = "when", format = "%d.%m.%Y %H:%M:%S" }'),
        ("number", '{ column = "when", unit = "s" }'),
    ],
)
def test_weights_read_every_minute_over_days_are_sessions(
    run: Run, tmp_path: Path, stamp: str, time: str
) -> None:
    dated(stamp).to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "recipe.toml").write_text(RECIPE.format(time=time))
    answer = run(
        "diagnose", "--recipe", tmp_path / "recipe.toml", "--experiment", "weights",
        "--out", tmp_path / "out", "--no-pictures",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.blocks == 40
    assert not [f for f in record.findings if f.severity == "alarm"]
    assert [(c.effect, c.where) for c in record.causes] == [("temperature_bias", "back")]


def test_bare_numbers_a_minute_apart_may_still_be_milliseconds(tmp_path: Path) -> None:
    log = dated("number").rename(columns={"when": "time_s", "cell": "channel", "raw": "counts"})
    log["load_n"] = log.pop("kg") * G
    log.to_csv(tmp_path / "log.csv", index=False)
    table = read_table(tmp_path / "log.csv", weights_table(), {}, gravity_mps2=G)
    assert "stamps_not_seconds" in {f.code for f in inspect(table, weights_table(), Robot())}


CELLS = ("left_a", "left_b", "left_c")
FOOT = Robot.model_validate(
    {"feet": {"left": {"cells": {c: {"x_m": 0.0, "y_m": 0.0} for c in "abc"}}}}
)


def stance(level: FloatArray, name: str, sway: float = 300.0, seed: int = 0) -> Table:
    """A foot of three cells that stands for 10 s; what carries nothing stays at its zero."""
    rng = np.random.default_rng([seed, *name.encode()])
    n = 500
    moving = np.cumsum(rng.standard_normal((n, 3)), axis=0)
    moving *= sway / np.ptp(moving, axis=0)
    counts = level + np.where(level > 0, moving, 0.0) + 2.0 * rng.standard_normal((n, 3))
    data = pd.DataFrame(counts, columns=[f"{c}_counts" for c in CELLS])
    data.insert(0, "time_s", 0.02 * np.arange(n))
    return Table(data, Path(f"{name}.csv"), "")


def told(tables: list[Table]) -> list[Finding]:
    kind = cells_table(CELLS)
    noted = [f for table in tables for f in inspect(table, kind, FOOT)]
    found = over_logs(noted, tables, kind, FOOT)
    return [f for f in found if f.code in ("dead_cell", "cell_unloaded")]


def test_a_cell_that_carries_nothing_in_one_stance_is_not_dead() -> None:
    levels = [(5e3, 4e3, 0.0), (2e3, 6e3, 5e3), (8e3, 2e3, 1e3), (4e3, 4e3, 7e3)]
    tables = [stance(np.array(level), f"stand_{i}") for i, level in enumerate(levels)]
    (found,) = told(tables)
    assert (found.code, found.severity, found.where) == ("cell_unloaded", "note", "left_c")
    assert "stand_0.csv (1 of 4 cells logs)" in found.sentence


def test_a_cell_that_is_dead_in_every_stance_is_said_once_with_the_logs() -> None:
    levels = [(5e3, 4e3, 0.0), (2e3, 6e3, 0.0), (8e3, 2e3, 0.0)]
    (found,) = told([stance(np.array(level), f"pose{i}") for i, level in enumerate(levels)])
    assert (found.code, found.severity) == ("dead_cell", "alarm")
    assert "in pose0.csv, pose1.csv, pose2.csv (3 of 3 cells logs)" in found.sentence


def test_a_plug_that_was_out_while_its_foot_was_put_down_is_named_with_the_log() -> None:
    walks = [
        stance(np.full(3, 5e3), "walk_1", 9e3),
        stance(np.array([5e3, 5e3, 0.0]), "walk_2", 9e3),
    ]
    (found,) = told(walks)
    assert (found.code, found.where) == ("dead_cell", "left_c")
    assert "in walk_2.csv (1 of 2 cells logs)" in found.sentence


def typed(seed: int, creep: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A recording at 5 Hz whose loads were typed up to 1.5 s early or late: stamps, loads, mV/V."""
    rng = np.random.default_rng(seed)
    holds = np.array([0, 5, 10, 15, 10, 0, 15, 5, 0]) * G
    edges = np.cumsum(rng.uniform(60.0, 120.0, holds.size))
    time_s = np.arange(0.0, edges[-1], 0.2)
    put_on = edges[:-1] + rng.uniform(-1.5, 1.5, holds.size - 1)
    true = holds[np.searchsorted(put_on, time_s)]
    shown, state = true.copy(), 0.0
    for k in range(1, time_s.size):
        state += 0.2 / 30.0 * (true[k] - state)
        shown[k] += creep * state
    touched = np.abs(time_s[:, None] - put_on).min(axis=1) < 0.7
    shown += 0.02 * rng.standard_normal(time_s.size)
    shown[touched] += 12.0 * rng.standard_normal(int(touched.sum()))
    return time_s, holds[np.searchsorted(edges[:-1], time_s)], 0.0103 * shown + 0.008


@pytest.mark.parametrize("seed", range(6))
def test_rows_beside_a_load_typed_late_are_not_of_that_load(seed: int) -> None:
    time_s, load, reading = typed(seed)
    assert check_stuck_reading(load, reading, "K1") == []
    record = BenchRecord("K1", load, reading, time_s, np.zeros(time_s.size, dtype=np.int64))
    settled = find_loads(record, PlateauOptions(), ()).settled
    error = (settled.reading - 0.008) / 0.0103 - settled.load_n
    assert np.nanmax(np.abs(error)) < 0.2
    assert settled.known.mean() > 0.9


def test_a_load_that_was_not_typed_at_all_is_still_seen() -> None:
    true = np.repeat(np.array([0, 5, 10, 15, 10, 0, 5, 15, 5, 0]) * G, 300)
    reading = true + 0.02 * np.random.default_rng(1).standard_normal(true.size)
    load = true.copy()
    load[1200:1500] = 15 * G
    assert check_stuck_reading(true, reading, "K1") == []
    assert [f.code for f in check_stuck_reading(load, reading, "K1")] == ["stuck_load"]


def test_what_offline_fit_finds_in_a_recording_is_what_diagnose_says_it_finds(
    run: Run, tmp_path: Path
) -> None:
    parts = []
    for number, creep in enumerate((0.0, 0.01)):
        time_s, load, reading = typed(number, creep)
        parts.append(
            pd.DataFrame(
                {"channel": f"K{number}", "load_n": load, "counts": reading, "time_s": time_s}
            )
        )
    pd.concat(parts).to_csv(tmp_path / "log.csv", index=False)
    said = {}
    for name, more in (("offline-fit", []), ("diagnose", ["--experiment", "weights"])):
        answer = run(name, tmp_path / "log.csv", *more, "--out", tmp_path / name, "--no-pictures")
        assert answer.exit_code == 0, answer.err
        said[name] = {x.strip() for x in answer.out.splitlines() if "• K" in x}
    assert any("creep" in line for line in said["diagnose"])
    assert said["diagnose"] <= said["offline-fit"]


PLATE = """[robot]
[robot.feet.left.cells]
a = { x_m = 0.08, y_m = 0.0 }
b = { x_m = -0.05, y_m = 0.04 }
c = { x_m = -0.05, y_m = -0.04 }
[[files]]
match = "plate.csv"
[files.columns]
load_n = { column = "lb", unit = "lb" }
placement = "dimple"
repeat = "pass"
foot = { value = "left" }
hole_x_m = { column = "x", unit = "mm" }
hole_y_m = { column = "y", unit = "mm" }
[data]
weights = ["alone.csv"]
placements = ["plate.csv"]
"""
PLACE = np.array([[0.08, 0.0], [-0.05, 0.04], [-0.05, -0.04]])


def plate(folder: Path, wrong: str = "", crosstalk: float = 0.0) -> Path:
    """Three cells by themselves, then under 20 lb in twelve dimples; one is not where it says."""
    rng = np.random.default_rng(8)
    kg = np.tile([0.0, 1, 2, 4, 6, 9, 6, 4, 2, 1, 0], 3)
    alone = [
        pd.DataFrame({"channel": f"left_{c}", "load_n": kg * G,
                      "counts": np.rint(9e3 * (kg * G + 0.02 * rng.standard_normal(kg.size)))})
        for c in "abc"
    ]  # fmt: skip
    pd.concat(alone).to_csv(folder / "alone.csv", index=False)
    grid = [(x, y) for x in (70, 40, 10, -40) for y in (-25, 0, 25)]
    holes = {f"D{i + 1}": xy for i, xy in enumerate(grid)}
    heard = np.eye(3) + crosstalk * np.array([[0, 1, -1], [0.5, 0, 1], [1, -0.5, 0]])
    rows = []
    for number in range(4):
        rows.append((number, "D0", 0, 0, 0.0, *np.rint(9e3 * 0.02 * rng.standard_normal(3))))
        for name in rng.permutation(list(holes)):
            true = np.array(holes[name]) * 1e-3 + (0.006, -0.004) * np.array(name == wrong)
            load = 20 * 4.4482216
            shares = np.linalg.solve(np.vstack([np.ones(3), PLACE.T]), [1.0, *true])
            force = heard @ shares * load + 0.03 * rng.standard_normal(3)
            rows.append((number, name, *holes[name], 20.0, *np.rint(9e3 * force)))
    columns = ["pass", "dimple", "x", "y", "lb", "a_counts", "b_counts", "c_counts"]
    pd.DataFrame(rows, columns=columns).to_csv(folder / "plate.csv", index=False)
    (folder / "recipe.toml").write_text(PLATE)
    return folder / "recipe.toml"


def on_the_plate(run: Run, recipe: Path, *logs: Path) -> tuple[DiagnosisRecord, str]:
    """Calibrate, of all logs or of some, and diagnose the placements with that."""
    folder = recipe.parent
    fit = ("offline-fit", *logs, "--recipe", recipe, "--out", folder / "fit", "--no-pictures")
    answer = run(*fit)
    assert answer.exit_code == 0, answer.err
    answer = run(
        "diagnose", "--recipe", recipe, "--experiment", "placements", "--parameters",
        folder / "fit/parameters.json", "--out", folder / "out", "--no-pictures",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    return read_record(DiagnosisRecord, folder / "out/diagnosis.json"), answer.out


def test_a_wrong_hole_is_named_as_the_log_calls_it(run: Run, tmp_path: Path) -> None:
    record, text = on_the_plate(run, plate(tmp_path, wrong="D6"), tmp_path / "alone.csv")
    (cause,) = record.causes
    assert cause.effect == "wrong_hole"
    assert cause.written == "hole D6 at 40, 25 mm"
    assert "Cause: wrong hole (hole D6 at 40, 25 mm), hole correction" in record.sentence
    rows = {row.effect: row.written for row in record.effects}
    assert rows["wrong_hole"] == cause.written
    assert rows["wrong_weight"] == "written 20 lb"
    assert "hole D6 at 40, 25 mm" in text.split("Evidence")[1]
    gain = cause.held_out_gain
    assert gain is not None
    assert gain.quantity.startswith("moment")
    assert not record.holds


def test_what_the_calibration_in_use_holds_is_said(run: Run, tmp_path: Path) -> None:
    record, text = on_the_plate(run, plate(tmp_path, crosstalk=0.02))
    assert "crosstalk" in {held.effect for held in record.holds}
    line = next(x for x in text.splitlines() if "The calibration in use already holds: " in x)
    assert "crosstalk of left" in line


def test_pauses_between_stances_are_no_gaps() -> None:
    pieces = [np.arange(0.0, 8.0, 0.01) + 20.0 * k for k in range(4)]
    pieces[2] = np.delete(pieces[2], slice(100, 140))
    clock = clock_of(np.concatenate(pieces))
    assert (clock.gaps, without_pauses(clock).gaps) == (4, 1)
    assert without_pauses(clock).missing == 40
    assert without_pauses(clock).longest_gap_s == pytest.approx(0.41)


def test_a_stated_mass_is_taken_as_stated_and_a_file_of_three_rows_is_named(
    run: Run, tmp_path: Path
) -> None:
    made = make_standing(8, 3, replace=True)
    recipe, belief = write_stand(tmp_path, made), write_belief(tmp_path, made)
    text = recipe.read_text()
    recipe.write_text(text.replace("mass_kg =", "mass_sd_kg = 0.004\nmass_kg =", 1))
    fit = ("static-init", "--recipe", recipe, "--parameters", belief, "--no-pictures")
    answer = run(*fit, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert "The mass is taken as known to 0.004 kg, as mass_sd_kg says" in answer.out
    assert "weigh the robot" not in answer.out
    cells = pd.read_parquet(tmp_path / "cells.parquet")
    cells.head(3).to_parquet(tmp_path / "cells.parquet")
    answer = run(*fit, "--out", tmp_path / "again")
    assert answer.exit_code != 0
    assert "cells.parquet: 3 rows are no recording of a robot" in answer.err
