"""How long the exact inverse of a memory effect takes on an hour of eight cells at 80 Hz."""

from __future__ import annotations

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from footcal_cli.core.effects import TABLE
from footcal_cli.core.log import Log

CELLS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))
ROWS = 3600 * 80


def test_an_hour_of_hysteresis_and_its_inverse(benchmark: BenchmarkFixture) -> None:
    time_s = np.arange(ROWS) / 80.0
    load = 20.0 + 20.0 * np.sin(np.pi * time_s)[:, None] + np.zeros(len(CELLS))
    log = Log("walk", CELLS, time_s, load, {}, np.zeros(ROWS, int))
    theta = {"hysteresis_width": np.full(8, 0.5), "hysteresis_reach": np.full(8, 8.0)}

    def there_and_back() -> Log:
        distorted, _ = TABLE["hysteresis"].apply(log, theta, None)
        return TABLE["hysteresis"].remove(distorted, theta, None)[0]

    restored = benchmark(there_and_back)
    np.testing.assert_allclose(restored.readings, load, atol=1e-12)
