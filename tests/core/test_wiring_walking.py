"""Cells of a walk that are exchanged, copied or frozen, in steps written down by hand."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.wiring import (
    check_channels_walking,
    check_exchanged_feet,
    check_exchanged_walking,
    check_turned_balanced,
)

NAMES = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))
WEIGHT_N, RATE_HZ, SECONDS = 60.0, 50.0, 30.0
CELL_M = np.array([[0.07, 0.03], [0.07, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
FEET_M = np.array([[0.0, 0.08], [0.0, -0.08]])


def steps(seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stamps, forces and arms about the CoP: feet carry in turn, the CoP rolls from heel to toe."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    forces, spots = [], []
    for foot in range(2):
        phase = 2 * np.pi * time_s + np.pi * foot
        share = np.clip(0.5 + 1.5 * np.sin(phase), 0.0, 1.0)
        roll = 0.4 * np.sin(phase + 1.0) + 0.05 * rng.standard_normal(time_s.size)
        lean = 0.3 * np.cos(1.3 * phase)
        part = 0.25 * np.stack(
            [(1 + a * roll) * (1 + b * lean) for a in (1, -1) for b in (1, -1)], axis=1
        )
        forces.append(WEIGHT_N * share[:, None] * part)
        spots.append(np.broadcast_to(FEET_M[foot] + CELL_M, (time_s.size, 4, 2)))
    force, spot = np.hstack(forces), np.concatenate(spots, axis=1)
    cop = np.einsum("nc,nck->nk", force, spot) / force.sum(axis=1, keepdims=True)
    return time_s, force + 0.1 * rng.standard_normal(force.shape), spot - cop[:, None]


def test_cells_in_order_are_left_alone() -> None:
    for seed in range(5):
        time_s, forces, arms = steps(seed)
        total = forces.sum(axis=1)
        assert not check_channels_walking(time_s, forces, NAMES)
        assert not check_exchanged_walking(forces, NAMES, arms, total)


def test_a_cell_of_turned_sign_is_found_and_no_other_fault_is_one() -> None:
    for seed, cell in enumerate([0, 3, 5]):
        _, forces, arms = steps(seed)
        total = forces.sum(axis=1)
        assert not check_turned_balanced(forces, NAMES, arms, total)
        turned = np.where(np.arange(8) == cell, 3.0 - forces, forces)
        (finding,) = check_turned_balanced(turned, NAMES, arms, total)
        assert (finding.code, finding.severity, finding.where) == (
            "turned_sign", "alarm", NAMES[cell],
        )  # fmt: skip
        for factor in (0.0, 0.5, 1.5):  # dead, or of another gain
            other = np.where(np.arange(8) == cell, factor * forces, forces)
            assert not check_turned_balanced(other, NAMES, arms, total)
        order = np.arange(8)
        order[[cell, 7]] = 7, cell
        assert not check_turned_balanced(forces[:, order], NAMES, arms, total)


def test_exchanged_cells_are_found() -> None:
    for seed, (a, b) in enumerate([(0, 1), (0, 7), (5, 6)]):
        _, forces, arms = steps(seed)
        order = np.arange(8)
        order[[a, b]] = b, a
        (finding,) = check_exchanged_walking(forces[:, order], NAMES, arms, forces.sum(axis=1))
        assert finding.severity == "alarm"
        assert set(finding.where.split(", ")) == {NAMES[a], NAMES[b]}


def test_a_copied_cell_is_found_with_a_gain_an_offset_and_noise_of_its_own() -> None:
    time_s, forces, _ = steps(1)
    rng = np.random.default_rng(2)
    forces[:, 5] = 1.3 * forces[:, 2] - 4.0 + 0.1 * rng.standard_normal(time_s.size)
    (finding,) = check_channels_walking(time_s, forces, NAMES)
    assert (finding.code, finding.where) == ("duplicate_channel", "left_rl, right_fr")


def test_cells_in_the_middle_of_two_feet_are_no_copies() -> None:
    """Each bears a fifth of its foot's load, so that what one gains the other loses."""
    rng = np.random.default_rng(4)
    for seed in range(5):
        time_s, forces, _ = steps(seed)
        middle = 0.25 * np.stack([forces[:, :4].sum(axis=1), forces[:, 4:].sum(axis=1)], axis=1)
        middle += 0.05 * rng.standard_normal(middle.shape)
        names = (*NAMES, "left_mid", "right_mid")
        assert not check_channels_walking(time_s, np.hstack([forces, middle]), names)


def test_a_frozen_cell_is_found_though_its_offset_drifts() -> None:
    time_s, forces, _ = steps(1)
    late = time_s > 10.0
    forces[late, 3] = 5.0 + 0.02 * (time_s[late] - 10.0)
    (finding,) = check_channels_walking(time_s, forces, NAMES)
    assert (finding.code, finding.where) == ("stuck_channel", "left_rr")


def test_a_cell_that_never_bears_anything_is_not_called_stuck() -> None:
    time_s, forces, _ = steps(1)
    forces[:, 3] = 0.1 * np.random.default_rng(3).standard_normal(time_s.size)
    assert not check_channels_walking(time_s, forces, NAMES)


def test_feet_that_carry_each_other_s_load_are_exchanged() -> None:
    """Any zero and noise; feet in order, a robot that stands, and one load for both are none."""
    rng = np.random.default_rng(11)
    time_s = np.arange(0.0, 20.0, 0.01)
    swings = np.stack([(time_s / 1.2 + half) % 1.0 < 0.38 for half in (0.0, 0.5)], axis=1)
    load = 300.0 * (1.0 - swings) / np.sum(1.0 - swings, axis=1)[:, None]
    load = load + np.array([40.0, -25.0]) + rng.normal(0.0, 3.0, load.shape)
    speed: FloatArray = np.abs(0.9 * swings + rng.normal(0.0, 0.02, swings.shape))
    found = check_exchanged_feet(load[:, ::-1], speed, ("left", "right"))
    assert [f.code for f in found] == ["exchanged_channels"]
    assert check_exchanged_feet(load, speed, ("left", "right")) == []
    still: FloatArray = np.abs(rng.normal(0.0, 0.002, swings.shape))
    assert check_exchanged_feet(load[:, ::-1], still, ("left", "right")) == []
    late = np.roll(speed, 12, axis=0)  # 120 ms, as an estimator may be
    assert check_exchanged_feet(load, late, ("left", "right")) == []
