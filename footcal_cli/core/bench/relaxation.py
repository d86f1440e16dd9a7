"""Creep seen in single holds: exponential approach to a level, whatever load made it.

``S_h(t) = level_h + Σ_j amplitude_hj exp(−(t − t_h)/τ_j)`` with time constants shared by all holds.
Neither the true loads nor what happened between the holds enters, so that hands on the rig and an
unknown past do not bias the time constants.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy import special

from footcal_cli.core.inference.separable import Separable
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet
from footcal_cli.errors import FitError

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
    scale
        Of the regression of load on these readings, shape (w,).
    change
        Relative change of the scale since the first waiting time, shape (w,).
    loads
        How many loads were held long enough for all of this.
    """

    wait_s: FloatArray
    scale: FloatArray
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
    rows = np.flatnonzero(hold >= 0)
    rows = rows[np.argsort(hold[rows], kind="stable")]
    holds = np.split(rows, np.flatnonzero(np.diff(hold[rows])) + 1) if rows.size else []
    lengths = np.array([np.ptp(time_s[held]) for held in holds])
    long = np.flatnonzero(lengths >= _SHORTEST_HOLD_S)
    loads = np.array([load_n[holds[i]].mean() for i in long])
    if np.unique(np.round(loads, 6)).size < 2:
        return None
    shortest = float(lengths[long].min())
    waits = [wait for wait in waits_s if wait < shortest - _AVERAGED_S] + [shortest - _AVERAGED_S]
    slopes = []
    for wait in waits:
        readings = [_reading_after(time_s[holds[i]], reading[holds[i]], wait) for i in long]
        slopes.append(np.polyfit(readings, loads, 1)[0])
    if level is not None and level.size == len(holds):
        waits.append(np.inf)
        slopes.append(np.polyfit(level[long], loads, 1)[0])
    scale = np.array(slopes)
    return Waiting(np.array(waits), scale, scale / scale[0] - 1.0, long.size)


def _reading_after(time_s: FloatArray, reading: FloatArray, wait_s: float) -> float:
    """Mean of the settled samples nearest to a waiting time after the load was put on."""
    distance = np.abs(time_s - time_s[0] - wait_s)
    return float(reading[distance <= max(_AVERAGED_S, float(distance.min()))].mean())


_GRID = 12
_APART = 0.7
_WIDEST_LOG = 50.0


@dataclass(frozen=True)
class Relaxation:
    """Time constants of creep and what is left to creep in each hold.

    Parameters
    ----------
    tau_s, tau_ci95_s
        Time constants ascending (k,) and their intervals (k, 2), symmetric in the logarithm.
    level, level_sd
        Reading after an infinite wait, shape (h,).
    amplitude, amplitude_sd
        Reading at the start of the hold minus `level`, per time constant, shape (h, k).
    correlation_s
        How long the scatter about the model persists.
    rmse
        Of the residual, in units of the reading.
    bic
        ``n ln(RSS/n) + p ln n`` of the whitened rows: compare numbers of time constants.
    resolved
        Whether each time constant lies inside the range that the holds can show, shape (k,).
    """

    tau_s: FloatArray
    tau_ci95_s: FloatArray
    level: FloatArray
    level_sd: FloatArray
    amplitude: FloatArray
    amplitude_sd: FloatArray
    correlation_s: float
    rmse: float
    bic: float
    resolved: tuple[bool, ...]


def fit_relaxation(
    time_s: FloatArray, reading: FloatArray, hold: IntArray, constants: int = 1
) -> Relaxation:
    """Fit shared time constants to the settled samples of several holds.

    Parameters
    ----------
    time_s, reading
        Shape (n,).
    hold
        Index of the hold (or load) of each sample, −1 for samples to leave out, shape (n,).
    constants
        Number of time constants, 1 or 2.

    Raises
    ------
    FitError
        Fewer than ten settled samples per coefficient.
    """
    used = hold >= 0
    t, y = time_s[used], reading[used]
    names, index = np.unique(hold[used], return_inverse=True)
    index = index.astype(np.int64)
    count = names.size * (1 + constants) + constants
    if t.size < 10 * count:
        raise FitError(f"{t.size} settled samples cannot carry {count} coefficients of creep")
    since = t - np.array([t[index == h].min() for h in range(names.size)])[index]
    longest = float(since.max())
    shortest = max(longest / 200.0, 2.0 * float(np.median(np.diff(t))))
    low, high = np.log([shortest, 2.0 * longest]).tolist()
    level = (index[:, None] == np.arange(names.size)).astype(float)

    def design(log_tau: FloatArray) -> FloatArray:
        return np.hstack(
            [level, *(level * np.exp(-since / tau)[:, None] for tau in np.exp(log_tau))]
        )

    grid = np.linspace(low, high, _GRID)
    times = tuple(
        Parameter(f"tau.{i}", "-", 0.5 * (low + high), lower=low, upper=high)
        for i in range(constants)
    )
    model = Separable(
        design=design,
        target=y,
        time_s=t,
        block=index,
        shapes=ParameterSet(times),
        starts=[np.array(point) for point in combinations(grid, constants)],
        ascending=range(constants),
        apart=_APART,
    )
    found = model.fit()
    log_tau, kept = found.log_shapes, found.linear.coefficients
    sd, quantile = np.sqrt(np.diag(found.covariance)), float(special.stdtrit(found.dof[0], 0.975))
    log_sd = sd[-constants:]
    tau = np.exp(log_tau)
    reach = np.exp(np.minimum(quantile * log_sd, _WIDEST_LOG))
    white = model.left(log_tau, found.correlation_s)
    raw = y - design(log_tau) @ kept
    shape = (constants, names.size)
    return Relaxation(
        tau_s=tau,
        tau_ci95_s=np.column_stack([tau / reach, tau * reach]),
        level=kept[: names.size],
        level_sd=sd[: names.size],
        amplitude=kept[names.size :].reshape(shape).T,
        amplitude_sd=sd[names.size : -constants].reshape(shape).T,
        correlation_s=found.correlation_s,
        rmse=float(np.sqrt(np.mean(raw**2))),
        bic=float(t.size * np.log(np.mean(white**2)) + count * np.log(t.size)),
        resolved=tuple(bool(shortest * 1.2 < v < 1.6 * longest) for v in tau),
    )
