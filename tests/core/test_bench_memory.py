"""What a cell remembers of one ladder of weights when the next begins."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.terms import hysteresis


@pytest.mark.parametrize(("pause_s", "kept"), [(20.0, True), (86_400.0, False)])
def test_a_loop_goes_on_into_a_ladder_that_follows_at_the_same_pace(
    pause_s: float, kept: bool
) -> None:
    ladder = np.array([0.0, 8.0, 16.0, 8.0, 0.0])
    load, n = np.tile(ladder, 2), len(ladder)
    time_s = 20.0 * np.arange(2 * n) + np.repeat([0.0, pause_s - 20.0], n)
    session = np.repeat([0, 1], n)
    record = BenchRecord("a", load, load.copy(), time_s, session)
    (term,) = hysteresis(16.0).terms
    shown = term.phi(load, record, np.array([2.0]))
    # a loop 1 N wide lies half of it below the load on the way up, above it on the way down
    first = 0.5 * np.array([0.0, -1.0, -1.0, 1.0, 1.0])
    np.testing.assert_allclose(shown[:n], first)
    second = np.r_[0.5 if kept else 0.0, first[1:]]
    np.testing.assert_allclose(shown[n:], second)
