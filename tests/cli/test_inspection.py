"""What a log says against the recipe and against itself: faults found, clean logs left in peace."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.plausibility import check_shares
from footcal_cli.recipe import Robot
from footcal_cli.records.results import ParametersRecord
from footcal_cli.session import calibration
from footcal_cli.session.inspection import inspect
from footcal_cli.session.request import inspect_record
from footcal_cli.tables import columns
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import Table, refusal_of
from tests.cli.inspected import SAMPLES, Frame, G, alarms, bent, clean, recipe, times


def kinds(robot: Robot) -> list[TableType]:
    feet = tuple(robot.feet) or ("left", "right")
    cells = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    found = [
        columns.weights_table(), columns.hang_table(), columns.legs_table(), columns.poses_table(),
        columns.body_table(feet), columns.six_axis_feet_table(feet),
    ]  # fmt: skip
    found += [columns.placements_table(cells)] if cells else []
    return found + ([columns.cells_table(robot.cell_names)] if robot.cell_names else [])


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("nao_walk", "biped/*.parquet"),
        ("bench_foot", "bench_foot/*.csv"),
        ("hexapod", "hexapod/*.parquet"),
    ],
)
def test_clean_samples_raise_nothing(name: str, pattern: str) -> None:
    robot, looked = recipe(name).robot, 0
    for path in sorted(SAMPLES.glob(pattern)):
        for kind in kinds(robot):
            if refusal_of(path, kind, {}) is None:
                looked += 1
                assert not alarms(clean(path, kind, name), kind, robot), path.name
    assert looked >= 2


@pytest.mark.parametrize(
    ("name", "pattern", "known"),
    [
        ("reemc_walking", "reemc-walking/*.csv", set[str]()),
        ("loadsol_insoles", "loadsol-insoles/test_*_loadsol.csv", {"lost_samples"}),
    ],
)
def test_recordings_of_others_raise_nothing_but_what_they_have(
    real_data: Path, name: str, pattern: str, known: set[str]
) -> None:
    robot, foreign, looked = recipe(name).robot, recipe(name).reading(Path()), 0
    for path in sorted(real_data.glob(pattern)):
        for kind in kinds(robot):
            if refusal_of(path, kind, foreign) is None:
                looked += 1
                assert alarms(clean(path, kind, name), kind, robot) <= known, path.name
    assert looked >= 2


CELLS = ("left_fl", "left_fr", "left_rl", "left_rr")


def spiked(log: Frame) -> Frame:
    values = log["left_fl_counts"].astype(float)
    values.iloc[100:900:100] = -8.4e6
    return log.assign(left_fl_counts=values)


def dead(log: Frame) -> Frame:
    noise = np.random.default_rng(1).normal(0.0, 50.0, len(log)).round()
    return log.assign(left_fl_counts=8.3e6 + noise)


def turned_cell(log: Frame) -> Frame:
    return log.assign(left_fl_counts=1.66e7 - log["left_fl_counts"])


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (spiked, "outliers"),
        (dead, "dead_cell"),
        (turned_cell, "turned_sign"),
        (lambda log: log.assign(left_fl_counts=log["left_rr_counts"]), "duplicate_channel"),
        (lambda log: log.assign(left_fl_counts=8e6), "stuck_channel"),
        (lambda log: log.assign(left_fl_counts=np.nan), "lost_samples"),
        (lambda log: log.assign(left_fl_counts=1e300 * log["left_fl_counts"]), ""),
        (times("time_s", 1e3), "stamps_not_seconds"),
    ],
)
def test_cells_of_a_walk(change: Callable[[Frame], Frame], code: str) -> None:
    robot = recipe("nao_walk").robot
    kind = columns.cells_table(robot.cell_names)
    table = clean(SAMPLES / "biped/walk_004_cells.parquet", kind, "nao_walk")
    found = alarms(bent(table, change), kind, robot)
    assert code in found or (not code and not found)


@pytest.mark.parametrize(
    ("change", "codes"),
    [
        (times("load_n", 1.0 / G), {"scale_off_nameplate"}),
        (times("load_n", 1e3 / G), {"scale_off_nameplate"}),
        (times("load_n", -1.0), {"scale_off_nameplate", "negative_loads"}),
        (lambda log: log.assign(counts=log["counts"].sample(frac=1, random_state=1).to_numpy()),
         {"dead_cell"}),
    ],
)  # fmt: skip
def test_weights_against_the_nameplate(change: Callable[[Frame], Frame], codes: set[str]) -> None:
    robot = recipe("nao_walk").robot
    assert robot.nameplate.scale_n_per_count is not None
    kind = columns.weights_table()
    table = clean(SAMPLES / "biped/weights.parquet", kind, "nao_walk")
    assert alarms(bent(table, change), kind, robot) == codes


def test_what_a_calibration_states_against_the_recipe() -> None:
    robot = Robot(name="A")
    record = ParametersRecord(
        command="offline-fit", created="", robot="A", gravity_mps2=robot.gravity_mps2,
        sign_convention="force = scale * counts + bias, positive when the cell is pressed",
        frame="", expressed_at="", parameters={},
    )  # fmt: skip
    assert not list(inspect_record(record, robot, "p.json"))
    for change, code, severity in (
        ({"robot": "B"}, "calibration_of_another_robot", "warning"),
        ({"gravity_mps2": 1.62}, "gravity_differs", "alarm"),
        ({"gravity_mps2": 9.79}, "gravity_differs", "note"),
        (
            {"sign_convention": "force = bias - scale * counts"},
            "unknown_sign_convention",
            "warning",
        ),
    ):
        (finding,) = inspect_record(record.model_copy(update=change), robot, "p.json")
        assert (finding.code, finding.severity) == (code, severity)
    for own in vars(calibration).values():  # what footcal writes it also reads
        if isinstance(own, calibration.Conventions):
            written = record.model_copy(update={"sign_convention": own.signs})
            assert not list(inspect_record(written, robot, "p.json")), own.signs


def test_placements_whose_cells_are_exchanged_copied_or_in_millimetres() -> None:
    robot = recipe("bench_foot").robot
    kind = columns.placements_table(tuple(robot.feet["left"].cells))
    table = clean(SAMPLES / "bench_foot/placements.csv", kind, "bench_foot")
    swapped = {"fl_counts": "rr_counts", "rr_counts": "fl_counts"}
    for change, code in (
        (lambda log: log.rename(columns=swapped), "exchanged_channels"),
        (lambda log: log.assign(fl_counts=log["fr_counts"]), "duplicate_channel"),
        (times("hole_", 1e3), "holes_not_metres"),
    ):
        assert code in alarms(bent(table, change), kind, robot)


@pytest.mark.parametrize("cell", ["fl", "fr", "rl", "rr"])
def test_placements_with_a_cell_of_turned_sign(cell: str) -> None:
    robot = recipe("bench_foot").robot
    kind = columns.placements_table(tuple(robot.feet["left"].cells))
    table = clean(SAMPLES / "bench_foot/placements.csv", kind, "bench_foot")
    turned = bent(table, times(f"{cell}_counts", -1.0))
    (finding,) = [f for f in inspect(turned, kind, robot) if f.code == "turned_sign"]
    assert (finding.severity, finding.where) == ("alarm", f"left_{cell}")
    # no nameplate says how the bridge is wired: its calibration has to
    unnamed = robot.model_copy(update={"nameplate": Robot().nameplate})
    (finding,) = [f for f in inspect(turned, kind, unnamed) if f.code == "turned_sign"]
    assert finding.severity == "warning"


@pytest.mark.parametrize(
    ("load", "turn", "codes"),
    [
        (1.0, (1, 1, 1, 1), []),
        (1.0, (1, -1, 1, 1), ["turned_sign"]),
        (1.07, (1, 1, 1, 1), ["weights_not_all_shown"]),
        (1.0 / G, (1, 1, 1, 1), ["loads_off_calibration"]),
        (1.0 / 4.448222, (1, 1, 1, 1), ["loads_off_calibration"]),
        (-1.0, (1, 1, 1, 1), ["loads_off_calibration"]),
    ],
)
def test_weights_on_a_foot_against_the_calibration_of_its_cells(
    load: float, turn: tuple[int, ...], codes: list[str]
) -> None:
    robot = recipe("bench_foot").robot
    kind = columns.placements_table(tuple(robot.feet["left"].cells))
    table = clean(SAMPLES / "bench_foot/placements.csv", kind, "bench_foot")
    truth = json.loads((SAMPLES / "bench_foot/truth.json").read_text("utf-8"))["parameters"]
    cells = [f"left_{cell}" for cell in robot.feet["left"].cells]
    scale, bias = (np.array([truth[f"{c}.{n}"] for c in cells]) for n in ("scale", "bias"))
    counts = table.numbers([f"{cell}_counts" for cell in robot.feet["left"].cells])
    forces = scale * counts * np.array(turn) + bias
    found = check_shares(forces, cells, load * table.number("load_n"), calibrated=True)
    assert [f.code for f in found] == codes


def test_a_dead_cell_under_weights_on_a_foot_and_among_cells_loaded_together() -> None:
    rustle = np.random.default_rng(3)
    robot = recipe("bench_foot").robot
    kind = columns.placements_table(tuple(robot.feet["left"].cells))
    table = clean(SAMPLES / "bench_foot/placements.csv", kind, "bench_foot")
    dead = 8.3e6 + rustle.normal(0.0, 40.0, len(table)).round()
    found = inspect(bent(table, lambda log: log.assign(rr_counts=dead)), kind, robot)
    assert [f.where for f in found if f.code == "dead_cell"] == ["left_rr"]
    cells = ("a", "b")
    load = rustle.uniform(0.0, 30.0, (60, 2))
    counts = np.column_stack([8.3e6 - load[:, 0] / 3.4e-5, 8.3e6 + rustle.normal(0, 40, 60)])
    data = Frame({f"{c}_load_n": load[:, i] for i, c in enumerate(cells)})
    data = data.assign(**{f"{c}_counts": counts[:, i].round() for i, c in enumerate(cells)})
    together = Table(data, Path("together.csv"), "")
    found = inspect(together, columns.weights_together_table(cells), Robot())
    assert [(f.code, f.where) for f in found] == [("dead_cell", "b")]


def frozen(log: Frame) -> Frame:
    held = log.copy()
    held.iloc[200:400, 1:] = held.iloc[200, 1:].to_numpy()
    return held


def loose(log: Frame) -> Frame:
    span = float(np.ptp(log["left_fl_counts"]))
    noise = np.random.default_rng(2).normal(0.0, 0.5 * span, len(log))
    return log.assign(left_fl_counts=log["left_fl_counts"] + noise)


@pytest.mark.parametrize(
    ("log", "change", "code"),
    [
        ("walk_004_cells", frozen, "stream_frozen"), ("walk_004_body", frozen, "stream_frozen"),
        ("walk_004_cells", loose, "loose_channel"),
    ],
)  # fmt: skip
def test_a_stream_that_repeats_itself_and_a_channel_that_jumps(
    log: str, change: Callable[[Frame], Frame], code: str
) -> None:
    robot = recipe("nao_walk").robot
    body = log.endswith("body")
    kind = columns.body_table(tuple(robot.feet)) if body else columns.cells_table(robot.cell_names)
    table = clean(SAMPLES / f"biped/{log}.parquet", kind, "nao_walk")
    assert code in alarms(bent(table, change), kind, robot)
