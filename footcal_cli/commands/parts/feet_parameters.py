"""``parameters.json`` of feet on cells or transducers, of `static-init` and `online-replay`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.session.session import Session

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
    from footcal_cli.commands.parts.calibration_record import CELLS, Conventions, calibration_record
    from footcal_cli.records.results import covariance_blocks, parameter_records

    six_axis = not any(foot.cells for foot in session.recipe.robot.feet.values())
    parameters, earlier = parameter_records(estimates), session.parameters
    effects = () if earlier is None else earlier.effects
    if earlier is not None and effects:
        parameters = {**earlier.parameters, **parameters}
    conventions = CELLS
    if six_axis:
        signs = SIX_AXIS_SIGNS[session.request.command]
        conventions = Conventions(signs, "each transducer's axes", "the transducer")
    return calibration_record(
        session,
        conventions,
        parameters,
        fitted_range={} if earlier is None else earlier.fitted_range,
        effects=effects,
        covariance=covariance_blocks(estimates),
    )
