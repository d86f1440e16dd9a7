"""Time of the online estimators over one walk; divide by its updates for the paper's 2.5 ms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.filter import Noise, run_filter
from footcal_cli.core.online.rows import cell_rows
from footcal_cli.core.online.window import Weights, run_window, run_window_fast
from tests.core.walk_data import Errors, make_walk, record
from tests.core.walking import belief_of, walk_log

ONE = Weights(4e4, 3e4, 3e3)
MANY = Weights(4e4, 3e4, np.geomspace(1.0, 1e6, 64))


@pytest.fixture(scope="module")
def walk() -> tuple[Log, Belief]:
    recording = record(make_walk(0.04, 20.0, seed=1), Errors(), seed=1)
    return walk_log(recording), belief_of(recording)


METHODS: dict[str, Callable[[Log, Belief], object]] = {
    "window": lambda log, belief: run_window(log, belief, ONE),
    "window by sliding sums": lambda log, belief: run_window_fast(log, belief, ONE),
    "window by sliding sums, 64 settings": lambda log, belief: run_window_fast(log, belief, MANY),
    "memory": lambda log, belief: run_filter(cell_rows(log, belief), Noise(swing_fixed_n=0.07)),
}


@pytest.mark.benchmark(group="20 s of walking")
@pytest.mark.parametrize("method", METHODS)
def test_online(benchmark: Any, walk: tuple[Log, Belief], method: str) -> None:
    benchmark.extra_info["updates"] = len(cell_rows(*walk))
    benchmark.pedantic(METHODS[method], args=walk, rounds=5, warmup_rounds=1)
