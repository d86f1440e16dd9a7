"""Hysteresis against creep in laws that are not the table's: which kind of memory it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.parameters import FloatArray
from tests.blind import foreign
from tests.core.test_diagnosis_bridge import weights_case, with_rivals

MEMORY = {k: TABLE[k] for k in ("hysteresis", "creep", "creep_slow")}
LADDERS = {
    (0.0, 0.1, 0.25, 0.5, 1.0): (4, 20.0),
    (0.0, 0.3, 0.6, 1.0): (2, 20.0),
    tuple(np.linspace(0.0, 1.0, 9)): (3, 10.0),
    (0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0): (6, 5.0),
}
"""Shares of the largest load, up and down -> how often, and seconds a step."""
Law = Callable[[FloatArray, FloatArray], FloatArray]


def first(n: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    return np.asarray(np.arange(n) == 0)


def follower(x: FloatArray, time_s: FloatArray, tau_s: float) -> FloatArray:
    return np.asarray(foreign.slow_part(x[:, None], time_s, first(len(x)), tau_s)[:, 0])


def play(x: FloatArray, reach: float) -> FloatArray:
    z, out = 0.0, np.empty(len(x))
    for i, load in enumerate(x):
        z = min(max(z, load - reach), load + reach)
        out[i] = z
    return out - x


def loops(x: FloatArray) -> Iterator[FloatArray]:
    """Laws of loops: Bouc and Wen, Preisach, and Dahl with an exponent of two."""
    for yields in (0.1, 0.2, 0.4):
        yield foreign.bouc_wen(x[:, None], first(len(x)), 0.01, yields)[:, 0] - x
    yield foreign.preisach(x[:, None], first(len(x)), 0.01)[:, 0] - x
    for yields in (0.1, 0.27):
        z, out = 0.0, np.empty(len(x))
        for i, step in enumerate(np.diff(x, prepend=0.0) / 100):
            for _ in range(100):
                ahead = 1.0 - z * np.sign(step)
                z += step / yields * np.sign(ahead) * ahead**2
            out[i] = z
        yield -out


def creeps(x: FloatArray, time_s: FloatArray) -> Iterator[FloatArray]:
    """Laws of creep: two stages, logarithm, powers of time, of load, slower in recovery."""
    for fast in (10.0, 20.0):
        yield 0.4 * follower(x, time_s, fast) + 0.6 * follower(x, time_s, 10.0 * fast)
    since = np.maximum(time_s[:, None] - time_s, 0.0)
    for kernel in (np.log1p(since), np.log1p(since / 10.0), since**0.2, since**0.5):
        yield kernel @ np.diff(x, prepend=0.0)
    for power in (0.7, 1.5):
        yield follower(x**power, time_s, 30.0) + follower(x**power, time_s, 120.0)
    slow, out = 0.0, np.zeros(len(x))
    for i in range(1, len(x)):
        tau_s = 30.0 if x[i] > slow else 60.0
        slow = x[i] + (slow - x[i]) * np.exp(-(time_s[i] - time_s[i - 1]) / tau_s)
        out[i] = slow
    yield out


def test_by_how_much_the_wrong_kind_of_memory_leaves_more() -> None:
    """The figures that the factor of two is set by."""
    times = []
    for shares, (repeats, step_s) in LADDERS.items():
        x = np.tile([*shares, *shares[-2::-1]], repeats)
        time_s = step_s * np.arange(float(x.size))
        line = [np.ones_like(x), x]
        loop = [*line, *(play(x, r) for r in (0.05, 0.1, 0.2, 0.4, 0.8))]
        creep = [*line, *(follower(x, time_s, t) for t in (10, 30, 60, 120, 300, 600, 900, 1800))]

        def left(law: FloatArray, kind: list[FloatArray]) -> float:
            columns = np.stack(kind, axis=1)
            scale = np.maximum(np.sqrt(np.sum(columns**2, axis=0)), 1e-300)
            return float(np.sum(left_by(columns / scale, law, 1e-3) ** 2))

        times += [left(law, creep) / left(law, loop) for law in loops(x)]
        times += [left(law, loop) / left(law, creep) for law in creeps(x, time_s)]
    assert len(times) == 60
    assert min(times) > 0.5  # beyond twice the wrong kind never wins
    assert sum(t < 1.0 for t in times) == 5


def distorted(seed: int, law: Law) -> Case:
    """Weighed cells that show a law of their load and time, every session from rest."""
    case = weights_case(seed, None)
    logs = []
    for log in case.logs:
        scale = np.array([case.values[f"{c}.scale"] for c in log.channels])
        zero = np.array([case.values[f"{c}.bias"] for c in log.channels])
        force = log.readings * scale + zero
        for block in np.unique(log.block):
            rows = log.block == block
            loads = np.nan_to_num(log.known["load_n"][rows]).reshape(rows.sum(), -1)
            for c in range(loads.shape[1]):
                force[rows, c] += law(loads[:, c], log.time_s[rows])
        logs.append(log.with_readings((force - zero) / scale))
    return replace(case, logs=tuple(logs))


def test_a_foreign_loop_is_no_creep() -> None:
    def loop(x: FloatArray, time_s: FloatArray) -> FloatArray:
        return np.asarray(foreign.bouc_wen(x[:, None], first(len(x)), 0.6, 6.0)[:, 0] - x)

    assert with_rivals(investigate(distorted(3, loop), MEMORY, describe)) == {"hysteresis"}


@pytest.mark.slow
def test_a_creep_of_two_stages_is_no_loop() -> None:
    def creep(x: FloatArray, time_s: FloatArray) -> FloatArray:
        return 0.02 * (0.4 * follower(x, time_s, 15.0) + 0.6 * follower(x, time_s, 120.0))

    named = with_rivals(investigate(distorted(4, creep), MEMORY, describe))
    assert named & {"creep", "creep_slow"}
    assert "hysteresis" not in named
