"""The mounting of all transducers from standing poses: what is free, the fit, what judges it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.pose.attitude import find_attitudes
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.departures import ROBOT_WEIGHT, Disagreement
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit, directions_agree, fit_pose
from footcal_cli.core.pose.leg_map import LegMap, leg_map
from footcal_cli.core.pose.model import Structure
from footcal_cli.core.pose.mounted import Mounted
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.selection import Candidate, compare_structures, cross_validated
from footcal_cli.core.pose.slow_noise import SlowNoise, fit_pose_slowly
from footcal_cli.core.pose.standing import OffsetFit, StandingRobot, fit_offsets
from footcal_cli.core.pose.wrenches import leg_coms_t_m

_REFUTED = 16.0
"""Misfit that a free weight must remove: that of 4 sd."""
_MOVED = np.array([50.0] * 3 + [5.0] * 3)
"""Sd, N and Nm, of offsets of which nothing is known any more."""


@dataclass(frozen=True)
class MountingStudy:
    """Everything found of the mounting.

    Parameters
    ----------
    data, legs
        Poses, and what hanging knows as far as it was used.
    fit, slow
        The joint fit, and how its noise lasts from pose to pose.
    candidates
        Structures of the mounting errors, the one that the evidence asks for first.
    held_out
        The fit judged on poses it was not made with.
    mapped
        What each leg's readings predict of the residual.
    refuted
        The robot's weight where the poses contradict it: it is then free, as a prior that is wrong
        would bend the mountings, and make legs seem wrong that are not.
    moved
        Whether the poses contradict the weight only because offsets moved since hanging, and no
        leg is wrong beyond that.
    dropped
        χ² of hanging directions that contradict each other or the poses, see `directions_agree`;
        None where they agree, or were not asked.
    """

    data: PoseData
    legs: tuple[LegKnowledge, ...]
    fit: PoseFit
    slow: SlowNoise
    candidates: tuple[Candidate, ...]
    held_out: Candidate
    mapped: LegMap
    refuted: tuple[Disagreement, ...]
    moved: bool
    dropped: float | None


def study_mounting(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    free: PoseOptions,
    *,
    structure: str,
    translation_sd_m: float | None,
    directions: str,
    folds: int,
) -> MountingStudy:
    """Fit the mounting and judge the fit.

    Parameters
    ----------
    noise_sd
        Of one pose's reading, shape (K, 6).
    free
        Priors, and what is free besides the mounting.
    structure
        Name of a `Structure`, or ``auto``: what the evidence asks for.
    translation_sd_m
        Prior of each hip; None for none.
    directions
        Gravity's directions from hanging: ``use``, ``ignore``, or ``auto`` where they agree.
    """
    free, refuted, moved = _with_weight(data, legs, noise_sd, free)
    legs, dropped = _with_directions(data, legs, noise_sd, free, directions)
    candidates = compare_structures(data, legs, noise_sd, free, folds)
    chosen, prior = candidates[0].structure, translation_sd_m or np.inf
    if structure != "auto":
        chosen = Structure[structure.upper()]
    elif np.isfinite(prior):
        # Hips are never exactly in place: what the evidence does not demand keeps its prior.
        chosen = chosen.with_translations
    final = replace(free, structure=chosen, translation_sd_m=prior)
    fit, slow = fit_pose_slowly(data, legs, noise_sd, final)
    held_out = cross_validated(data, legs, noise_sd, fit, folds)
    # a leg with another gain has other offsets too, and more than those is wrong with it
    judged = fit_pose(summarise(data), _loosened(legs), noise_sd, final) if moved else fit
    mapped = leg_map(data, judged, noise_sd * (1.0 if free.noise_known else judged.noise_factor))
    moved = moved and mapped.suspect is None
    return MountingStudy(
        data, legs, fit, slow, tuple(candidates), held_out, mapped, refuted, moved, dropped
    )


def _loosened(legs: tuple[LegKnowledge, ...]) -> tuple[LegKnowledge, ...]:
    """The legs with offsets of which hanging says nothing any more."""
    return tuple(leg.moved(_MOVED) for leg in legs)


def _with_weight(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, stated: PoseOptions
) -> tuple[PoseOptions, tuple[Disagreement, ...], bool]:
    """Options with the attitudes' scatter; the robot's weight free where the poses refute it.

    They do where it is 4 sd off, and free explains the poses better than offsets that moved
    since hanging would: by the Bayesian information criterion, one number against the six sums.

    Returns
    -------
    options, refuted, moved
        As in `MountingStudy`.
    """
    free = replace(stated, robot_weight_sd_n=data.robot_weight_n)
    found = find_attitudes(data, legs, noise_sd, stated)
    weighed = find_attitudes(data, legs, noise_sd, free)
    kept = replace(stated, attitude_sd_rad=found.sd_rad)
    free = replace(free, attitude_sd_rad=weighed.sd_rad)
    if not np.isfinite(found.misfit) or found.misfit - weighed.misfit < _REFUTED:
        return kept, (), False
    loose = find_attitudes(data, _loosened(legs), noise_sd, stated)
    if loose.misfit + 5.0 * np.log(6.0 * len(data)) < weighed.misfit:
        return kept, (), True
    weight = fit_pose(summarise(data), legs, noise_sd, free).estimates()
    value, sd = float(weight.values[-1]), float(weight.sd[-1])
    apart = abs(value - data.robot_weight_n) / np.hypot(sd, stated.robot_weight_sd_n)
    departure = Disagreement(
        ROBOT_WEIGHT, "N", data.robot_weight_n, stated.robot_weight_sd_n, value, sd, float(apart)
    )
    return free, (departure,), False


def _with_directions(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, free: PoseOptions,
    directions: str,
) -> tuple[tuple[LegKnowledge, ...], float | None]:  # fmt: skip
    """Hanging directions kept where they agree with the poses too; else their misfit."""
    if directions == "use" or not any(leg.gravity_dir_t.size for leg in legs):
        return legs, None
    without = tuple(leg.without_directions() for leg in legs)
    if directions == "ignore":
        return without, None
    fit, freed = (fit_pose(summarise(data), some, noise_sd, free) for some in (legs, without))
    misfit, agree = directions_agree(fit, freed, legs)
    return (legs, None) if agree else (without, misfit)


def refit_offsets(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    mounted: Mounted,
    noise_sd: FloatArray,
    wanted: tuple[float, float],
    *,
    noise_known: bool,
) -> OffsetFit:
    """Offsets again, with mounting, weights and CoM as the last calibration has them.

    Parameters
    ----------
    wanted
        Sd of forces and torques that is asked for, N and N·m.
    """
    weights = np.array([leg.weight_n for leg in legs])
    robot = StandingRobot(
        mounted.rot_bt,
        mounted.arm_b_m,
        weights,
        data.robot_weight_n - weights.sum(),
        leg_coms_t_m(tuple(leg.com_m for leg in legs), data.phase_rad),
        np.stack([leg.offset for leg in legs]),
        np.stack([np.sqrt(np.diag(leg.covariance)[:6]) for leg in legs]),
    )
    found = fit_offsets(data, robot, noise_sd, wanted)
    if not noise_known and found.accepted:
        found = fit_offsets(data, robot, noise_sd * found.noise_factor, wanted)
    return found


def offset_estimates(found: OffsetFit, legs: tuple[str, ...]) -> Estimates:
    """Offsets of all legs with their joint covariance."""
    axes = ("fx", "fy", "fz", "tx", "ty", "tz")
    return Estimates(
        tuple(f"{leg}.offset_{axis}" for leg in legs for axis in axes),
        (("N",) * 3 + ("Nm",) * 3) * len(legs),
        found.offset.ravel(),
        found.covariance,
        (Status.ESTIMATED,) * found.offset.size,
    )
