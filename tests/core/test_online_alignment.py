"""A body stream that is late by a lot, and a walk whose motion holds forces that never were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.log import Log
from footcal_cli.core.online.memory import (
    MemoryOptions,
    begun_delay_s,
    step_band_hz,
    walk_rows,
    within_band,
)
from footcal_cli.core.online.reference_states import advanced
from tests.core.walk_data import Errors, Recording, make_walk, record
from tests.core.walking import belief_of, walk_log


@pytest.fixture(scope="module")
def made() -> tuple[Recording, Log]:
    recording = record(make_walk(0.1, 20.0, seed=4), Errors(), seed=4)
    return recording, walk_log(recording)


@pytest.mark.parametrize("late_s", [0.083, -0.06, 0.0, 0.14])
def test_the_coarse_search_finds_a_delay_of_any_size(
    made: tuple[Recording, Log], late_s: float
) -> None:
    recording, log = made
    found = begun_delay_s(advanced(log, -late_s), belief_of(recording), MemoryOptions())
    assert abs(found - late_s) <= 0.016


def test_band_limited_rows_stay_exact_and_forget_what_is_above_the_step(
    made: tuple[Recording, Log],
) -> None:
    recording, log = made
    rows = walk_rows(log, belief_of(recording), MemoryOptions())
    band = step_band_hz(log)
    assert band == pytest.approx(2.4 / 1.2, rel=0.03)  # a step of 0.6 s, two to a cycle
    ripple = np.zeros_like(rows.error)
    ripple[:, 0] = np.sin(2.0 * np.pi * 2.5 * band * rows.time_s)
    bent, plain = (
        within_band(replace(rows, error=rows.error + ripple), band),
        within_band(rows, band),
    )
    used = plain.valid[:, 0]
    assert used.sum() > 50
    inner = used & (rows.time_s > 3.0) & (rows.time_s < 17.0)
    # Butterworth of order four, forth and back: 1 / (1 + 2.5⁸)
    assert np.abs(bent.error - plain.error)[inner, 0].max() < 2.0 / (1.0 + 2.5**8)
    assert np.abs(bent.error - plain.error)[used, 0].max() < 0.1
    # what a change of gains does to the filtered rows is what it does to the rows, filtered
    z = np.random.default_rng(1).normal(size=len(rows.names))
    moved = within_band(replace(rows, error=rows.error + rows.h @ z), band)
    expected = plain.error + plain.h @ z
    np.testing.assert_allclose(moved.error[used, :3], expected[used, :3], atol=1e-9)
    np.testing.assert_array_equal(plain.valid[:, 3:], rows.valid[:, 3:])
