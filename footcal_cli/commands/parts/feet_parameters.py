"""``parameters.json`` of feet on cells or transducers, of `static-init` and `online-replay`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.session import Session

SIX_AXIS_SIGNS = {
    "static-init": "reading = applied wrench + offset",
    "online-replay": "applied wrench = (1 + scale) * reading - offset",
}
"""Standing leaves scales alone, walking corrects them where the motion tells."""


def feet_parameters(session: Session[Any], estimates: Estimates) -> ParametersRecord:
    """The calibration that the running command has estimated.

    Effects that an earlier calibration contains were undone before the fit; the new one contains
    them still.
    """
    from footcal_cli.records.results import ParametersRecord, covariance_blocks, parameter_records

    robot, command = session.recipe.robot, session.request.command
    six_axis = not any(foot.cells for foot in robot.feet.values())
    parameters, earlier = parameter_records(estimates), session.parameters
    effects = () if earlier is None else earlier.effects
    if earlier is not None and effects:
        parameters = {**earlier.parameters, **parameters}
    return ParametersRecord(
        command=command,
        created=session.created(),
        robot=robot.name,
        gravity_mps2=robot.gravity_mps2,
        sign_convention=(
            SIX_AXIS_SIGNS[command]
            if six_axis
            else "force = scale * counts + bias, positive when the cell is pressed"
        ),
        frame="each transducer's axes" if six_axis else "each cell's own axis",
        expressed_at="the transducer" if six_axis else "the cell",
        parameters=parameters,
        fitted_range={} if earlier is None else earlier.fitted_range,
        effects=effects,
        covariance=covariance_blocks(estimates),
        inputs=session.inputs,
    )
