"""What a log says against the recipe and against itself: faults found, clean logs left in peace."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.commands import option_tables
from footcal_cli.core.body_stream import (
    check_acceleration,
    check_heading_across,
    check_overlap,
    check_quaternions,
    check_saturation,
)
from footcal_cli.core.plausibility import check_shares
from footcal_cli.recipe import Recipe, Robot, read_recipe
from footcal_cli.records.results import ParametersRecord
from footcal_cli.session import calibration
from footcal_cli.session.calibration import Conventions
from footcal_cli.session.inspection import inspect
from footcal_cli.session.request import inspect_record
from footcal_cli.tables import columns
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import Table, read_table, refusal_of
from tests.conftest import REPOSITORY

SAMPLES = REPOSITORY / "sample_data"
Frame = pd.DataFrame
G = 9.80665


@cache
def recipe(name: str) -> Recipe:
    return read_recipe(REPOSITORY / "recipes" / f"{name}.toml", option_tables())


def kinds(robot: Robot) -> list[TableType]:
    feet = tuple(robot.feet) or ("left", "right")
    cells = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    found = [
        columns.weights_table(), columns.hang_table(), columns.legs_table(), columns.poses_table(),
        columns.body_table(feet), columns.six_axis_feet_table(feet),
    ]  # fmt: skip
    found += [columns.placements_table(cells)] if cells else []
    return found + ([columns.cells_table(robot.cell_names)] if robot.cell_names else [])


@cache
def clean(path: Path, kind: TableType, name: str) -> Table:
    foreign = recipe(name).reading(path)
    return read_table(path, kind, foreign, gravity_mps2=G)


def bent(table: Table, change: Callable[[Frame], Frame]) -> Table:
    return Table(change(table.data.copy()), table.path, "")


def alarms(table: Table, kind: TableType, robot: Robot) -> set[str]:
    return {f.code for f in inspect(table, kind, robot) if f.severity != "note"}


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


def times(pattern: str, factor: float) -> Callable[[Frame], Frame]:
    def change(log: Frame) -> Frame:
        names = [c for c in log.columns if pattern in c]
        assert names
        return log.assign(**{c: factor * log[c] for c in names})

    return change


def gravity_in(log: Frame) -> Frame:
    return log.assign(com_acc_z_mps2=log["com_acc_z_mps2"] + G)


def other_frame(log: Frame) -> Frame:
    return log.assign(com_x_m=log["com_x_m"] + 7.0)


def in_degrees(log: Frame) -> Frame:
    # a robot that looks to the left, as most headings in a laboratory are not 0
    names = [c for c in log.columns if c.endswith("yaw_rad")]
    return log.assign(**{c: np.degrees(log[c] + 1.0) for c in names})


def imu(size: float) -> Callable[[Frame], Frame]:
    def change(log: Frame) -> Frame:
        noise = 0.01 * np.random.default_rng(0).standard_normal((len(log), 3))
        return log.assign(**{f"imu_acc_{a}_mps2": noise[:, i] + size * (i == 2)
                             for i, a in enumerate("xyz")})  # fmt: skip

    return change


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (times("time_s", 1e3), "stamps_not_seconds"),
        (times("com_z_m", 1e3), "positions_not_metres"),
        (times("_foot_y_m", 1e3), "positions_not_metres"),
        (times("_z_m", -1.0), "z_points_down"),
        (other_frame, "com_not_over_feet"),
        (gravity_in, "acceleration_holds_gravity"),
        (times("com_acc_", 1.0 / G), "acceleration_not_of_com"),
        (times("com_acc_", 1e3), "acceleration_not_of_com"),
        (times("com_acc_", -1.0), "acceleration_not_of_com"),
        (in_degrees, "heading_not_radians"),
        (imu(1.0), "imu_without_gravity"),
        (imu(0.0), "imu_without_gravity"),
        (imu(G), ""),
    ],
)
def test_a_body_stream_in_other_units(change: Callable[[Frame], Frame], code: str) -> None:
    kind = columns.body_table(("left", "right"))
    table = clean(SAMPLES / "biped/walk_004_body.parquet", kind, "nao_walk")
    assert alarms(bent(table, change), kind, recipe("nao_walk").robot) == ({code} - {""})


def test_an_accelerometer_that_stops_at_its_range_is_seen_and_one_with_tails_is_not() -> None:
    rng = np.random.default_rng(5)
    acc = rng.normal(0.0, 0.3, (6000, 3))
    for landing in range(50, 6000, 60):
        acc[landing : landing + 3, 2] += 40.0 * rng.uniform(0.3, 1.2) * np.array([0.6, 1.0, 0.5])
    (found,) = check_saturation(np.clip(acc, -2.0 * G, 2.0 * G), "imu_acc")
    assert found.code == "acceleration_saturated"
    assert "19.6" in found.sentence
    assert not check_saturation(acc, "imu_acc")
    steps = np.round(rng.standard_t(3, size=(6000, 3)) / 0.05) * 0.05
    assert not check_saturation(steps, "imu_acc")


def test_quaternions_with_w_first(real_data: Path) -> None:
    yaw = np.linspace(-2.0, 2.0, 9)
    upright = np.stack([0 * yaw, 0 * yaw, np.sin(yaw / 2), np.cos(yaw / 2)], axis=1)
    assert not check_quaternions(upright, "foot")
    (finding,) = check_quaternions(upright[:, [3, 0, 1, 2]], "foot")
    assert finding.code == "quaternions_w_first"
    assert check_quaternions(2.0 * upright, "foot")[0].code == "no_unit_quaternions"
    # the ankle link of REEM-C has z forward, as its recipe says: nothing to say about that
    robot, foreign = recipe("reemc_walking").robot, recipe("reemc_walking").reading(Path())
    kind = columns.body_table(tuple(robot.feet))
    table = read_table(real_data / "reemc-walking/14_1.csv", kind, foreign, gravity_mps2=G)
    assert not alarms(table, kind, robot)
    kind = columns.poses_table()
    poses = clean(SAMPLES / "hexapod/poses.parquet", kind, "hexapod")
    names = [f"body_q{a}" for a in "xyzw"]

    def turned(log: Frame) -> Frame:
        return log.assign(
            **dict(zip(names, log[names[-1:] + names[:-1]].to_numpy().T, strict=True))
        )

    robot = recipe("hexapod").robot
    assert alarms(bent(poses, turned), kind, robot) == {"quaternions_w_first"}


def test_accelerations_are_compared_with_the_motion_whatever_delays_or_noise() -> None:
    rng = np.random.default_rng(5)
    time_s = np.arange(0.0, 20.0, 0.01)
    phase = 2 * np.pi * 0.8 * time_s[:, None] + np.array([0.0, 1.0, 2.0])
    com = 0.03 * np.sin(phase) + 0.002 * rng.standard_normal(phase.shape)
    late = 2 * np.pi * 0.8 * (time_s[:, None] - 0.08) + np.array([0.0, 1.0, 2.0])
    acceleration = -0.03 * (2 * np.pi * 0.8) ** 2 * np.sin(late)
    acceleration += 0.2 * rng.standard_normal(phase.shape)
    assert not check_acceleration(time_s, com, acceleration, G, "log")
    assert check_acceleration(time_s, com, acceleration / G, G, "log")
    # a robot that stands still shows nothing of its units
    still = 0.0005 * rng.standard_normal(phase.shape)
    assert not check_acceleration(time_s, still, 0.05 * rng.standard_normal(phase.shape), G, "log")


def test_streams_of_different_days() -> None:
    time_s = np.arange(0.0, 60.0, 0.01)
    assert not check_overlap(time_s, time_s + 1.0, "cells", "body")
    (finding,) = check_overlap(time_s, time_s + 86400.0 * 2, "cells", "body")
    assert "2 days" in finding.sentence or "1.999 days" in finding.sentence


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


def test_no_calibration_of_footcal_has_an_unknown_sign_convention() -> None:
    robot = Robot(name="A")
    own = [value for value in vars(calibration).values() if isinstance(value, Conventions)]
    assert len(own) > 4
    for conventions in own:
        record = ParametersRecord(
            command="x", created="", robot="A", gravity_mps2=robot.gravity_mps2,
            sign_convention=conventions.signs, frame="", expressed_at="", parameters={},
        )  # fmt: skip
        assert not list(inspect_record(record, robot, "p.json")), conventions.signs


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


@pytest.mark.parametrize(("looks", "degrees", "found"), [(0.15, False, 0), (0.15, True, 1),
                                                         (2.0, False, 0)])  # fmt: skip
def test_headings_lie_across_the_line_from_foot_to_foot(
    looks: float, degrees: bool, found: int
) -> None:
    """Steps of 5 cm with feet 10 cm apart turn that line by half a radian to either side."""
    step = 0.05 * np.sin(np.arange(200) / 7.0)
    ahead, aside = (np.array([np.cos(a), np.sin(a), 0.0]) for a in (looks, looks + np.pi / 2))
    left, right = (np.outer(s * step, ahead) + s * 0.05 * aside for s in (1.0, -1.0))
    yaw = np.full(200, np.degrees(looks) if degrees else looks)
    assert len(check_heading_across(yaw, left, right, "left_foot_yaw_rad")) == found


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
