"""``footcal kinematics``: joint positions and a URDF to the body stream of a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import KinematicsOptions

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(KinematicsOptions, lacks=("parameters", "reference", "seed"))
def kinematics(session: Session[KinematicsOptions]) -> Outcome:
    """Compute CoM, its motion and foot poses from joint angles and base orientation."""
    session.refuse_missing_logs("joints")
    from dataclasses import replace

    from footcal_cli.intake.joint_motion import read_motion
    from footcal_cli.sheets.kinematics import findings_of, noise_lines, outcome_of

    options, robot = session.options, session.recipe.robot
    motion = read_motion(session)
    session.note(findings_of(robot, str(options.urdf), motion))
    outcome = outcome_of(robot.name, motion, options.cutoff_hz)
    noise = noise_lines(motion)

    def write(path: Path) -> None:
        path.write_text(noise, encoding="utf-8")

    return replace(outcome, files={"noise.toml": write})
