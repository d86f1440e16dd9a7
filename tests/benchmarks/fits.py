"""How long the fits of six-axis transducers take, readings at hand, against the paper's own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.pose.data import summarise
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.study.stepwise import fit_stepwise
from tests.core.pose_cases import case
from tests.core.six_axis_data import hang

_LEGS, _ROWS = 6, 10_000
_MOST_ROUNDS = 30


def fitted(rounds: int) -> Iterator[tuple[str, list[float]]]:
    """Name and CPU seconds of each round, after one to warm up."""
    logs = [
        hang(np.random.default_rng(leg), leg, rows=_ROWS, rate_hz=50.0).logs for leg in range(_LEGS)
    ]
    one = case(1, friction_n=3.0)
    runs: dict[str, Callable[[], object]] = {
        "24 hangings of 10,000 samples, joint": lambda: [fit_hang(log) for log in logs],
        "24 hangings of 10,000 samples, stepwise as printed": lambda: [
            fit_stepwise(log) for log in logs
        ],
        f"{len(one.data)} standing poses, joint": lambda: fit_pose(
            summarise(one.data), one.legs, one.noise_sd
        ),
    }
    for name, run in runs.items():
        run()
        times = []
        for _ in range(min(4 * rounds, _MOST_ROUNDS)):
            began = time.process_time()
            run()
            times.append(time.process_time() - began)
        yield name, times


def lines_of_fits(results: list[tuple[str, list[float]]]) -> list[str]:
    """The table of the page: the least of the rounds says most where other jobs run."""
    rows = [
        "## Fits of six-axis transducers",
        "| | CPU ms, least | to | rounds |",
        "|---|---|---|---|",
    ]
    for name, times in results:
        low, high = 1e3 * min(times), 1e3 * max(times)
        rows.append(f"| {name} | {low:.3g} | {high:.3g} | {len(times)} |")
    return [*rows, ""]
