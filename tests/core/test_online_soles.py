"""Where soles stand: gains no surer than a walk's stances make them, and shifts of a known size."""

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.log import Log
from footcal_cli.core.online.filter import Guards, WalkNoise, run_filter
from footcal_cli.core.online.memory import within_band
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.soles import Soles
from footcal_cli.core.online.tuning import learn_noise

OPEN = Guards(huber=np.inf, least_gain_nats=-1.0, jump_threshold=np.inf)
STEP_S, STANCE, SWING = 0.05, 12, 8
SOLE_M, LOAD_N, ARM_M = 1e-3, 50.0, 0.03
NOISE = WalkNoise(
    force_n=0.1, moment_nm=1e-4, force_slow_n=1e-9, moment_slow_nm=1e-9, swing_n=0.1,
    swing_slow_n=0.0, gain_walk=1e-9, bias_walk_n=1e-9, sole_m=SOLE_M,
)  # fmt: skip


def walked(rng: np.random.Generator, cycles: int) -> tuple[Rows, float]:
    """One foot that stands and swings; its gain shows in the moment, where its sole errs.

    Rows and the true gain.
    """
    u = cycles * (STANCE + SWING)
    standing = np.arange(u) % (STANCE + SWING) < STANCE
    load = np.where(standing, LOAD_N, 0.0)
    gain = 0.05 * float(rng.normal())
    shift = SOLE_M * rng.normal(size=(cycles, 2))[np.arange(u) // (STANCE + SWING)]
    h, columns = np.zeros((u, 4, 1)), np.zeros((u, 3, 2))
    h[:, 1, 0] = ARM_M * load
    columns[:, 1, 1], columns[:, 2, 0] = load, -load
    error = -gain * h[:, :, 0]
    error[:, :3] -= np.einsum("ukm,um->uk", columns, shift)
    error[:, 1:3] += float(NOISE.moment_nm) * rng.normal(size=(u, 2))
    error[:, 0] += float(NOISE.force_n) * rng.normal(size=u)
    rows = Rows(
        STEP_S * np.arange(u, dtype=float), ("a.gain",), ("-",), np.array([0.05]), np.eye(1),
        ("fz", "mx", "my", "a"), 3, 0.05 * h, error,
        np.tile([True, True, True, False], (u, 1)), np.arange(u), np.ones(1),
        soles=Soles(columns, np.repeat(~standing[:, None], 2, axis=1)),
    )  # fmt: skip
    return rows, gain


def test_gain_is_known_as_well_as_its_stances_allow() -> None:
    """n stances give a gain to ``σ / (a √n)``, however many samples each of them has."""
    ratios = []
    for seed in range(400):
        rows, gain = walked(np.random.default_rng(seed), 25)
        value, sd = run_filter(rows, NOISE, OPEN).at_end("a.gain")
        expected = 1.0 / np.sqrt(25 * (ARM_M / SOLE_M) ** 2 + 0.05**-2)
        assert sd == pytest.approx(expected, rel=0.01)
        ratios.append((value - gain) / sd)
    assert 0.85 < np.sqrt(np.mean(np.square(ratios))) < 1.15


@pytest.mark.parametrize("rate_hz", [np.inf, 2.4])
def test_intervals_hold_with_learnt_shifts(rate_hz: float) -> None:
    """Learnt from the innovations, at all frequencies and below the steps' second harmonic."""
    ratios, sizes = [], []
    for seed in range(40):
        rows, gain = walked(np.random.default_rng(1000 + seed), 30)
        rows = within_band(rows, rate_hz)
        learnt = learn_noise(
            rows, replace(NOISE, sole_m=3e-3), learnt=("sole_m",), guards=OPEN
        ).noise
        sizes.append(float(learnt.sole_m))
        value, sd = run_smoother(rows, learnt, OPEN).at_end("a.gain")
        ratios.append((value - gain) / sd)
    assert np.median(sizes) == pytest.approx(SOLE_M, rel=0.15)
    assert 0.75 < np.sqrt(np.mean(np.square(ratios))) < 1.25


def test_noise_that_decays_is_too_sure() -> None:
    """The same errors taken for noise with a memory of a stance: why soles are states."""
    decaying = replace(
        NOISE, sole_m=1e-12, moment_slow_nm=SOLE_M * LOAD_N, moment_slow_s=STANCE * STEP_S
    )
    ratios = []
    for seed in range(100):
        rows, gain = walked(np.random.default_rng(seed), 25)
        value, sd = run_filter(rows, decaying, OPEN).at_end("a.gain")
        ratios.append((value - gain) / sd)
    assert np.sqrt(np.mean(np.square(ratios))) > 1.15


def test_compiled_loops_and_arrays_agree() -> None:
    rows, _ = walked(np.random.default_rng(3), 6)
    fast, slow = (run_filter(rows, NOISE, OPEN, fast=fast) for fast in (True, False))
    assert fast.values == pytest.approx(slow.values, rel=1e-8)
    assert fast.log_likelihood == pytest.approx(slow.log_likelihood)


def test_columns_are_the_moments_of_loads() -> None:
    """A foot under 40 N shifted by (dx, dy): moments 40 dy about x and −40 dx about y."""
    log = Log(
        time_s=np.linspace(0.0, 0.03, 4), channels=("left_a", "left_b", "right_a", "right_b"),
        readings=np.tile([10.0, 30.0, 0.0, 0.0], (4, 1)),
        known={"contact": np.tile([1.0, 0.0], (4, 1))}, experiment="walk",
        block=np.zeros(4, dtype=np.int64),
    )  # fmt: skip
    soles = Soles.of(log, 2)
    shift = np.array([1e-3, 2e-3, 5e-3, 5e-3])
    assert soles.columns @ shift == pytest.approx(np.tile([0.0, 0.08, -0.04], (2, 1)))
    assert soles.renewed.tolist() == [[False, False, True, True]] * 2
