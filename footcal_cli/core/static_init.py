"""Scales and biases from quiet standing: seed 1, section 3.3.1, eqs. (12)(13).

The unknowns are gains and biases on top of a belief (`footcal_cli.core.online.rows`), found as
maximum a posteriori: total force and CoP of quiet stances never show all of them, and what they do
not show keeps the prior and says so. Plain least squares of (13) is there for comparison.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N
from footcal_cli.core.contact import Reason, Validity, judge
from footcal_cli.core.log import Log
from footcal_cli.core.observability import NextStep, Observability, observability, rank_candidates
from footcal_cli.core.online.rows import Belief, cell_rows
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray, Status
from footcal_cli.core.signals import autocorrelation_time, stretches
from footcal_cli.errors import FitError

FORCE_SD_N, MOMENT_SD_NM, SWING_SD_N = 0.15, 0.03, 0.15
"""What a stance's mean is worth: force, moment about the CoM (1 mm of CoM), a lifted cell."""

LEARNT_RATIO = 0.5
"""A parameter counts as estimated where standing at least halved its prior sd.

Every stance shows the sum of all cells, which shrinks every sd a little without teaching any cell.
"""


@dataclass(frozen=True)
class QuietRule:
    """When standing counts as quiet (seed 1, section 3.3.1).

    Parameters
    ----------
    warm_s
        Discarded at the start of each stance, T_warm.
    acceleration_mps2, rate_radps
        Thresholds on ‖a‖ (gravity removed) and ‖ω‖.
    min_force_n
        ε on the vertical force.
    least_samples
        Samples a stance needs.
    """

    warm_s: float = 1.0
    acceleration_mps2: float = 0.3
    rate_radps: float = 0.1
    min_force_n: float = MIN_FORCE_N
    least_samples: int = 40


@dataclass(frozen=True)
class QuietSet:
    """Samples of quiet standing.

    Parameters
    ----------
    stance
        Number of the stance each sample belongs to, −1 where it does not count, shape (n,).
    validity
        Why samples do not count.
    """

    stance: IntArray
    validity: Validity

    @property
    def stances(self) -> int:
        """How many stances there are."""
        return int(self.stance.max(initial=-1)) + 1


def select_quiet(
    log: Log,
    forces_n: FloatArray,
    *,
    acceleration_mps2: FloatArray | None = None,
    gyro_radps: FloatArray | None = None,
    rule: QuietRule | None = None,
) -> QuietSet:
    """Choose the samples of quiet standing and cut them into stances.

    A stance ends where the robot moves for longer than `warm_s`.

    Parameters
    ----------
    log
        Standing, raw counts.
    forces_n
        Forces by the believed calibration, shape (n, c).
    acceleration_mps2
        Of the IMU without gravity, shape (n, 3); the CoM's where None.
    gyro_radps
        Shape (n, 3); not judged where None.
    rule
        Thresholds.

    Raises
    ------
    FitError
        Too few samples; says how many more are needed.
    """
    rule = rule or QuietRule()
    n = len(log)
    acceleration = log.known["com_acc_mps2"] if acceleration_mps2 is None else acceleration_mps2
    moving = np.linalg.norm(acceleration, axis=1) > rule.acceleration_mps2
    if gyro_radps is not None:
        moving |= np.linalg.norm(gyro_radps, axis=1) > rule.rate_radps
    finite = np.asarray(np.isfinite(forces_n).all(axis=1))
    seen = np.isfinite(log.known["com_m"]).all(axis=1)
    if seen.any():  # a stand without any body stream still has its weight
        finite &= seen
    total = np.where(finite, forces_n.sum(axis=1), 0.0)
    loaded = total > rule.min_force_n
    period = float(np.median(np.diff(log.time_s))) if n > 1 else 1.0
    warm = max(round(rule.warm_s / period), 1)
    still = finite & loaded & ~moving & ~np.isnan(log.known["contact"]).any(axis=1)
    still = _bridged(still, warm) & finite & loaded
    warming = np.zeros(n, dtype=bool)
    stance = np.full(n, -1, dtype=np.int64)
    count = 0
    for start, stop in stretches(still):
        warming[start : min(start + warm, stop)] = True
        body = slice(start + warm, stop)
        good = np.zeros(n, dtype=bool)
        good[body] = ~moving[body]
        if int(good.sum()) >= rule.least_samples:
            stance[good] = count
            count += 1
    validity = judge(
        {
            Reason.DROPOUT: ~finite,
            Reason.NO_CONTACT: finite & ~loaded,
            Reason.TRANSITION: (stance < 0) & finite & loaded,
        },
        n,
    )
    if count == 0:
        longest = max((b - a for a, b in stretches(still)), default=0)
        missing = rule.least_samples + warm - longest
        raise FitError(
            f"no quiet standing: the longest still stretch has {longest} samples, "
            f"{rule.least_samples} after {warm} of warming are needed",
            remedy=f"stand still for at least {missing * period:.1f} s longer ({missing} samples)",
        )
    return QuietSet(stance, validity)


def _bridged(flags: BoolArray, longest: int) -> BoolArray:
    """Fill inner gaps shorter than `longest`."""
    filled = flags.copy()
    for start, stop in stretches(~flags):
        if start > 0 and stop < flags.size and stop - start < longest:
            filled[start:stop] = True
    return filled


@dataclass(frozen=True)
class StanceRows:
    """Means of the linear rows over each stance.

    Parameters
    ----------
    h
        Shape (rows, p), columns in prior sd.
    error
        With the believed calibration, shape (rows,).
    sd
        Noise of each row's mean, shape (rows,).
    output
        Name of each row's balance.
    stance
        Shape (rows,).
    names, prior_sd, prior_information
        Of the unknowns; information in units of the prior sd.
    effective_samples
        Independent samples behind each stance's mean force, shape (stances,).
    """

    h: FloatArray
    error: FloatArray
    sd: FloatArray
    output: tuple[str, ...]
    stance: IntArray
    names: tuple[str, ...]
    prior_sd: FloatArray
    prior_information: FloatArray
    effective_samples: FloatArray

    @property
    def whitened(self) -> FloatArray:
        """Rows in units of their noise."""
        return self.h / self.sd[:, None]


def stance_rows(
    log: Log,
    quiet: QuietSet,
    belief: Belief,
    *,
    force_sd_n: float = FORCE_SD_N,
    moment_sd_nm: float = MOMENT_SD_NM,
    swing_sd_n: float = SWING_SD_N,
) -> StanceRows:
    """Average the static balance over each stance.

    The scatter of the mean counts by its effective sample size; the errors that a stance does not
    average out (a CoM that is off, creep) are the given floors.

    Parameters
    ----------
    log
        Raw counts.
    quiet
        From `select_quiet`.
    belief
        Prior.
    force_sd_n, moment_sd_nm, swing_sd_n
        Floors of total force, moments and lifted cells.
    """
    rows = cell_rows(log, belief, samples_per_update=1, states=(), plate=False, static=True)
    floors = np.array(
        [force_sd_n, moment_sd_nm, moment_sd_nm] + [swing_sd_n] * len(log.channels), dtype=float
    )
    h, error, sd, output, stance, worth = [], [], [], [], [], []
    for number in range(quiet.stances):
        inside = quiet.stance == number
        tau = autocorrelation_time(rows.error[inside, 0])
        worth.append(float(inside.sum() / tau))
        for k, name in enumerate(rows.outputs):
            use = inside & rows.valid[:, k]
            if use.sum() < inside.sum() / 2:
                continue
            h.append(rows.h[use, k].mean(axis=0))
            error.append(rows.error[use, k].mean())
            spread = np.std(rows.error[use, k]) / np.sqrt(use.sum() / tau)
            sd.append(np.hypot(spread, floors[k]))
            output.append(name)
            stance.append(number)
    return StanceRows(
        h=np.array(h).reshape(-1, len(rows.names)),
        error=np.array(error),
        sd=np.array(sd),
        output=tuple(output),
        stance=np.array(stance, dtype=np.int64),
        names=rows.names,
        prior_sd=rows.prior_sd,
        prior_information=np.asarray(np.linalg.inv(rows.prior_correlation), dtype=float),
        effective_samples=np.array(worth),
    )


@dataclass(frozen=True)
class StaticInit:
    """Scales and biases from quiet standing.

    Parameters
    ----------
    estimates
        ``<cell>.scale``, ``<cell>.bias``; what the stances did not show is `PRIOR_KEPT`.
    gain, bias_n
        On top of the belief, shape (c,).
    covariance
        Of (gain, bias), shape (2c, 2c).
    least_squares
        Gains and biases of plain least squares of eq. (13), minimum norm in raw units, shape (2c,).
    observability
        Of the stances alone.
    chi2, dof
        Whitened squared residual of rows and prior, and the number of rows.
    """

    estimates: Estimates
    gain: FloatArray
    bias_n: FloatArray
    covariance: FloatArray
    least_squares: FloatArray
    observability: Observability
    chi2: float
    dof: int


def fit_static(rows: StanceRows, belief: Belief) -> StaticInit:
    """Maximum a posteriori of gains and biases, and plain least squares beside it.

    ``min ‖(e + H z)/σ‖² + zᵀ P₀⁻¹ z``, z in prior sd: linear, solved once.

    Parameters
    ----------
    rows
        From `stance_rows`.
    belief
        The prior that the rows were made with.
    """
    a, b = rows.whitened, rows.error / rows.sd
    information = a.T @ a + rows.prior_information
    z = -np.linalg.solve(information, a.T @ b)
    cov_z = np.linalg.inv(information)
    c = len(belief.channels)
    values = z * rows.prior_sd
    covariance = cov_z * np.outer(rows.prior_sd, rows.prior_sd)
    sd_ratio = np.sqrt(np.diag(cov_z))
    status = [Status.ESTIMATED if ratio < LEARNT_RATIO else Status.PRIOR_KEPT for ratio in sd_ratio]
    residual = b + a @ z
    return StaticInit(
        estimates=belief.estimates(values[:c], values[c:], covariance, status),
        gain=values[:c],
        bias_n=values[c:],
        covariance=covariance,
        least_squares=_plain_least_squares(rows, belief),
        observability=observability(a, rows.names),
        chi2=float(residual @ residual + z @ rows.prior_information @ z),
        dof=b.size,
    )


def _plain_least_squares(rows: StanceRows, belief: Belief) -> FloatArray:
    """Eq. (13) as printed: c and d by least squares, no prior, each axis in its own unit.

    Solved in the nearly collinear raw unknowns (c, d) by minimum norm, as a first implementation
    would; returned as gain and bias on top of the belief.
    """
    c = len(belief.channels)
    # error = error0 + h_gain γ + h_bias β with γ = δc/c⁰ and β = δd − d⁰ γ
    physical = rows.h / rows.prior_sd
    to_scale = (physical[:, :c] - physical[:, c:] * belief.bias_n) / belief.scale_n_per_count
    raw = np.concatenate([to_scale, physical[:, c:]], axis=1)
    believed = np.concatenate([belief.scale_n_per_count, belief.bias_n])
    target = raw @ believed - rows.error
    solution = np.linalg.lstsq(raw, target, rcond=1e-12)[0]
    gain = solution[:c] / belief.scale_n_per_count - 1.0
    return np.concatenate([gain, solution[c:] - belief.bias_n * (1.0 + gain)])


MENU: Mapping[str, tuple[float, float, float]] = {
    "shift weight left": (0.0, 0.6, 0.0),
    "shift weight right": (0.0, -0.6, 0.0),
    "shift weight front": (0.6, 0.0, 0.0),
    "shift weight back": (-0.6, 0.0, 0.0),
    "squat": (0.0, 0.0, 1.0),
}
"""Stances that keep the feet: CoP forward and left as a share of the way to the edge, squat."""
REPLACED = {"left": "re-place the left foot", "right": "re-place the right foot"}
ONE_FOOT = {"left": "stand on the right foot only", "right": "stand on the left foot only"}


def next_stances(
    rows: StanceRows,
    cells_w_m: FloatArray,
    feet: Sequence[Sequence[int]],
    foot_names: Sequence[str],
    weight_n: float,
    belief: Belief,
) -> list[NextStep]:
    """Which stance to add next, and what it would bring, best first.

    Parameters
    ----------
    rows
        The stances in hand.
    cells_w_m
        Positions of the cells in the last stance, shape (c, 2).
    feet
        Columns of each foot's cells.
    foot_names
        Their names (left, right).
    weight_n
        Body weight.
    belief
        For the channels and the units.
    """
    feet_columns = [np.asarray(f) for f in feet]
    candidates = {
        name: _imagined(rows, cells_w_m, feet_columns, weight_n, belief, ahead, left)
        for name, (ahead, left, _) in MENU.items()
    }
    for k, foot in enumerate(foot_names):
        moved = cells_w_m.copy()
        middle = moved[feet_columns[k]].mean(axis=0)
        turn = np.array([[0.955, -0.296], [0.296, 0.955]])  # 0.3 rad, and 4 cm ahead
        moved[feet_columns[k]] = (moved[feet_columns[k]] - middle) @ turn.T + middle
        moved[feet_columns[k], 0] += 0.04
        name = REPLACED.get(foot, f"re-place the {foot} foot")
        candidates[name] = _imagined(rows, moved, feet_columns, weight_n, belief, 0.0, 0.0)
        if len(foot_names) > 1:
            candidates[ONE_FOOT.get(foot, f"lift the {foot} foot")] = _imagined(
                rows, cells_w_m, feet_columns, weight_n, belief, 0.0, 0.0, lifted=k
            )
    return rank_candidates(rows.whitened, rows.prior_information, candidates, rows.names)


def _imagined(
    rows: StanceRows,
    cells: FloatArray,
    feet: Sequence[IntArray],
    weight_n: float,
    belief: Belief,
    ahead: float,
    left: float,
    lifted: int | None = None,
) -> FloatArray:
    """Whitened rows (k, p) of a stance with these cells and this CoP."""
    c = len(belief.channels)
    share = np.full(len(feet), 1.0 / len(feet))
    if len(feet) == 2:
        share = np.array([0.5 + left / 2.0, 0.5 - left / 2.0])
    if lifted is not None:
        share = np.where(np.arange(len(feet)) == lifted, 0.0, 1.0)
    force = np.zeros(c)
    for k, columns in enumerate(feet):
        offset = cells[columns, 0] - cells[columns, 0].mean()
        lean = 1.0 + ahead * offset / max(np.abs(offset).max(), 1e-9)
        force[columns] = share[k] * weight_n * lean / lean.sum()
    cop = force @ cells / force.sum()
    arms = cells - cop
    per_force = np.stack([np.ones(c), arms[:, 1], -arms[:, 0]])
    h = np.concatenate([per_force * force, per_force], axis=1)
    sd = [FORCE_SD_N, MOMENT_SD_NM, MOMENT_SD_NM]
    if lifted is not None:
        swing = np.zeros((feet[lifted].size, 2 * c))
        swing[np.arange(feet[lifted].size), c + feet[lifted]] = 1.0
        h = np.concatenate([h, swing])
        sd += [SWING_SD_N] * feet[lifted].size
    return np.asarray(h * rows.prior_sd / np.array(sd)[:, None])
