"""Six-axis transducers that are mounted half or quarter turns off, by what their wrenches balance.

Such a turn exchanges or reverses two axes of force and of torque at once. It is no small error
that a fit could find: every one of the 24 right-angled turns is tried instead.

A single turned axis drives weight, CoM and tilts far from where they are; signatures taken there
say nothing. So every axis is turned back in turn, and the whole model fitted again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments.walk import feet_of
from footcal_cli.core.hang.joint import HangFit, HangOptions, fit_hang
from footcal_cli.core.hang.runs import HangRun, hang_runs
from footcal_cli.core.hang.signs import misfit_by_signs
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.feet_balance import FeetBalance
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import misfits_of_poses
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import axis_rotations, rotation_log

SHARE_LEFT = 0.25
"""Share of the squared misfit that may be left when the right axis is turned back."""
ROUGH_STEPS = 8
"""The right axis or turn is fitted in four to six steps, most wrong ones run until their limit."""
MOST_STEPS = 100
"""Of what is fitted to the end."""
_NEAR = 20.0
"""Times the least rough misfit, up to which what was turned back is fitted to the end."""
AS_GOOD = 0.01
"""Difference of two squared misfits, as a share of the smaller, that tells no axis from another."""


@dataclass(frozen=True)
class TurnedAxis:
    """An axis that fits far better with its sign turned.

    Parameters
    ----------
    channels
        ``fl.fx``, the best first; several where turning any of them fits alike: a leg and its
        mirror image differ by two signs.
    left
        Share of the squared misfit that is left with the sign turned back.
    """

    channels: tuple[str, ...]
    left: float

    def finding(self) -> Finding:
        """As an alarm."""
        axes = " or ".join(f"{axis} of leg {leg}" for leg, axis in map(_parts, self.channels))
        legs = " or ".join(dict.fromkeys(leg for leg, _ in map(_parts, self.channels)))
        return Finding(
            "axis_turned",
            "alarm",
            " or ".join(self.channels),
            f"{axes} reads with the sign reversed: corrected, {self.left:.1%} of the squared "
            "misfit remains" + ("; these data do not show which" if len(self.channels) > 1 else ""),
            f"correct the wiring or the axes of leg {legs}, then calibrate again",
        )


def _parts(channel: str) -> tuple[str, str]:
    leg, axis = channel.split(".")
    return leg, axis


def turned_when_hanging(
    logs: Sequence[Log], asked: HangOptions, given: HangFit
) -> TurnedAxis | None:
    """The axis of one hanging leg whose sign is turned, if any; it leaves the leg a weight > 0.

    Parameters
    ----------
    given
        The fit of these logs, as asked, with no sign turned.
    """
    channels = logs[0].channels
    runs = hang_runs(logs)[0]
    sd = np.array([channel.sd for channel in given.noise])
    roughly = misfit_by_signs(logs, asked, given)
    # what the turning of the leg adds, which the rough fit does not know
    still = zip(runs, given.at_rest(runs), strict=True)
    added = _norm([run.wrench - rest for run, rest in still], sd)

    def refitted(signs: FloatArray) -> tuple[list[Log], HangFit]:
        changed = [log.with_readings(log.readings * signs) for log in logs]
        return changed, fit_hang(changed, asked)

    def misfit(signs: FloatArray, _beyond: float) -> float:
        changed, fit = refitted(signs)
        own = np.array([channel.sd for channel in fit.noise])
        return _norm(fit.residuals(hang_runs(changed)[0]), own) ** 2

    def screened(signs: FloatArray, beyond: float) -> float:
        left = roughly(signs)
        return np.inf if np.sqrt(left) > np.sqrt(beyond) + added else left

    found = _most_improved(misfit, channels, screened, _norm(given.residuals(runs), sd) ** 2)
    if found is None:
        return None
    _, fit = refitted(np.where(np.array(channels) == found.channels[0], -1.0, 1.0))
    # nothing hangs upwards: more than that one axis is turned
    return found if fit.values.weight_n > 0 else None


def _norm(parts: Sequence[FloatArray], sd: FloatArray) -> float:
    """Root of the sum of squares of (n, c) parts over the channels' sd."""
    return float(np.sqrt(sum(np.sum((part / sd) ** 2) for part in parts)))


def turned_when_standing(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, options: PoseOptions
) -> TurnedAxis | None:
    """The axis of one of the standing legs whose sign is turned, if any."""
    summary = summarise(data)
    channels = [f"{leg}.{axis}" for leg in data.geometry.legs for axis in AXES]

    fitted = misfits_of_poses(summary, legs, noise_sd, options)

    def turned(signs: FloatArray) -> FloatArray:
        every = np.append(signs, np.ones(summary.gram.shape[0] - signs.size))
        return summary.gram * np.outer(every, every)

    def misfit(signs: FloatArray, beyond: float) -> float:
        return fitted(turned(signs), beyond, MOST_STEPS)

    def roughly(signs: FloatArray, beyond: float) -> float:
        return fitted(turned(signs), beyond, ROUGH_STEPS)

    return _most_improved(misfit, channels, roughly, misfit(np.ones(len(channels)), np.inf))


Back = TypeVar("Back")


def near_the_best(
    every: Sequence[Back], roughly: Callable[[Back], float], given: float
) -> list[Back]:
    """What to fit to the end: ways of turning back that are better than the given one by then.

    The right one is as good as fitted after so many steps.
    """
    rough = [roughly(one) for one in every]
    most = min(_NEAR * min(rough), given)
    return [one for one, left in zip(every, rough, strict=True) if left <= most]


Misfit = Callable[[FloatArray, float], float]
"""Squared misfit with signs (channels,) turned; it may be called infinite beyond a limit."""


def _most_improved(
    misfit: Misfit, channels: Sequence[str], roughly: Misfit, before: float
) -> TurnedAxis | None:
    beyond = (1.0 + AS_GOOD) * SHARE_LEFT * before
    every = list(1.0 - 2.0 * np.eye(len(channels)))
    tried = near_the_best(every, lambda signs: roughly(signs, beyond), before)
    if not tried:
        return None
    channels = [channels[int(np.argmin(signs))] for signs in tried]
    after = np.array([misfit(signs, beyond) for signs in tried])
    least = float(after.min())
    share = least / max(before, np.finfo(float).tiny)
    if share >= SHARE_LEFT:
        return None
    alike = [i for i in np.argsort(after, kind="stable") if after[i] <= (1.0 + AS_GOOD) * least]
    return TurnedAxis(tuple(channels[i] for i in alike), share)


MUCH_BETTER = 0.2
"""Share of the squared misfit that may be left when the right transducer is turned back."""
CLEARLY = 0.5
"""And at most this share of the next best turn; closer ones are named together."""
POOR = 5.0
"""Residual over the scatter from sample to sample beyond which more than noise is left."""
_FEWEST_SIDES = 3
_MISFIT = 0.1
"""Share of the squared forces and torques that tilts and a moving CoM may make up."""


TURNS = axis_rotations()[1:]
"""The 23 right-angled turns other than none, shape (3, 3) each."""


def words_of(turn: FloatArray) -> str:
    """``half a turn about z``, ``a quarter turn about x``, ``a third … about (1, 1, 1)``."""
    if np.trace(turn) < -0.9:  # half a turn: the axis is the eigenvector of 1
        axis = np.linalg.eigh(turn + turn.T)[1][:, -1]
        axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
        size = "half a turn"
    else:
        axis = rotation_log(turn)
        size = "a quarter turn" if np.trace(turn) > 0.5 else "a third of a turn"
    axis = np.round(axis / np.abs(axis).max())
    if np.abs(axis).sum() == 1:
        at = int(np.argmax(np.abs(axis)))
        return f"{size} about {'xyz'[at]}"
    return f"{size} about ({', '.join(f'{x:g}' for x in axis)})"


def _best_turn(
    names: Sequence[str],
    misfit: Callable[[int, FloatArray], float],
    given: float,
) -> list[Finding]:
    """The transducer and the turn that explain a misfit, where one does so clearly."""
    every = [(k, i) for k in range(len(names)) for i in range(len(TURNS))]
    return said_of(names, [(misfit(k, TURNS[i]), k, i) for k, i in every], given)


def said_of(
    names: Sequence[str], tried: Sequence[tuple[float, int, int]], given: float
) -> list[Finding]:
    """Likewise from every turn that was tried: squared misfit, transducer, turn."""
    tried = sorted(tried)
    least = tried[0][0]
    if not np.isfinite(given) or least > MUCH_BETTER * given:
        return []
    alike = [(k, i) for left, k, i in tried if left <= least / CLEARLY]
    legs = list(dict.fromkeys(names[k] for k, _ in alike))
    turns = list(dict.fromkeys(words_of(TURNS[i]) for _, i in alike))
    return [
        Finding(
            "transducer_turned", "alarm", " or ".join(legs),
            f"the transducer of {' or '.join(legs)} looks mounted {' or '.join(turns[:3])} off: "
            f"turned back, {least / given:.1%} of the squared misfit remains",
            "correct its axes in the recipe or in [columns], then calibrate again",
        )
    ]  # fmt: skip


def check_turned_hanging(leg: str, logs: Sequence[Log]) -> list[Finding]:
    """Find a hanging transducer whose forces do not point where the orientations say.

    ``F = w e + o`` with the named directions e and a weight w > 0; offsets o fall out of the
    differences between orientations.

    Parameters
    ----------
    logs
        Of one leg, in two opposite orientations or more.
    """
    runs = hang_runs(logs)[0]
    if len(runs) < 2:
        return []
    force = np.array([np.median(run.wrench[:, :3], axis=0) for run in runs])
    named = np.array([run.nominal_dir_t for run in runs])
    force, named = force - force.mean(axis=0), named - named.mean(axis=0)
    if np.linalg.matrix_rank(named, tol=0.5) < 1 or not (force**2).sum() > 0:
        return []

    def misfit(_: int, turn: FloatArray) -> float:
        back = force @ turn
        weight = max(float((back * named).sum() / (named**2).sum()), 0.0)
        return float(((back - weight * named) ** 2).sum())

    return _best_turn((leg,), misfit, misfit(0, np.eye(3)))


def check_mirrored_hanging(leg: str, logs: Sequence[Log]) -> list[Finding]:
    """Find one axis of a hanging transducer that reads with the sign turned.

    ``F = w e + o`` and ``T = w r(φ) × e + o'`` with the named directions e, a weight w > 0 and a
    CoM ``r = r₀ + r₁ sin φ + r₂ cos φ``: the axis is turned back by which both hold. A force along
    an axis that never points along gravity has no sign to be seen.

    Parameters
    ----------
    logs
        Of one leg, in opposite orientations.
    """
    runs = hang_runs(logs)[0]
    parts = np.array([_by_shaft(run) for run in runs])
    wrench, turning = parts[:, 0], parts[:, 1:, 3:]
    named = np.array([run.nominal_dir_t for run in runs])
    if len(np.unique(named.round(2), axis=0)) < _FEWEST_SIDES:
        return []
    arms = np.stack([np.cross(np.eye(3)[k], named).ravel() for k in range(3)], axis=1)
    wrench, named = wrench - wrench.mean(axis=0), named - named.mean(axis=0)
    cross = np.stack([np.cross(np.eye(3)[k], named).ravel() for k in range(3)], axis=1)
    force2 = float((wrench[:, :3] ** 2).sum())
    torque2 = float((wrench[:, 3:] ** 2).sum() + (turning**2).sum())
    if not force2 > 0 or not torque2 > 0:
        return []

    def misfit(signs: FloatArray) -> float:
        force, torque = (wrench * signs)[:, :3], (wrench * signs)[:, 3:]
        weight = max(float((force * named).sum() / (named**2).sum()), 0.0)
        off = float(((force - weight * named) ** 2).sum()) / force2
        left = _unexplained(cross, torque) + sum(
            _unexplained(arms, turning[:, k] * signs[3:]) for k in range(2)
        )
        return off + left / torque2

    given = misfit(np.ones(6))
    tried = sorted((misfit(np.where(np.arange(6) == k, -1.0, 1.0)), k) for k in range(6))
    if given < _MISFIT or tried[0][0] > MUCH_BETTER * given:
        return []
    alike = sorted(k for value, k in tried if value <= max(tried[0][0], 1e-9) / CLEARLY)
    axes = " or ".join(AXES[k] for k in alike)
    return [
        Finding(
            "axis_turned", "alarm", f"{leg}.{axes}",
            f"{axes} of leg {leg} reads with the sign reversed: corrected, "
            f"{tried[0][0] / given:.1%} of the squared misfit remains",
            f"correct the wiring or the axes of leg {leg}, then calibrate again",
        )
    ]  # fmt: skip


def _by_shaft(run: HangRun) -> FloatArray:
    """Wrench of a run as ``a + b sin φ + c cos φ``, shape (3, 6); b = c = 0 where nothing turns."""
    if np.ptp(run.phase_rad) < np.pi:
        return np.stack([np.median(run.wrench, axis=0), np.zeros(6), np.zeros(6)])
    design = np.stack([np.ones(len(run.phase_rad)), *(f(run.phase_rad) for f in (np.sin, np.cos))])
    return np.asarray(np.linalg.lstsq(design.T, run.wrench, rcond=None)[0])


def _unexplained(arms: FloatArray, torque: FloatArray) -> float:
    """Squared torque (n, 3) that no arm explains; `arms` has a column per component (3n, 3)."""
    flat = torque.ravel()
    left = flat - arms @ np.linalg.lstsq(arms, flat, rcond=None)[0]
    return float(left @ left)


def hanging_axes(
    logs: Mapping[str, Sequence[Log]], fits: Mapping[str, HangFit], options: HangOptions
) -> list[Finding]:
    """Axes of turned sign and turned transducers; axes are refitted only where a fit is poor."""
    found: list[Finding] = []
    for leg, own in logs.items():
        turned = check_turned_hanging(leg, own)
        if turned or fits[leg].misfit(hang_runs(own)[0]) > POOR:
            axis = turned_when_hanging(own, options, fits[leg])
            turned = turned if axis is None else [axis.finding()]
        found += turned
    return found


def check_turned_feet(feet: FeetBalance) -> list[Finding]:
    """Find a foot's transducer whose wrenches do not balance the motion, offsets left free."""

    def misfit(foot: int, turn: FloatArray) -> float:
        readings = feet.log.readings.copy()
        for first in (6 * foot, 6 * foot + 3):
            readings[:, first : first + 3] = readings[:, first : first + 3] @ turn
        return float(feet.misfit(readings).sum())

    return _best_turn(feet_of(feet.log), misfit, float(feet.misfit(feet.log.readings).sum()))
