"""Cycles in which an estimator said nothing are rows that were not logged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.streams import BodyStream, SensorStream


def _streams(skipped: np.ndarray) -> tuple[SensorStream, BodyStream]:
    time_s = np.arange(1000) / 100.0
    swing = np.sin(2.0 * np.pi * 0.5 * time_s)
    com = np.stack([0.02 * swing, 0.05 * swing, 0.6 + 0.0 * swing], axis=1)
    feet = np.tile([[[0.0, 0.1, 0.0], [0.0, -0.1, 0.0]]], (time_s.size, 1, 1))
    yaw = np.stack([0.1 * swing, 0.1 * swing], axis=1)
    body = BodyStream(time_s, com, np.full((time_s.size, 3), np.nan), np.zeros((time_s.size, 2)),
                      feet, yaw)  # fmt: skip
    for values in (body.com_m, body.angmom_rate_nm, body.feet_m, body.feet_yaw_rad):
        values[skipped] = np.nan
    load = np.full((time_s.size, 4), 75.0)
    return SensorStream(time_s, load, ("a_1", "a_2", "b_1", "b_2")), body


def test_a_skipped_cycle_spoils_no_other() -> None:
    skipped = np.array([100, 350, 351, 700])
    sensors, body = _streams(skipped)
    known = np.diag(np.repeat([0.01, 0.3], 4) ** 2)
    belief = Belief(sensors.channels, np.ones(4), np.zeros(4), known)
    cells = (np.array([[0.1, 0.0], [-0.1, 0.0]]),) * 2
    whole = merge_cells(*_streams(np.array([], dtype=int)), belief, cells, 30.0, 9.81)
    merged = merge_cells(sensors, body.without_skipped(), belief, cells, 30.0, 9.81)
    assert np.isfinite(merged.log.readings).all(axis=1).mean() > 0.99
    for name in ("com_m", "cell_pos_m"):
        far = np.abs(merged.log.known[name] - whole.log.known[name])
        assert np.nanmax(far) < 1e-3  # a line over 20 ms of a sway of half a hertz


def test_a_robot_that_says_nothing_of_its_com_keeps_its_rows() -> None:
    _, body = _streams(np.array([], dtype=int))
    mute = replace(body, com_m=np.full_like(body.com_m, np.nan))
    assert mute.without_skipped() is mute


def test_an_angular_momentum_gives_its_rate() -> None:
    sensors, body = _streams(np.array([], dtype=int))
    known = np.diag(np.repeat([0.01, 0.3], 4) ** 2)
    belief = Belief(sensors.channels, np.ones(4), np.zeros(4), known)
    cells = (np.array([[0.1, 0.0], [-0.1, 0.0]]),) * 2
    turn = 2.0 * np.pi * 0.5 * body.time_s
    momentum = np.stack([3.0 * np.sin(turn), -2.0 * np.cos(turn)], axis=1)
    rate = np.pi * np.stack([3.0 * np.cos(turn), 2.0 * np.sin(turn)], axis=1)
    given = merge_cells(sensors, replace(body, angmom_rate_nm=rate), belief, cells, 30.0, 9.81)
    taken = merge_cells(sensors, replace(body, angmom_nms=momentum), belief, cells, 30.0, 9.81)
    inner = slice(50, -50)
    apart = given.log.known["angmom_rate_nm"] - taken.log.known["angmom_rate_nm"]
    assert np.nanmax(np.abs(apart[inner])) < 0.01


def test_zeros_that_nobody_tared_are_as_unsure_as_cells_in_the_air_show() -> None:
    known = np.diag(np.repeat([0.01, 0.3], 4) ** 2)
    belief = Belief(("a", "b", "c", "d"), np.ones(4), np.zeros(4), known)
    up = np.arange(1000) % 4 == 0
    forces = np.where(up[:, None], 0.0, 75.0) + np.array([3.8, 0.2, -4.0, 0.0])
    found = belief.with_zeros_in_the_air(forces)
    assert found.bias_sd_n[[1, 3]] == pytest.approx(0.3)
    assert found.bias_sd_n[[0, 2]] == pytest.approx(np.hypot(0.3, [3.8, 4.0]))
    assert found.gain_sd == pytest.approx(0.01)
