"""Quiet standing: which samples of a log show it, stance by stance ([NAO], section 3.3.1)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N
from footcal_cli.core.contact import Reason, Validity, judge
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import low_pass_stretches, stretches
from footcal_cli.errors import FitError

_SHIFT = 0.03
"""Share of the weight that moves to or from a cell when the stance changes."""
_STANCE_M, _MOMENT_S = 0.005, 0.2
"""A CoM or a foot that moves this far within this time makes another stance."""

_SWAY_HZ = 2.0
"""A body that stands moves more slowly."""


@dataclass(frozen=True)
class QuietRule:
    """When standing counts as quiet ([NAO], section 3.3.1).

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
    gyro_radps: FloatArray | None = None,
    rule: QuietRule | None = None,
) -> QuietSet:
    """Choose the samples of quiet standing and cut them into stances.

    A stance ends where the robot moves for longer than `warm_s`. Where its noise leaves no
    acceleration below the threshold, it is asked below `_SWAY_HZ`.

    Parameters
    ----------
    log
        Standing, raw counts.
    forces_n
        Forces by the believed calibration, shape (n, c).
    gyro_radps
        Shape (n, 3); not judged where None.

    Raises
    ------
    FitError
        Too few samples; says how many more are needed.
    """
    rule = rule or QuietRule()
    try:
        return _selected(log, forces_n, gyro_radps, rule)
    except FitError:
        slow = _below_noise(log)
        if slow is None:
            raise
        with suppress(FitError):
            return _selected(slow, forces_n, gyro_radps, rule)
        raise


def _below_noise(log: Log) -> Log | None:
    """The log with the acceleration below `_SWAY_HZ`; None where it has no rows or rate for it."""
    acc = log.known["com_acc_mps2"]
    known = np.asarray(np.isfinite(acc).all(axis=1))
    rate_hz = 1.0 / float(np.median(np.diff(log.time_s))) if len(log) > 1 else 0.0
    if rate_hz <= 2.5 * _SWAY_HZ or not known.any():
        return None
    return log.with_known(com_acc_mps2=low_pass_stretches(acc, known, rate_hz, _SWAY_HZ))


def _selected(
    log: Log, forces_n: FloatArray, gyro_radps: FloatArray | None, rule: QuietRule
) -> QuietSet:
    """As `select_quiet`, by the acceleration as it is."""
    n = len(log)
    moving = np.linalg.norm(log.known["com_acc_mps2"], axis=1) > rule.acceleration_mps2
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
    # single lost samples do not end a stance, they are only left out of it
    still = _bridged(still, warm) & ~_displaced(log, period)
    if not seen.any():
        still = _cut(still, _shifted(forces_n, period), warm + rule.least_samples)
    warming = np.zeros(n, dtype=bool)
    stance = np.full(n, -1, dtype=np.int64)
    count = 0
    for start, stop in stretches(still):
        warming[start : min(start + warm, stop)] = True
        body = slice(start + warm, stop)
        good = np.zeros(n, dtype=bool)
        good[body] = (finite & loaded & ~moving)[body]
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
        if missing <= 0:
            usual = float(np.nanmedian(np.linalg.norm(log.known["com_acc_mps2"], axis=1)))
            raise FitError(
                f"no quiet standing: the CoM accelerates by {usual:.2g} m/s² (median) where it "
                f"stays in its place, and {rule.acceleration_mps2:.2g} m/s² is still: its noise",
                remedy="set largest_acceleration_mps2 in [static_init] above that noise, or log "
                "the acceleration of the CoM as the estimator has it (com_acc_x_mps2 …)",
            )
        raise FitError(
            f"no quiet standing: the longest still stretch has {longest} samples, "
            f"{rule.least_samples} after {warm} of warming are needed",
            remedy=f"stand still for at least {missing * period:.1f} s longer ({missing} samples)",
        )
    return QuietSet(stance, validity)


def _displaced(log: Log, period_s: float) -> BoolArray:
    """Where the CoM or a cell moves by more than `_STANCE_M` within a moment: another stance."""
    n = len(log)
    points = [log.known["com_m"][:, None, :2]]
    if "cell_pos_m" in log.known:
        points.append(log.known["cell_pos_m"].reshape(n, -1, 2))
    place = np.concatenate(points, axis=1)
    half = max(round(_MOMENT_S / 2 / period_s), 1)
    moved = np.zeros(n, dtype=bool)
    step = np.linalg.norm(place[2 * half :] - place[: -2 * half], axis=2)
    moved[half : n - half] = (np.nan_to_num(step) > _STANCE_M).any(axis=1)
    return moved


def _cut(still: BoolArray, moved: BoolArray, least: int) -> BoolArray:
    """Stances without the rows that move, where several long ones keep half of the rows.

    Parameters
    ----------
    still, moved
        Shape (n,).
    least
        Rows that a stance needs.
    """
    cut = still & ~moved
    lengths = [stop - start for start, stop in stretches(cut) if stop - start >= least]
    return cut if len(lengths) > 1 and sum(lengths) > still.sum() / 2 else still


def _shifted(forces_n: FloatArray, period_s: float) -> BoolArray:
    """Where weight moves from cell to cell within a moment: another stance, where no CoM is known.

    Parameters
    ----------
    forces_n
        Shape (n, c).
    """
    n = len(forces_n)
    width = max(round(_MOMENT_S / period_s), 1)
    known = np.nan_to_num(forces_n)
    total = np.maximum(known.sum(axis=1, keepdims=True), 1e-9)
    box = np.ones(width) / width
    share = np.stack([np.convolve(c, box, mode="same") for c in (known / total).T], axis=1)
    moved = np.zeros(n, dtype=bool)
    if n <= 4 * width:
        return moved
    step = np.abs(share[2 * width :] - share[: -2 * width])
    moved[width : n - width] = (step > _SHIFT).any(axis=1)
    moved[: 2 * width] = moved[n - 2 * width :] = False  # the average begins and ends there
    return moved


def _bridged(flags: BoolArray, longest: int) -> BoolArray:
    """Fill inner gaps shorter than `longest`."""
    filled = flags.copy()
    for start, stop in stretches(~flags):
        if start > 0 and stop < flags.size and stop - start < longest:
            filled[start:stop] = True
    return filled
