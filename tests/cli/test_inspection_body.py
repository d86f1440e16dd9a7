"""A body stream against the recipe and against itself: units, frames, clocks, headings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.body_stream import (
    check_acceleration,
    check_heading,
    check_overlap,
    check_quaternions,
    check_saturation,
)
from footcal_cli.tables import columns
from footcal_cli.tables.table import Table, read_table
from tests.cli.inspected import SAMPLES, Frame, G, alarms, bent, clean, recipe, times


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


def test_a_robot_that_hangs_on_its_side_need_not_stand_upright() -> None:
    """Attitudes of a hanging robot: turned over, with a w that another order would take for up."""
    kind, robot = columns.hang_table(), recipe("hexapod").robot
    table = clean(SAMPLES / "hexapod/hang.parquet", kind, "hexapod")

    def turned_over(log: Frame) -> Frame:
        over = dict(zip("xyzw", (1.0, 0.0, 0.0, 0.0), strict=True))
        return log.assign(**{f"body_q{axis}": value for axis, value in over.items()})

    assert "quaternions_w_first" not in alarms(bent(table, turned_over), kind, robot)


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
    assert len(check_heading(np.arange(200) / 50, yaw, "left_foot_yaw_rad", (left, right))) == found


@pytest.mark.parametrize(("degrees", "found"), [(False, 0), (True, 1)])
def test_a_robot_may_walk_in_circles(degrees: bool, found: int) -> None:
    """Four turns in a minute are headings in radians, and the same ones in degrees are not."""
    time_s = np.arange(0.0, 60.0, 0.02)
    yaw = 8.0 * np.pi * time_s / 60.0
    left = 0.1 * np.column_stack([-np.sin(yaw), np.cos(yaw), 0.0 * yaw])
    written = np.degrees(yaw) if degrees else yaw
    assert len(check_heading(time_s, written, "left_foot_yaw_rad", (left, -left))) == found


def test_an_attitude_that_is_held_is_not_stuck(tmp_path: Path) -> None:
    """An arm's controller reports each pose to the digit; the forces of it scatter."""
    rng = np.random.default_rng(0)
    log = Frame(rng.normal(0, 0.1, (300, 6)), columns=[*columns.AXIS_COLUMNS])
    held = np.repeat(rng.uniform(-1.0, 1.0, (4, 3)), 75, axis=0)
    log = log.assign(leg="wrist", **dict(zip(columns.RPY, held.T, strict=True)))
    table = Table(log, tmp_path / "arm.csv", "")
    assert not alarms(table, columns.hang_table(), recipe("hexapod").robot)
    table = Table(log.assign(fx_n=log["fx_n"].where(log.index < 100, 0.1)), table.path, "")
    assert "stuck_channel" in alarms(table, columns.hang_table(), recipe("hexapod").robot)
