"""Standing poses on hip transducers as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.six_axis_beliefs import BODY_TILT
from footcal_cli.core.experiments.pose import EXPERIMENT
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet
from footcal_cli.core.pose.common import common_turn
from footcal_cli.core.pose.data import Geometry, pose_data
from footcal_cli.core.pose.seating import standing_axes
from footcal_cli.core.quality import Finding
from footcal_cli.intake.cases.shared import CaseRead, baseline_of, chain_of, in_order, of_cells
from footcal_cli.intake.legs import without_effects
from footcal_cli.intake.poses import noise_sd_of, raw_poses
from footcal_cli.recipe.options import DiagnoseOptions, PoseCalibOptions

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


_RCOND = 1e-12
POSE_S = 60.0
"""A pose takes about a minute: usual drifts are known per second."""
POSES_PER_BLOCK = 4
FEWEST_PER_BLOCK, ENOUGH_BLOCKS = 2, 10
"""Of few poses, as few share a block as leave blocks enough to identify a cause."""
MOST_BLOCKS = 24


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log; a block is some poses in a row, errors of the wrenches are errors in variables."""
    recipe = session.recipe
    asked = recipe.options_for(PoseCalibOptions, "pose_calib")
    raw, legs, _ = raw_poses(session, asked)
    log = replace(raw, block=pose_blocks(len(raw)))
    chain, values, free, beyond = _model(session, log.channels)
    weight_n = float(log.known["robot_weight_n"][0])
    case = Case(
        experiment=EXPERIMENT,
        logs=(log,),
        chain=chain,
        values=values,
        calibration=ParameterSet(free),
        tolerance_n=session.options.tolerance_n or 0.002 * weight_n,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * weight_n,
        alike=False,
    )
    data = pose_data(without_effects(raw, session.parameters))
    hung = zip(data.geometry.legs, legs, strict=True)
    case = with_known_offsets(case, {name: leg.covariance[:6, :6] for name, leg in hung})
    # hanging knows a leg as it hung: what is screwed on before it stands is a rival of the robot's
    # weight, however well the leg was weighed
    untested = of_cells(EXPERIMENT)
    untested[BODY_TILT.name] = _tilt_or_mountings(data.geometry, values)
    sd, _ = noise_sd_of(asked, len(legs), data.robot_weight_n)
    seen = standing_axes(data, legs, sd, asked.com_sd_m, asked.translation_sd_m)
    # what else is wrong may have driven the mountings there
    return CaseRead(case, seen or beyond, untested, in_order(EXPERIMENT, "pose", POSE_S))


def with_known_offsets(case: Case, hung: Mapping[str, FloatArray]) -> Case:
    """The case with the precision of its offsets from hanging; nothing is known of the mountings.

    Offsets move a little before the robot stands: ``C_k + m²``, where the sum over all legs of
    moves of sd m is as large as what matters.

    Parameters
    ----------
    hung
        Leg -> covariance C of its offset, shape (6, 6), N and Nm.
    """
    names = case.calibration.names
    precision = np.zeros((len(names), len(names)))
    moves = np.repeat([case.tolerance_n, case.tolerance_nm], 3) / np.sqrt(len(hung))
    for leg, covariance in hung.items():
        at = [names.index(f"{leg}.offset_{axis}") for axis in AXES]
        precision[np.ix_(at, at)] = scaled_inverse(covariance + np.diag(moves**2), _RCOND)
    return replace(case, known=precision)


def _tilt_or_mountings(geometry: Geometry, values: Mapping[str, float]) -> str:
    """Why a tilted body frame cannot be tested, and what the calibrated mountings share."""
    reason = "no pose distinguishes it from a rotation of all mountings, which is calibrated"
    nominal_t = np.array(
        [[values.get(f"{leg}.mount_rot_{axis}", 0.0) for axis in "xyz"] for leg in geometry.legs]
    )
    common = common_turn(np.einsum("kij,kj->ki", geometry.rot_bt, nominal_t))
    if common is None or not common.stands_out:
        return reason
    return f"{reason}: {common.words}, which is the one or the other"


def pose_blocks(poses: int) -> IntArray:
    """Poses in a row share a block: what differs from day to day stays together."""
    enough = min(poses // FEWEST_PER_BLOCK, ENOUGH_BLOCKS)
    blocks = int(np.clip(poses // POSES_PER_BLOCK, max(enough, 1), MOST_BLOCKS))
    return np.asarray(np.arange(poses) * blocks // poses, dtype=np.int64)


def _model(
    session: Session[DiagnoseOptions], channels: Sequence[str]
) -> tuple[Chain, dict[str, float], tuple[Parameter, ...], list[Finding]]:
    """Chain, its values, what of it is calibrated, and which of that no mounting error is.

    From such a value nothing starts: the recipe's mounting stands in for it.
    """
    # what `pose-calib` estimates, whether the calibration given has it already or not
    calibrated = EXPERIMENT.calibration
    chain, values = chain_of(baseline_of(session), channels, calibrated)
    names = [item.names() for item in chain.links if item.effect.name in calibrated]
    free = [p for p in chain.parameters() if any(p.name in own for own in names)]
    beyond = [_beyond(p, values[p.name]) for p in free
              if not p.lower <= values.get(p.name, p.value) <= p.upper]  # fmt: skip
    values = {**values, **{p.name: p.value for p in free if p.name in {f.where for f in beyond}}}
    free = [replace(p, value=values.get(p.name, p.value)) for p in free]
    return chain, values, tuple(free), beyond


def _beyond(parameter: Parameter, value: float) -> Finding:
    """A calibrated value that no mounting error has."""
    return Finding(
        "leg_elsewhere", "alarm", parameter.name,
        f"{parameter.name} is {value:.3g} {parameter.unit}, beyond {parameter.lower:g} to "
        f"{parameter.upper:g} {parameter.unit}: that leg sits elsewhere than the recipe says",
        "check which plug belongs to which leg, and position_m in [robot.legs]",
    )  # fmt: skip
