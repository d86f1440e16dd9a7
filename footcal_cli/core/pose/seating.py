"""Hip transducers that sit elsewhere, or otherwise, than the recipe says.

A mounting error is some degrees and millimetres. What a fit needs beyond that is no mounting error:
a transducer turned by a right angle or two, an axis of turned sign, a plug in another leg's socket.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, PoseSummary, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit, fit_pose, misfits_of_poses
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.turned import (
    CLEARLY,
    MOST_STEPS,
    MUCH_BETTER,
    ROUGH_STEPS,
    TURNS,
    near_the_best,
    said_of,
    turned_when_standing,
    words_of,
)
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import skew

TURNED_NOISE = 3.0
"""A turned transducer leaves 5 to 50 times the noise of a pose: nearer to it, none is looked for,
since each of the 23 turns of each leg costs a fit."""
BEYOND = 10.0
"""Times the prior sd of a hip's place, beyond which a shift is no mounting error."""
SURE = 3.0
"""Standard deviations by which a mounting must be beyond what is a mounting error."""
USUAL_PLACE_SD_M = 0.005
_WEIGHED_SHARE = 0.05
"""Sd of the robot's weight: a recipe's wrong mass must not pass for a turned transducer."""


def standing_axes(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    com_sd_m: float,
    place_sd_m: float | None,
) -> list[Finding]:
    """An axis of turned sign, a transducer that is turned, else legs that sit elsewhere.

    Asked with ordinary priors, whatever a calibration leaves free.

    Parameters
    ----------
    com_sd_m, place_sd_m
        Prior sd of the chassis' CoM and of each hip; None: nothing is believed of the hips.
    """
    options = PoseOptions(
        com_sd_m=com_sd_m, translation_sd_m=place_sd_m or USUAL_PLACE_SD_M,
        robot_weight_sd_n=_WEIGHED_SHARE * data.robot_weight_n,
    )  # fmt: skip
    axis = turned_when_standing(data, legs, noise_sd, options)
    if axis is not None:
        return [axis.finding()]
    means = summarise(data)
    fit = fit_pose(means, legs, noise_sd, options)
    turned = check_turned_standing(data, legs, noise_sd, options, fit)
    limit = np.inf if place_sd_m is None else place_sd_m
    if turned or not check_seating(fit, limit):
        return turned
    # noise that is larger than it is taken for overrules the priors: its level is learnt
    learnt = replace(options, noise_known=False)
    return check_seating(fit_pose(means, legs, noise_sd, learnt), limit)


def check_turned_standing(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions,
    given: PoseFit | None = None,
) -> list[Finding]:
    """Find a hip transducer that was turned after hanging: the chassis then balances nowhere.

    Its offsets stay with its channels where it was mounted otherwise, and turn with them where
    only their names or signs changed; both are tried.

    Parameters
    ----------
    given
        The fit of the data as they are, if it is known already.
    """
    summary = summarise(data)
    given = given or fit_pose(summary, legs, noise_sd, options)
    if given.noise_factor < TURNED_NOISE:
        return []
    tried = [
        (_turned_back(summary, legs, k, turn, offsets=offsets), k, i)
        for k in range(len(legs)) for i, turn in enumerate(TURNS) for offsets in (False, True)
    ]  # fmt: skip

    beyond = MUCH_BETTER / CLEARLY * given.chi2_poses

    misfit = misfits_of_poses(summary, legs, noise_sd, options)

    def roughly(one: tuple[FloatArray, int, int]) -> float:
        return misfit(one[0], beyond, ROUGH_STEPS)

    near = near_the_best(tried, roughly, given.chi2_poses)
    fitted = [(misfit(back, beyond, MOST_STEPS), k, i) for back, k, i in near]
    return said_of(data.geometry.legs, fitted, given.chi2_poses) if fitted else []


def _turned_back(
    summary: PoseSummary,
    legs: Sequence[LegKnowledge],
    leg: int,
    turn: FloatArray,
    *,
    offsets: bool,
) -> FloatArray:
    """Gram matrix with one transducer turned back, its offsets too or where they are."""
    change = np.eye(summary.gram.shape[0])
    rows = slice(6 * leg, 6 * leg + 6)
    both = np.kron(np.eye(2), turn.T)
    change[rows, rows] = both
    if not offsets:
        change[rows, -1] = legs[leg].offset - both @ legs[leg].offset
    return change @ summary.gram @ change.T


def check_seating(fit: PoseFit, place_sd_m: float) -> list[Finding]:
    """Legs whose fitted mounting is, by more than `SURE` sd, no mounting error.

    A turn is none where another of the 24 right-angled mountings is nearer than the recipe's; a
    shift against the median leg's is none where another leg's hip is nearer than its own, or from
    `BEYOND` prior sd on.
    """
    geometry = fit.geometry
    legs = len(geometry.legs)
    shift = fit.arm_b_m - (geometry.hip_b_m - geometry.chassis_com_b_m)
    own = shift - np.median(shift, axis=0)  # what all share is the chassis' CoM
    right_angled = np.array([np.eye(3), *TURNS])
    found: list[Finding] = []
    exchanged: list[Finding] = []
    for k, leg in enumerate(geometry.legs):
        nominal = geometry.rot_bt[k]
        turned_t = nominal.T @ np.concatenate([np.eye(3)[None], skew(np.eye(3))])
        turned_t = turned_t @ fit.mounting.turn_b[k] @ nominal  # itself, and by each body axis
        closeness = np.einsum("nij,tij->nt", right_angled, turned_t)
        nearest = int(np.argmax(closeness[:, 0]))
        nearer = closeness[nearest] - closeness[0]
        at = slice(3 * k, 3 * k + 3)
        if nearer[0] > SURE * _sd(nearer[1:], fit.covariance[at, at]):
            angle = float(np.arccos(np.clip((closeness[0, 0] - 1.0) / 2.0, -1.0, 1.0)))
            found.append(_turned(leg, right_angled[nearest], angle))
        against = np.kron(np.eye(legs)[k] - 1.0 / legs, np.eye(3))
        spread = against @ fit.covariance[3 * legs : 6 * legs, 3 * legs : 6 * legs] @ against.T
        to = geometry.hip_b_m[k] + own[k] - geometry.hip_b_m
        away = np.linalg.norm(to, axis=1)
        along = to / np.maximum(away, np.finfo(float).tiny)[:, None]
        sd, other = _sd(along[k], spread), int(np.argmin(away))
        if away[k] - away[other] > SURE * _sd(along[k] - along[other], spread):
            exchanged.append(_elsewhere(geometry.legs, k, other, float(away[k]), sd))
        elif away[k] - BEYOND * place_sd_m > SURE * sd:
            found.append(_elsewhere(geometry.legs, k, k, float(away[k]), sd))
    return exchanged or found  # exchanged plugs push the other legs away, too


def _sd(slope: FloatArray, covariance: FloatArray) -> float:
    return float(np.sqrt(max(float(slope @ covariance @ slope), 0.0)))


def _turned(leg: str, turn: FloatArray, angle_rad: float) -> Finding:
    return Finding(
        "transducer_turned", "alarm", leg,
        f"the transducer of {leg} balances the others only if it is turned by "
        f"{np.rad2deg(angle_rad):.0f}° against the recipe, nearest to {words_of(turn)}: no "
        "mounting error is so large",
        f"check the plug of {leg}, or turn its frame by {words_of(turn)} in the recipe "
        f"(rotation_rpy_rad of [robot.legs.{leg}]); then calibrate again",
    )  # fmt: skip


def _elsewhere(names: Sequence[str], leg: int, other: int, away_m: float, sd_m: float) -> Finding:
    mine, there = names[leg], names[other]
    where = "" if other == leg else f", near that of {there}"
    plugs = mine if other == leg else f"{mine} and which to {there}"
    return Finding(
        "leg_elsewhere", "alarm", mine,
        f"leg {mine} carries its load {1000 * away_m:.0f} ± {1000 * sd_m:.0f} mm away from its hip"
        f"{where}: no mounting error is so large",
        f"check which plug belongs to {plugs}, and position_m of [robot.legs.{mine}]; then "
        "calibrate again",
    )  # fmt: skip
