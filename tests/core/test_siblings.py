"""Dead channels of feet whose converters have 16 and 24 bits side by side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from footcal_cli.core.checks.siblings import check_dead_channels
from footcal_cli.core.parameters import FloatArray

NAMES = ("fl", "fr", "rl", "rr")
CELLS = np.array([[0.07, 0.03], [0.07, -0.03], [-0.03, 0.03], [-0.03, -0.03]])
PER_N = 3e4
"""Counts of 24 bits."""
Log = Callable[[np.random.Generator], tuple[FloatArray, FloatArray | None]]
Fault = Callable[[FloatArray, float, np.random.Generator], FloatArray]


def shares(load_n: FloatArray, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Forces (n, 4) of cells below a plate: linear in the load's position, their sum the load."""
    centre = CELLS.mean(axis=0)
    away = CELLS - centre
    arms = np.column_stack([x_m, y_m]) - centre
    share = 0.25 + arms @ (away / (away**2).sum(axis=0)).T
    return np.asarray(load_n[:, None] * share)


def walking(_: np.random.Generator) -> tuple[FloatArray, None]:
    t = np.arange(0.0, 20.0, 0.0125)
    stance = np.clip(1.5 * np.sin(2 * np.pi * t / 1.2), 0.0, 1.0)
    along = 0.02 + 0.04 * np.sin(2 * np.pi * t / 1.2 - 1.0)
    return shares(50.0 * stance, along, 0.01 * np.sin(2 * np.pi * t / 2.4)), None


def standing(rng: np.random.Generator) -> tuple[FloatArray, None]:
    t = np.arange(0.0, 30.0, 0.0125)
    x, y = (0.01 * np.sin(2 * np.pi * f * t + rng.uniform(0.0, 6.0)) for f in (0.31, 0.23))
    return shares(np.full(t.size, 26.0), 0.02 + x, 0.5 * y), None


def placed(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    holes = [(x, y) for x in (-0.02, 0.02, 0.06) for y in (-0.02, 0.0, 0.02)]
    rows = np.array([(load, x, y) for load in (0.0, 5.0, 10.0, 15.0, 20.0) for x, y in holes])
    rng.shuffle(rows)
    return shares(*rows.T), rows[:, :1] * np.column_stack([np.ones(len(rows)), rows[:, 1:]])


def converted(force_n: FloatArray, bits: list[int], rng: np.random.Generator) -> FloatArray:
    """Counts of cells by the bits of each one's converter; noise as of one kind of bridge."""
    gain = PER_N * 2.0 ** (np.array(bits) - 24) * rng.uniform(0.9, 1.1, 4)
    noise = rng.uniform(1e-3, 5e-3) * rng.standard_normal(force_n.shape)
    return np.asarray(np.round(gain * (force_n + rng.uniform(-20.0, 20.0, 4) + noise)))


def still(counts: FloatArray, noise: float, rng: np.random.Generator) -> FloatArray:
    return np.full(len(counts), counts[0])


def rustling(counts: FloatArray, noise: float, rng: np.random.Generator) -> FloatArray:
    return np.asarray(np.round(counts[0] + noise * rng.standard_normal(len(counts))))


def drifting(counts: FloatArray, noise: float, rng: np.random.Generator) -> FloatArray:
    drift = np.linspace(0.0, 0.01 * np.ptp(counts), len(counts))
    return np.asarray(np.round(rustling(counts, noise, rng) + drift))


def overhearing(counts: FloatArray, noise: float, rng: np.random.Generator) -> FloatArray:
    return np.asarray(np.round(rustling(counts, noise, rng) + 1e-3 * (counts - counts[0])))


LOGS = pytest.mark.parametrize("log", [walking, standing, placed])
FEET = pytest.mark.parametrize("bits", [[24] * 4, [16, 24, 24, 24], [16, 24, 24, 16],
                                        [24, 16, 16, 16], [16] * 4])  # fmt: skip


def dead(counts: FloatArray, known: FloatArray | None) -> set[str]:
    return {f.where for f in check_dead_channels(counts, NAMES, known)}


@LOGS
@FEET
def test_live_channels_are_not_called_dead(log: Log, bits: list[int]) -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        force, known = log(rng)
        assert not dead(converted(force, bits, rng), known), seed


@LOGS
@FEET
@pytest.mark.parametrize("fault", [still, rustling, drifting, overhearing])
def test_a_dead_channel_is_found_among_live_ones(log: Log, bits: list[int], fault: Fault) -> None:
    """With what it hears of others but for the finer one of coarse ones: that is a load's size."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        force, known = log(rng)
        counts = converted(force, bits, rng)
        i = int(rng.integers(4))
        if fault is overhearing and bits[i] > np.median(np.delete(bits, i)):
            continue
        noise = 100.0 if bits[i] == 24 else 0.7
        counts[:, i] = fault(counts[:, i], noise, rng)
        assert dead(counts, known) == {NAMES[i]}, seed


def test_a_dead_cell_as_noisy_as_its_neighbours_is_found() -> None:
    """Cells of an insole rustle by 1 N; the others carry 200 N at every step, this one nothing."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        phase = 2.0 * np.pi * np.arange(4000) / 110.0
        steps = np.maximum(np.sin(phase), 0.0)[:, None] * rng.uniform(100.0, 300.0, 4)
        steps[:, 2] = 0.0
        counts = np.round(20.0 * (steps + rng.normal(0.0, 1.0, steps.shape)))
        assert dead(counts, None) == {NAMES[2]}, seed


def test_a_live_cell_that_carries_nothing_while_others_sway_is_not_dead() -> None:
    """A stiff plate may stand on three of its four cells; noise says nothing of the fourth."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        force, _ = standing(rng)
        force[:, 2] = 0.0
        force *= 0.02
        assert not dead(converted(force, [24] * 4, rng), None), seed
