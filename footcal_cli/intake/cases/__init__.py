"""Logs and a calibration as the case that `diagnose` takes: a module per experiment with `read`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from footcal_cli.intake.cases.shared import CaseRead
    from footcal_cli.session.session import Session


def read_case(session: Session[DiagnoseOptions]) -> CaseRead:
    """Read the logs of the asked experiment; only its module is imported."""
    from footcal_cli.intake.recordings import is_six_axis_robot

    kind: str = session.options.experiment
    if kind in ("stand", "walk"):
        kind = "six_axis_feet" if is_six_axis_robot(session.recipe.robot) else "cells"
    read: CaseRead = import_module(f"footcal_cli.intake.cases.{kind}").read(session)
    return read
