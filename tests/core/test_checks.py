"""What clean logs hold that looks like a broken law of `footcal_cli.core.checks`, and faults."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.checks.holes import check_holes
from footcal_cli.core.checks.legs import check_poses
from footcal_cli.core.checks.loads import check_exchanged
from footcal_cli.core.checks.streams import (
    check_feet_together,
    check_hum,
    check_zeros,
    check_zeros_in_order,
)
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.quality import Finding, check_stream
from footcal_cli.core.readings import check_glitches, resolution_of

WEIGHT_N = 60.0
TIME_S = np.arange(0.0, 60.0, 0.02)


def codes(findings: list[Finding]) -> set[str]:
    return {f.code for f in findings}


def test_load_that_moves_between_feet_of_unequal_gain_is_no_drift() -> None:
    """0.3 to 0.7 of the weight move from a foot that reads 8 % too much to one 6 % too little."""
    share = np.linspace(0.3, 0.7, TIME_S.size)
    noise = np.random.default_rng(0).normal(0.0, 0.05, (TIME_S.size, 2))
    feet = WEIGHT_N * np.column_stack([0.94 * share, 1.08 * (1.0 - share)]) + noise
    assert not check_feet_together(TIME_S, feet, ("left", "right"), WEIGHT_N)
    even = np.full_like(feet, WEIGHT_N / 2) + noise
    even[:, 0] += np.linspace(0.0, 0.05 * WEIGHT_N, TIME_S.size)
    assert codes(check_feet_together(TIME_S, even, ("left", "right"), WEIGHT_N)) == {
        "weight_drifts"
    }
    held = feet * np.where((TIME_S > 20) & (TIME_S < 26), 0.7, 1.0)[:, None]
    found = check_feet_together(TIME_S, held, ("left", "right"), WEIGHT_N)
    assert codes(found) == {"weight_not_constant"}
    assert "from 20 s" in found[0].sentence


@pytest.mark.parametrize("hand", [1.0, -1.0], ids=["right-handed", "left-handed"])
def test_offsets_and_hands_of_transducers_are_no_lost_weight(hand: float) -> None:
    """The sum of six offsets turns with the body; it may be more than the weight itself."""
    rng, names = np.random.default_rng(1), tuple("abcdef")
    turn = Rotation.from_euler("xyz", rng.uniform(-0.3, 0.3, (40, 3))).as_matrix()
    up, world = turn[:, 2, :], turn[:, :, 2]
    carries = rng.dirichlet(np.full(6, 5.0), 40)
    wrench = np.zeros((40, 6, 6))
    wrench[:, :, :3] = WEIGHT_N * carries[:, :, None] * up[:, None, :]
    wrench[:, :, 1] *= hand
    wrench[:, :, :3] += rng.normal(0.0, 0.7 * WEIGHT_N, (6, 3))
    stood = np.ones((40, 6), dtype=bool)
    assert not check_poses(names, wrench, stood, up, world, WEIGHT_N)
    wrench[[7, 20], 2, :3] -= 0.25 * WEIGHT_N * up[[7, 20]]
    found = check_poses(names, wrench, stood, up, world, WEIGHT_N)
    assert codes(found) == {"weight_not_constant"}
    assert "in 2 of 40 poses" in found[0].sentence


def test_harmonics_of_a_gait_are_no_hum() -> None:
    """Steps of 0.7 s put a comb of lines into the upper half of a slow log's spectrum."""
    rng, names = np.random.default_rng(2), [f"left_{c}" for c in "abcd"]
    time_s = np.arange(0.0, 60.0, 0.025)
    phase = (time_s / 1.4) % 1.0
    cells = np.column_stack([np.exp(-(((phase - at) / 0.04) ** 2)) for at in (0.1, 0.2, 0.3, 0.4)])
    cells += 0.001 * rng.standard_normal(cells.shape)
    cells[:, 3] = np.where(phase > 0.5, 0.5, cells[:, 3])  # one that jumps: harmonics of its own
    assert not check_hum(time_s, cells, names)
    cells[:, 1] += 0.05 * np.sin(2 * np.pi * 13.7 * time_s)
    found = check_hum(time_s, cells, names)
    assert [(f.code, f.where) for f in found] == [("hum", "left_b")]


def test_a_coarse_converter_rests_between_two_steps() -> None:
    """An axis that carries nothing takes one value, or two; a flicker of one step is no outlier."""
    rng, names = np.random.default_rng(3), ["fx", "fy", "fz", "tx", "ty", "tz"]
    wave = 3.0 * np.sin(np.arange(2000) / 90.0)[:, None]
    force = np.round(wave + rng.normal(0, 0.3, (2000, 6)))
    force[:, 1] = 0.0
    assert not check_stream(None, force, names)
    force[[50, 900], 1] = 1.0
    step = resolution_of(force)
    assert step == 1.0
    order = np.arange(2000.0)
    assert not check_glitches(force[:, 1], order, "fy", step)
    force[600:, 2] = force[600, 2]
    found = check_stream(None, force, names)
    assert [(f.code, f.where) for f in found] == [("stuck_channel", "fz")]
    assert "rows while" in found[0].sentence
    fine = force + 1e-4 * rng.standard_normal(force.shape)
    fine[:, 1] = 0.2
    assert ("stuck_channel", "fy") in {(f.code, f.where) for f in check_stream(None, fine, names)}
    # poses are few, and so are their values: none of a fine converter comes again
    poses = rng.normal(0, 3.0, (40, 6))
    poses[:, 2] = 1.3
    assert [(f.code, f.where) for f in check_stream(None, poses, names)] == [
        ("stuck_channel", "fz")
    ]
    assert not check_stream(None, np.where(np.arange(6) == 2, 1.0, np.round(poses)), names)
    force[1400, 1] = 6.0
    assert codes(check_glitches(force[:, 1], order, "fy", step)) == {"outliers"}


def _on_holes(rng: np.random.Generator) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """18 placements of five weights on four cells under a rigid plate, a little curved."""
    own = np.repeat(np.arange(18), 5)
    hole = rng.uniform(-0.05, 0.05, (18, 2))[own]
    load = np.tile([5.0, 10.0, 15.0, 20.0, 30.0], 18)
    cell = np.array([[0.06, 0.04], [0.06, -0.04], [-0.05, 0.04], [-0.05, -0.04]])
    share = 0.25 + hole @ np.linalg.pinv(cell) @ (np.eye(4) - 0.25)
    force = load[:, None] * share
    counts = (force + 0.002 * force**2) / 3e-5 + rng.normal(0.0, 300.0, force.shape)
    return own, counts, hole, load


def test_two_holes_written_for_each_other_are_named_and_no_others() -> None:
    cell = np.array([[0.06, 0.04], [0.06, -0.04], [-0.05, 0.04], [-0.05, -0.04]])
    names = tuple(f"hole {i}" for i in range(18))
    for seed in range(20):
        rng = np.random.default_rng(seed)
        own, counts, hole, load = _on_holes(rng)
        said = check_holes("left", names, own, counts, hole, load, cell)
        assert "holes_exchanged" not in {f.code for f in said}
        one, other = rng.choice(18, 2, replace=False)
        given = hole.copy()
        given[own == one], given[own == other] = hole[own == other], hole[own == one]
        (found,) = [
            f for f in check_holes("left", names, own, counts, given, load, cell)
            if f.code == "holes_exchanged"
        ]  # fmt: skip
        where = set(found.where.removeprefix("left ").split(", "))
        assert where == {f"hole {one}", f"hole {other}"}


@pytest.mark.slow
def test_readings_of_one_load_under_each_others_names_are_named() -> None:
    rng = np.random.default_rng(3)
    loads = np.tile([0.0, 1, 2, 5, 10, 20, 30, 20, 10, 5, 2, 1, 0], 3)
    part = np.repeat([0.0, 1, 2], 13)
    wrong = 0
    for _ in range(100):
        zero, scale = 8.3e6 + rng.normal(0, 3e3, 8), 3.4e-5 * (1 + rng.normal(0, 0.01, 8))
        read = {
            f"cell {i}": loads / scale[i] + zero[i] + rng.normal(0, 60.0, loads.size)
            for i in range(8)
        }
        cells = {name: (loads, counts, part) for name, counts in read.items()}
        wrong += bool(check_exchanged(cells))
        at = (loads == 20.0) & (part == 1.0)
        one, other = read["cell 2"].copy(), read["cell 5"].copy()
        one[at], other[at] = read["cell 5"][at], read["cell 2"][at]
        cells |= {"cell 2": (loads, one, part), "cell 5": (loads, other, part)}
        apart = abs(20.0 / scale[2] + zero[2] - 20.0 / scale[5] - zero[5])
        if apart > 3000.0:
            (found,) = check_exchanged(cells)
            assert found.where == "cell 2, cell 5"
    assert wrong == 0


def swings(zero_n: FloatArray, seconds: float = 60.0) -> tuple[FloatArray, np.ndarray]:
    """Two cells of a foot that swings for half of each second; the second one has this zero."""
    time_s = np.arange(0.0, seconds, 0.02)
    in_air = (time_s % 1.0 < 0.5)[:, None] & np.ones(2, dtype=bool)
    force = np.where(in_air, 0.0, 0.25 * WEIGHT_N) + np.random.default_rng(5).normal(
        0.0, 0.02, in_air.shape
    )
    force[:, 1] += np.interp(time_s, np.linspace(0.0, seconds, zero_n.size), zero_n)
    return force, in_air


@pytest.mark.parametrize(
    ("zero_n", "moved"),
    [
        (np.zeros(2), 0.0),
        (np.array([0.0, 0.0033 * WEIGHT_N]), 0.0),  # three quarters of it are less than 0.5 %
        (np.array([0.0, 0.02 * WEIGHT_N]), 0.015 * WEIGHT_N),
        (0.02 * WEIGHT_N * (1.0 - np.exp(-np.arange(0.0, 8.0))), None),
        (-0.02 * WEIGHT_N * (np.arange(61) > 30), -0.02 * WEIGHT_N),
        # back and forth from swing to swing: where it ends is chance
        (0.02 * WEIGHT_N * np.random.default_rng(6).normal(size=61), 0.0),
    ],
)
def test_a_zero_that_moves_shows_in_the_swings(zero_n: FloatArray, moved: float | None) -> None:
    """Means of the first and last quarter of a ramp are three quarters of its rise apart."""
    found = check_zeros(*swings(zero_n), ("left_a", "left_b"), WEIGHT_N)
    if moved == 0.0:
        assert not found
        return
    (one,) = found
    assert (one.code, one.where) == ("zero_moves", "left_b")
    if moved is not None:
        told = float(one.sentence.split(" reads ")[1].split(" N ")[0])
        assert told == pytest.approx(abs(moved), rel=0.05)
        assert ("more" if moved > 0 else "less") in one.sentence


def test_of_a_few_swings_no_zero_is_known() -> None:
    assert not check_zeros(*swings(np.array([0.0, 6.0]), 10.0), ("left_a", "left_b"), WEIGHT_N)


def test_a_zero_that_goes_one_way_between_rounds_is_said() -> None:
    rng = np.random.default_rng(4)
    names = [f"foot_{c}" for c in range(6)]
    zeros = rng.normal(0.0, 800.0, (7, 6))
    assert check_zeros_in_order(zeros, names) == []
    zeros[:, 1] += 18_000.0 * (1.0 - np.exp(-np.arange(7) / 4.0))
    assert [f.where for f in check_zeros_in_order(zeros, names)] == ["foot_1"]


def test_zeros_that_scatter_go_no_way_of_their_own() -> None:
    rng = np.random.default_rng(5)
    names = [f"foot_{c}" for c in range(6)]
    found = [check_zeros_in_order(rng.normal(0.0, 800.0, (5, 6)), names) for _ in range(300)]
    assert sum(map(bool, found)) <= 6
