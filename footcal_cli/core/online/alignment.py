"""How late the body stream is: a coarse search first, then a delay that is estimated along.

The estimated delay is linearised; 60 ms off, a swinging leg is already in another phase and the
linear step stops halfway. The likelihood over ± 150 ms has one sharp maximum.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.filter import Guards, WalkNoise, run_filter
from footcal_cli.core.online.reference_states import advanced
from footcal_cli.core.online.rows import Rows

LARGEST_DELAY_S = 0.15
_STEP_S = 0.015
_SEARCHED_S = 30.0
"""So much of a recording is searched."""
_NEAR = 1
"""Steps from none within which the estimated delay needs no help."""
_SURE_NATS = 50.0
_FEWEST = 3


_SETTLED_S = 2e-4


def aligned(
    log: Log, rows_of: Callable[[Log, float], Rows], state: str, noise: WalkNoise, guards: Guards,
    passes: int,
) -> tuple[float, Log, Rows]:  # fmt: skip
    """The delay, searched and then estimated until it settles; the log moved by it, and its rows.

    Parameters
    ----------
    log, state
        As `coarse_delay_s`.
    rows_of
        The rows of a log that was moved by so much, s.
    passes
        Of the filter, at most.
    """
    delay = coarse_delay_s(log, lambda late: rows_of(late, 0.0), state, noise, guards)
    moved = advanced(log, delay)
    rows = rows_of(moved, 0.0)
    for _ in range(passes):
        step, _ = run_filter(rows, noise, guards).at_end(state)
        delay += step
        moved = advanced(log, delay)
        rows = rows_of(moved, delay)
        if abs(step) < _SETTLED_S:
            break
    return delay, moved, rows


def coarse_delay_s(
    log: Log, rows_of: Callable[[Log], Rows], state: str, noise: WalkNoise, guards: Guards
) -> float:
    """The delay of highest likelihood on a grid over ± `LARGEST_DELAY_S`; 0 where none is better.

    Parameters
    ----------
    log
        Its body stream as it came.
    state
        Name of the delay among the unknowns; it is left out of every trial.
    """
    stop = int(np.searchsorted(log.time_s, log.time_s[0] + _SEARCHED_S))
    if stop < _FEWEST:  # stamps so large, or so far apart, that no delay is found
        return 0.0
    begun = log.rows(0, stop)

    def likelihood(delay_s: float) -> float:
        rows = rows_of(advanced(begun, delay_s))
        rest = rows.without(np.array([name == state for name in rows.names]))
        return float(run_filter(rest, noise, guards.without_jumps()).log_likelihood)

    steps = round(LARGEST_DELAY_S / _STEP_S)
    delays = _STEP_S * np.arange(-steps, steps + 1)
    found = np.array([likelihood(float(delay)) for delay in delays])
    best = int(np.argmax(found))
    if abs(best - steps) <= _NEAR or found[best] - found[steps] < _SURE_NATS:
        return 0.0
    return float(delays[best])
