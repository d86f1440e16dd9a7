"""Which foot stands, which is in the air, and why a sample may not count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import low_pass_stretches, stretches

_IN_AIR = 0.05
"""Quantile of a foot's force that it reads in the air, whatever its offset."""
_ROUNDING = np.array([1.0, 2.0, 3.0, 2.0, 1.0]) / 9.0
"""What a 10 Hz zero-phase low-pass makes of a step at 80 Hz, nearly."""


class Reason(StrEnum):
    """Why a sample does not count, in the order in which reasons are given."""

    DROPOUT = "dropout"
    NO_CONTACT = "no contact"
    TRANSITION = "transition"
    LOW_IMU_CONFIDENCE = "low IMU confidence"
    OUTLIER = "outlier"


@dataclass(frozen=True)
class Validity:
    """Which samples count, and why the others do not.

    Parameters
    ----------
    valid
        Shape (n,).
    reason
        Index into `reasons` of the first reason that applies, −1 where valid, shape (n,).
    """

    valid: BoolArray
    reason: IntArray
    reasons: tuple[Reason, ...] = tuple(Reason)

    @property
    def counts(self) -> dict[str, int]:
        """Samples rejected per reason."""
        return {
            str(name): int(np.sum(self.reason == i))
            for i, name in enumerate(self.reasons)
            if np.any(self.reason == i)
        }

    def words(self) -> list[str]:
        """The reason of each sample, empty where valid."""
        names = ["", *map(str, self.reasons)]
        return [names[i + 1] for i in self.reason]


def judge(failures: Mapping[Reason, BoolArray], n: int) -> Validity:
    """Per-sample validity from what went wrong; earlier reasons win."""
    reason = np.full(n, -1, dtype=np.int64)
    for i, name in reversed(list(enumerate(Reason))):
        if name in failures:
            reason[failures[name]] = i
    return Validity(reason < 0, reason)


@dataclass(frozen=True)
class ContactRule:
    """Thresholds of contact detection on a foot's total vertical force.

    Parameters
    ----------
    on_share, off_share
        A foot lands when it carries more than this share of the body weight, and leaves when it
        carries less. High enough that a cell whose bias jumped does not hold a foot down.
    edge_share
        Lift-off and touch-down are where the force leaves the level of that swing by this share
        of the body weight: whatever the biases, the level is what the foot reads in the air.
    settle_s
        Half width of the stretch around a change that is neither stance nor swing.
    min_phase_s
        Phases shorter than this are flicker and take the state around them.
    """

    on_share: float = 0.12
    off_share: float = 0.08
    edge_share: float = 0.02
    settle_s: float = 0.06
    min_phase_s: float = 0.08


def detect_contact(
    foot_force_n: FloatArray, weight_n: float, rate_hz: float, rule: ContactRule | None = None
) -> FloatArray:
    """Contact of each foot with hysteresis: 1 stance, 0 swing, NaN in between.

    Parameters
    ----------
    foot_force_n
        Vertical force of each foot by the calibration believed so far, shape (n, feet); NaN where
        samples were lost.
    """
    from scipy.ndimage import binary_dilation

    rule = rule or ContactRule()
    width = max(round(rule.settle_s * rate_hz), 1)
    contact = np.empty(foot_force_n.shape)
    for foot, force in enumerate(foot_force_n.T):
        loaded = _hysteresis(force, rule.off_share * weight_n, rule.on_share * weight_n)
        loaded = _without_flicker(loaded, max(round(rule.min_phase_s * rate_hz), 1))
        loaded = _refined(loaded, force, rule.edge_share * weight_n)
        state = loaded.astype(float)
        change = np.flatnonzero(np.diff(state))
        near = np.zeros(force.size, dtype=bool)
        near[change] = near[np.minimum(change + 1, force.size - 1)] = True
        if near.any():
            near = binary_dilation(near, iterations=width)
        state[near | ~np.isfinite(force)] = np.nan
        contact[:, foot] = state
    return contact


def flicker(
    foot_force_n: FloatArray, weight_n: float, rate_hz: float, rule: ContactRule | None = None
) -> BoolArray:
    """Samples of phases too short to be a stance or a swing, shape (n, feet).

    A foot in the air that carries hundreds of newtons for one sample is a broken reading: left in,
    a low-pass spreads it over its neighbours. So is one that the ground seems to pull down by more
    than a landing takes, below what the foot reads in the air.

    Parameters
    ----------
    foot_force_n, weight_n, rate_hz, rule
        As `detect_contact`; forces as read, not filtered.
    """
    rule = rule or ContactRule()
    shortest = max(round(rule.min_phase_s * rate_hz), 1)
    found = np.zeros(foot_force_n.shape, dtype=bool)
    low, high = rule.off_share * weight_n, rule.on_share * weight_n
    for foot, force in enumerate(foot_force_n.T):
        loaded = _hysteresis(force, low, high)
        found[:, foot] = _without_flicker(loaded, shortest) != loaded
        in_air = (
            min(float(np.nanquantile(force, _IN_AIR)), 0.0) if np.isfinite(force).any() else 0.0
        )
        pulled = _hysteresis(in_air - force, low, high)
        found[:, foot] |= pulled & ~_without_flicker(pulled, shortest)
        for value in (False, True):
            for start, stop in stretches(loaded == value):
                at_an_end = (start == 0) != (stop == force.size)
                found[start:stop, foot] |= at_an_end and stop - start < shortest
    return found


def contact_now(
    foot_force_n: FloatArray, weight_n: float, rate_hz: float, rule: ContactRule | None = None
) -> FloatArray:
    """As `detect_contact`, each sample judged by those before it alone.

    A foot stands or swings once it has done so for `settle_s`; in the air its force must have
    stayed within `edge_share` of the weight for as long, or it is landing.
    """
    rule = rule or ContactRule()
    width = max(round(rule.settle_s * rate_hz), 1) + 1
    contact = np.full(foot_force_n.shape, np.nan)
    for foot, force in enumerate(foot_force_n.T):
        loaded = _hysteresis(force, rule.off_share * weight_n, rule.on_share * weight_n)
        lately = np.lib.stride_tricks.sliding_window_view(loaded, width)
        span = np.lib.stride_tricks.sliding_window_view(force, width)
        steady = span.max(axis=1) - span.min(axis=1) < rule.edge_share * weight_n
        settled = contact[width - 1 :, foot]
        settled[lately.all(axis=1)] = 1.0
        settled[~lately.any(axis=1) & steady] = 0.0
        contact[~np.isfinite(force), foot] = np.nan
    return contact


def airborne_now(
    foot_force_n: FloatArray, weight_n: float, rule: ContactRule | None = None
) -> FloatArray:
    """As `airborne`, from the past alone: where the trigger is off, nothing settled, (n, feet)."""
    rule = rule or ContactRule()
    low, high = rule.off_share * weight_n, rule.on_share * weight_n
    hanging = [~_hysteresis(force, low, high) for force in foot_force_n.T]
    return np.stack(hanging, axis=1).astype(float)


def _refined(loaded: BoolArray, force: FloatArray, margin: float) -> BoolArray:
    """Shrink each swing to where the force stays within `margin` of its level in the air."""
    refined = loaded.copy()
    for start, stop in stretches(~loaded):
        quarter = (stop - start) // 4
        core = force[start + quarter : stop - quarter]
        if not np.isfinite(core).any():
            continue
        off = np.abs(force[start:stop] - np.nanmedian(core)) > margin
        inside = np.flatnonzero(~off)
        if inside.size and start > 0:
            refined[start : start + inside[0]] = True
        if inside.size and stop < force.size:
            refined[start + inside[-1] + 1 : stop] = True
    return refined


def airborne(contact: FloatArray) -> FloatArray:
    """How much of a foot's filtered reading is that of a foot in the air, 0 to 1, (n, feet).

    A transition takes the state of the nearer end, since `detect_contact` puts the change in its
    middle, and the step is rounded as the low-pass rounds the reading. A foot never seen in
    contact or in the air counts as standing.
    """
    swinging = np.zeros(contact.shape)
    for foot, state in enumerate(contact.T):
        if np.isfinite(state).any():
            padded = np.pad(_in_air(state).astype(float), _ROUNDING.size // 2, mode="edge")
            swinging[:, foot] = np.convolve(padded, _ROUNDING, mode="valid")
    return swinging


def _in_air(state: FloatArray) -> BoolArray:
    """Whether a foot is in the air, a transition taken for the nearer of its ends, shape (n,)."""
    rows, known = np.arange(state.size), np.flatnonzero(np.isfinite(state))
    after = np.clip(np.searchsorted(known, rows), 0, known.size - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(np.abs(known[after] - rows) <= np.abs(rows - known[before]), after, before)
    return np.asarray(state[known[nearer]] == 0.0)


def carried_over(
    readings: FloatArray,
    good: BoolArray,
    contact: FloatArray,
    feet: Sequence[IntArray],
    rate_hz: float,
    cutoff_hz: float,
) -> FloatArray:
    """What the zero-phase low-pass carries of stances into swings, shape (n, c).

    A reading is its level in the air and a load that is zero there, ``y = l + q``. The filter F
    leaves ``F q`` of the stances around it in a swing: some thousandths of the weight near its
    ends, and in its middle where it lasts no longer than ``2 / cutoff``.

    Parameters
    ----------
    readings
        Before the filter, shape (n, c).
    good
        Rows that are filtered, as `footcal_cli.core.signals.low_pass_stretches` has it, (n,).
    contact
        From `detect_contact`, shape (n, feet).
    feet
        Columns of each foot's channels.
    """
    carried = np.zeros(readings.shape)
    rows = np.arange(len(readings))
    for state, columns in zip(contact.T, feet, strict=True):
        settled = (state == 0.0) & good
        if not settled.any():
            continue
        air = _in_air(state)
        swings = [(a, b) for a, b in stretches(air) if settled[a:b].any()]
        middle = [0.5 * (a + b) for a, b in swings]
        levels = [np.median(readings[a:b, columns][settled[a:b]], axis=0) for a, b in swings]
        level = np.stack([np.interp(rows, middle, own) for own in np.transpose(levels)], axis=1)
        load = np.where(air[:, None], 0.0, readings[:, columns] - level)
        left = low_pass_stretches(load, good, rate_hz, cutoff_hz)
        carried[:, columns] = np.where(settled[:, None], left, 0.0)
    return carried


def _hysteresis(force: FloatArray, low: float, high: float) -> BoolArray:
    """State of a Schmitt trigger, vectorised: the last threshold crossed decides."""
    decided = np.where(force > high, 1, np.where(force < low, 0, -1))
    known = decided >= 0
    if not known.any():
        return np.asarray(force > (low + high) / 2)
    last = np.maximum.accumulate(np.where(known, np.arange(force.size), -1))
    first = int(np.argmax(known))
    last[:first] = first
    return np.asarray(decided[last] == 1)


def _without_flicker(state: BoolArray, shortest: int) -> BoolArray:
    """Flip phases shorter than `shortest`, but for the first and the last."""
    cleaned = state.copy()
    for value in (False, True):
        for start, stop in stretches(cleaned == value):
            if stop - start < shortest and start > 0 and stop < state.size:
                cleaned[start:stop] = not value
    return cleaned


def gait_cycles(contact: FloatArray) -> IntArray:
    """Number of the gait cycle each sample belongs to, −1 before the first; shape (n,).

    A cycle starts where the first foot's swing ends.
    """
    known = np.isfinite(contact[:, 0])
    last = np.maximum.accumulate(np.where(known, np.arange(len(contact)), -1))
    state = np.where(last >= 0, contact[np.maximum(last, 0), 0], np.nan)
    starts = np.zeros(len(contact), dtype=np.int64)
    starts[1:] = (state[1:] == 1) & (state[:-1] == 0)
    return np.cumsum(starts) - 1


def cycle_phase(contact: FloatArray) -> FloatArray:
    """Share of its gait cycle that each sample has come to, NaN outside of whole ones, (n,)."""
    phase = np.full(len(contact), np.nan)
    starts = np.flatnonzero(np.diff(gait_cycles(contact)) > 0) + 1
    for start, stop in pairwise(starts):
        phase[start:stop] = np.arange(stop - start) / (stop - start)
    return phase
