"""What creep does to a scale: the same weights read after one waiting time and after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray

WAITS_S = (5.0, 15.0, 30.0, 60.0, 120.0, 300.0)
_SHORTEST_HOLD_S = 30.0
_AVERAGED_S = 2.0


@dataclass(frozen=True)
class Waiting:
    """The affine calibration that reading every load after a waiting time would give.

    Parameters
    ----------
    wait_s
        Between putting a load on and reading it; ``inf``: the level the creep tends to. Shape (w,).
    scale, bias_n
        Of the regression of load on these readings, shape (w,).
    change
        Relative change of the scale since the first waiting time, shape (w,).
    loads
        How many loads were held long enough for all of this.
    """

    wait_s: FloatArray
    scale: FloatArray
    bias_n: FloatArray
    change: FloatArray
    loads: int


def study_waiting(
    time_s: FloatArray,
    reading: FloatArray,
    load_n: FloatArray,
    hold: IntArray,
    level: FloatArray | None = None,
    waits_s: tuple[float, ...] = WAITS_S,
) -> Waiting | None:
    """Scales for several waiting times; None where fewer than two loads were held long enough.

    The same loads serve every waiting time: those held for half a minute or more, up to the end of
    the shortest of them.

    Parameters
    ----------
    time_s, reading, load_n
        Samples, shape (n,).
    hold
        Index of the load that was put on and left, −1 elsewhere, shape (n,).
    level
        Reading after an infinite wait of each hold in ascending order, shape (h,).
    waits_s
        Waiting times to compare.
    """
    holds = np.unique(hold[hold >= 0])
    lengths = np.array([np.ptp(time_s[hold == h]) for h in holds])
    long = np.flatnonzero(lengths >= _SHORTEST_HOLD_S)
    loads = np.array([load_n[hold == h].mean() for h in holds[long]])
    if np.unique(np.round(loads, 6)).size < 2:
        return None
    shortest = float(lengths[long].min())
    waits = [wait for wait in waits_s if wait < shortest - _AVERAGED_S] + [shortest - _AVERAGED_S]
    lines = []
    for wait in waits:
        readings = [_reading_after(time_s, reading, hold == holds[i], wait) for i in long]
        lines.append(np.polyfit(readings, loads, 1))
    if level is not None and level.size == holds.size:
        waits.append(np.inf)
        lines.append(np.polyfit(level[long], loads, 1))
    scale, bias = np.array(lines).T
    return Waiting(np.array(waits), scale, bias, scale / scale[0] - 1.0, long.size)


def _reading_after(
    time_s: FloatArray, reading: FloatArray, held: np.ndarray, wait_s: float
) -> float:
    """Mean of the settled samples nearest to a waiting time after the load was put on."""
    since, values = time_s[held] - time_s[held][0], reading[held]
    distance = np.abs(since - wait_s)
    return float(values[distance <= max(_AVERAGED_S, float(distance.min()))].mean())
