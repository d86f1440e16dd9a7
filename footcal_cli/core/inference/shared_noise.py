"""Noise of bench readings, one law for all channels of a bench.

A reading errs by what is fresh, by what drifts slowly through the whole bench day, by what a
re-seating changes, and by what the weight itself weighs wrongly:

    C = σ² (I + s₀ J + s₁ xxᵀ∘J + w xxᵀ∘L + r exp(−|t − t'| / T)),

J and L one for rows of one session and of one load, x the load over its root mean square. One
channel of a few sessions hardly shows these variances; cells of one make under one rig share them
nearly, so the ratios to σ² are those of the highest restricted likelihood (Patterson and Thompson
1971) of all channels together, and those of a channel may differ from them by a factor near two.
The uncertainty of the variances enters the degrees of freedom of an interval (Satterthwaite).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

from footcal_cli.core.parameters import FloatArray, IntArray

_EXPECTED = np.log([0.1, 0.02, 0.005, 0.5])
_EXPECTED_SD = 2.0
"""Log ratios s₀, s₁, w, r before anything is seen, each within a factor of seven."""
_MEMORY_SD = 1.5
_OWN_SD = np.array([0.5, 0.5, 0.5, 0.5, 0.2])
"""By how much a channel's logarithms may differ from those of all channels."""
_SURELY = 6.0
"""Twice the log likelihood that noise which lasts must gain where rows could be independent."""
_NONE = -30.0
"""Logarithm of a ratio that is nothing."""
_ALL = float(np.log(1e4))
"""Logarithm of the largest ratio: what is fresh in a reading is never less than a hundredth of the
rest, though a converter may be so coarse that every reading of a load gives one code."""
_STEP = 0.2
_EVALUATIONS = 250
_OUTSIDE = 0.05
_FEWEST_FREEDOM, _MOST_FREEDOM = 0.3, 1000.0
_WIDEST = 1e3
"""Interval in units of the sd, beyond which it says nothing."""

Law = FloatArray
"""Logarithms of s₀, s₁, w, r and T (s), shape (5,)."""


@dataclass(frozen=True)
class Regression:
    """One channel's regression and the pieces of its covariance.

    Parameters
    ----------
    design, target
        X of full rank and y, shape (m, p) and (m,), in order of time.
    parts
        J, xxᵀ∘J and xxᵀ∘L, shape (3, m, m).
    apart_s
        ``|t − t'|``, shape (m, m); infinite between different rows without a clock.
    load_rms_n
        Root mean square load.
    """

    design: FloatArray
    target: FloatArray
    parts: FloatArray
    apart_s: FloatArray
    load_rms_n: float

    @classmethod
    def of(
        cls,
        design: FloatArray,
        target: FloatArray,
        load_n: FloatArray,
        session: IntArray,
        level: IntArray,
        time_s: FloatArray | None,
    ) -> Regression:
        """Rows of known load; `level` numbers the distinct loads, no clock where time is None."""
        same = (session[:, None] == session).astype(np.float64)
        rms = max(float(np.sqrt(np.mean(load_n**2))), 1e-300)
        product = np.outer(load_n, load_n) / rms**2
        parts = np.stack([same, product * same, product * (level[:, None] == level)])
        apart = np.where(np.eye(load_n.size) > 0, 0.0, np.inf)
        if time_s is not None:
            apart = np.abs(time_s[:, None] - time_s)
        return cls(design, target, parts, apart, rms)

    def covariance(self, law: Law) -> FloatArray:
        """``C / σ²``, shape (m, m)."""
        *ratios, memory = np.exp(np.append(np.minimum(law[:-1], _ALL), law[-1]))
        slow = ratios[3] * np.exp(-self.apart_s / memory)
        return np.asarray(np.eye(self.target.size) + np.tensordot(ratios[:3], self.parts, 1) + slow)

    def whitened(self, law: Law) -> tuple[FloatArray, float]:
        """Design and target under unit noise, shape (m, p + 1), and ``log det C / σ²``."""
        root = np.linalg.cholesky(self.covariance(law))
        both = np.column_stack([self.design, self.target])
        return np.asarray(np.linalg.solve(root, both)), 2.0 * float(np.log(np.diag(root)).sum())

    def deviance(self, law: Law) -> float:
        """−2 log restricted likelihood, σ² profiled out."""
        white, log_det = self.whitened(law)
        corner = np.abs(np.diag(np.linalg.qr(white, mode="r")))
        freedom = self.target.size - self.design.shape[1]
        logs = np.log(np.maximum(corner, 1e-300))
        return float(log_det + 2.0 * freedom * logs[-1] + 2.0 * logs[:-1].sum())

    def solve(self, law: Law) -> tuple[FloatArray, FloatArray, float]:
        """Generalised least squares: β, its covariance and σ²."""
        white, _ = self.whitened(law)
        size = np.maximum(np.linalg.norm(white[:, :-1], axis=0), 1e-300)
        scaled = white[:, :-1] / size
        inverse = np.linalg.pinv(scaled.T @ scaled, hermitian=True)
        found = inverse @ (scaled.T @ white[:, -1])
        rest = white[:, -1] - scaled @ found
        variance = float(rest @ rest) / max(self.target.size - size.size, 1)
        return found / size, variance * inverse / np.outer(size, size), variance


@dataclass(frozen=True)
class Common:
    """What all channels of a bench say about the law of one of them.

    Parameters
    ----------
    law, covariance
        Logarithms, shape (5,), and how a channel's own may differ from them, shape (5, 5).
    lasting
        Whether readings surely depend on one another.
    """

    law: Law
    covariance: FloatArray
    lasting: bool


def common_law(channels: Sequence[Regression]) -> Common:
    """The law of the highest restricted likelihood of all channels together."""
    expected, sd = _expected(channels), np.array([_EXPECTED_SD] * 4 + [_MEMORY_SD])

    def cost(law: Law) -> float:
        surprise = float(np.sum(((law - expected) / sd) ** 2))
        return sum(channel.deviance(law) for channel in channels) + surprise

    law = _lowest(cost, expected)
    alone = np.full(law.size, _NONE)
    gained = sum(channel.deviance(alone) - channel.deviance(law) for channel in channels)
    if len(channels) == 1:  # the same readings must not count twice
        return Common(expected, np.diag(sd**2), gained > _SURELY)
    return Common(law, np.diag(_OWN_SD**2) + _spread(cost, law), gained > _SURELY)


@dataclass(frozen=True)
class SharedFit:
    """A channel's regression under its own law, near the common one.

    Parameters
    ----------
    coefficients, covariance
        Shape (p,) and (p, p).
    dof
        Degrees of freedom of Student's intervals, shape (p,).
    variance
        σ², of what is fresh in a reading.
    """

    coefficients: FloatArray
    covariance: FloatArray
    dof: FloatArray
    variance: float


def law_under(rows: Regression, common: Common) -> Law:
    """A channel's own law, near the common one."""
    return _lowest(_cost(rows, common), common.law)


def fit_under(rows: Regression, common: Common, law: Law) -> SharedFit:
    """Generalised least squares.

    Parameters
    ----------
    common, law
        From `common_law` and `law_under`.
    """
    found, covariance, variance = rows.solve(law)
    dof = _freedom(rows, _cost(rows, common), law)
    return SharedFit(found, covariance, dof, variance)


def _cost(rows: Regression, common: Common) -> Callable[[Law], float]:
    """Twice the negative log posterior of a channel's own law."""
    precision = np.linalg.inv(common.covariance)

    def cost(law: Law) -> float:
        off = law - common.law
        return rows.deviance(law) + float(off @ precision @ off)

    return cost


def _freedom(rows: Regression, cost: Callable[[Law], float], law: Law) -> FloatArray:
    """Degrees of freedom of Student's interval for each coefficient, shape (p,).

    A variance is known to ``ν = var(ln variance)``; the interval is that which holds 95 % when its
    logarithm is normal, and Student's of these degrees of freedom is as wide.
    """

    def logs(at: Law) -> FloatArray:
        return np.log(np.maximum(np.diag(rows.solve(at)[1]), 1e-300))

    steps = _STEP * np.eye(law.size)
    slope = np.stack([(logs(law + s) - logs(law - s)) / (2.0 * _STEP) for s in steps])
    spread = _spread(cost, law)
    own = 2.0 / max(rows.target.size - rows.design.shape[1], 1)
    unknown = np.einsum("ip,ij,jp->p", slope, spread, slope) + own
    return np.array([_student(float(np.sqrt(nu))) for nu in unknown])


def _student(log_sd: float) -> float:
    """Degrees of freedom of the Student interval as wide as that of a variance so known."""
    at, weight = np.polynomial.hermite_e.hermegauss(15)
    root = np.exp(0.5 * log_sd * at)

    def missed(width: float) -> float:
        return float(2.0 * special.ndtr(-width / root) @ weight / weight.sum()) - _OUTSIDE

    if not missed(_WIDEST) < 0.0:  # nothing is known of the variance
        return _FEWEST_FREEDOM
    width = optimize.brentq(missed, 0.5, _WIDEST)
    if width <= special.stdtrit(_MOST_FREEDOM, 1.0 - _OUTSIDE / 2.0):
        return _MOST_FREEDOM
    return float(
        optimize.brentq(
            lambda dof: special.stdtrit(dof, 1.0 - _OUTSIDE / 2.0) - width, _FEWEST_FREEDOM, 2e3
        )
    )


def _spread(cost: Callable[[Law], float], law: Law) -> FloatArray:
    """Covariance of a law from the curvature of twice its negative log posterior, shape (5, 5)."""
    steps = _STEP * np.eye(law.size)
    ends = np.array([[cost(law + sign * s) for s in steps] for sign in (1.0, -1.0)])
    middle, curvature = cost(law), np.empty((law.size, law.size))
    for i in range(law.size):
        curvature[i, i] = (ends[:, i].sum() - 2.0 * middle) / _STEP**2
        for j in range(i):
            both = cost(law + steps[i] + steps[j]) + cost(law - steps[i] - steps[j])
            mixed = both - ends[:, i].sum() - ends[:, j].sum() + 2.0 * middle
            curvature[i, j] = curvature[j, i] = mixed / (2.0 * _STEP**2)
    values, vectors = np.linalg.eigh(0.5 * curvature)
    return np.asarray((vectors / np.maximum(values, 1.0 / _EXPECTED_SD**2)) @ vectors.T)


def _expected(channels: Sequence[Regression]) -> Law:
    """Logarithms before anything is seen; the memory in the middle of the times between rows."""
    apart = np.concatenate([c.apart_s[np.isfinite(c.apart_s) & (c.apart_s > 0)] for c in channels])
    middle = np.sqrt(apart.min() * apart.max()) if apart.size else 1.0
    return np.append(_EXPECTED, np.log(middle))


def _lowest(cost: Callable[[Law], float], start: Law) -> Law:
    simplex = np.vstack([start, start + 0.7 * np.eye(start.size)])
    found = optimize.minimize(
        cost, start, method="Nelder-Mead",
        options={"maxfev": _EVALUATIONS, "xatol": 0.05, "fatol": 0.02, "initial_simplex": simplex},
    )  # fmt: skip
    return np.asarray(found.x, dtype=np.float64)
