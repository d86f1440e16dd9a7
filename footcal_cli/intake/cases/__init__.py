"""Logs and a calibration as the case that `diagnose` takes, an experiment a module."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.intake.cases.cells import read_feet
from footcal_cli.intake.cases.hang import read_hang
from footcal_cli.intake.cases.placements import read_placements
from footcal_cli.intake.cases.pose import read_pose
from footcal_cli.intake.cases.shared import CaseRead
from footcal_cli.intake.cases.six_axis_feet import read_six_axis_feet
from footcal_cli.intake.cases.weights import read_weights
from footcal_cli.intake.recordings import is_six_axis_robot
from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


def read_case(session: Session[DiagnoseOptions]) -> CaseRead:
    """Read the logs of the asked experiment."""
    on_feet = read_six_axis_feet if is_six_axis_robot(session.recipe.robot) else read_feet
    builders = {
        "weights": read_weights,
        "placements": read_placements,
        "walk": on_feet,
        "stand": on_feet,
        "hang": read_hang,
        "pose": read_pose,
    }
    return builders[session.options.experiment](session)
