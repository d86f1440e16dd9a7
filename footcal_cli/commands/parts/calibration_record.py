"""The one place where a command makes a ``parameters.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from footcal_cli.records.results import (
        CovarianceBlock,
        EffectRecord,
        ParameterRecord,
        ParametersRecord,
        Range,
    )
    from footcal_cli.session.session import Session


@dataclass(frozen=True)
class Conventions:
    """How the values of a calibration are meant: signs, axes and point of expression."""

    signs: str
    frame: str
    expressed_at: str


CELLS = Conventions(
    "force = scale * counts + bias, positive when the cell is pressed",
    "each cell's own axis",
    "the cell",
)


def calibration_record(
    session: Session[Any],
    conventions: Conventions,
    parameters: Mapping[str, ParameterRecord],
    *,
    covariance: Sequence[CovarianceBlock] = (),
    fitted_range: Mapping[str, dict[str, Range]] | None = None,
    effects: Sequence[EffectRecord] = (),
    earlier_inputs: Mapping[str, str] | None = None,
) -> ParametersRecord:
    """The calibration that a run leaves; command, robot, date and inputs are the session's."""
    from footcal_cli.records.results import ParametersRecord

    robot = session.recipe.robot
    return ParametersRecord(
        command=session.request.command,
        created=session.created(),
        robot=robot.name,
        gravity_mps2=robot.gravity_mps2,
        sign_convention=conventions.signs,
        frame=conventions.frame,
        expressed_at=conventions.expressed_at,
        parameters=dict(parameters),
        covariance=tuple(covariance),
        fitted_range=dict(fitted_range or {}),
        effects=tuple(effects),
        inputs={**(earlier_inputs or {}), **session.inputs},
    )
