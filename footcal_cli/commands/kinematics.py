"""``footcal kinematics``: joint positions and a URDF to the body stream of a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import KinematicsOptions

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(KinematicsOptions, lacks=("parameters", "reference", "strict_findings", "seed"))
def kinematics(session: Session[KinematicsOptions]) -> Outcome:
    """Compute CoM, its motion and foot poses from joint angles and base orientation."""
    session.refuse_missing_logs("joints")
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.kinematics import accelerations, standing_base
    from footcal_cli.core.signals import check_clock
    from footcal_cli.errors import DataError, UsageError
    from footcal_cli.intake.joints import base_of, feet_frames, joints_of, read_joints
    from footcal_cli.intake.rigid_body import read_urdf
    from footcal_cli.sheets.kinematics import findings_of, noise_lines, outcome_of

    options, robot = session.options, session.recipe.robot
    if options.urdf is None:
        raise UsageError("no URDF given", remedy="give --urdf FILE.urdf, or urdf in [kinematics]")
    path = Path(options.urdf)
    if not path.is_absolute() and not path.is_file() and session.recipe.path is not None:
        path = session.recipe.path.parent / path
    with session.step("read"):
        body = read_urdf(path)
        feet = feet_frames(session, body)
        log = read_joints(session, body, tuple(feet))
        positions = joints_of(log, body, options)
        base_m, turned = base_of(log)
    stamps = log.number("time_s")
    keep = check_clock(stamps).keep
    if keep.size < 4:
        raise DataError(
            f"{keep.size} rows with increasing stamps are too few", file=log.path,
            remedy="check the unit of time_s, or record longer",
        )  # fmt: skip
    time_s = stamps[keep]
    start = np.zeros((keep.size, 3)) if base_m is None else base_m[keep]
    with session.step("kinematics"):
        posture = body.posture(
            time_s, start, turned[keep], {n: p[keep] for n, p in positions.items()},
            list(feet.values()),
        )  # fmt: skip
        if not np.isfinite(posture.com_m).all(axis=1).any():
            lost = [n for n, p in positions.items() if not np.isfinite(p).any()]
            raise DataError(
                "in no row are all joints and the base known"
                + (f"; without a reading: {', '.join(lost)}" if lost else ""), file=log.path,
                remedy="fill the columns that are empty",
            )  # fmt: skip
        if base_m is None:
            fixed = None if options.anchor is None else list(feet).index(options.anchor)
            posture = posture.moved(standing_base(posture.feet_m, fixed))
        found = accelerations(time_s, posture, options.cutoff_hz)
    loads = [f"{foot}_fz_n" for foot in feet]
    carried_n = None
    if all(column in log for column in loads):
        carried_n = float(np.nanmean(log.numbers(loads).sum(axis=1)))
    name, urdf = log.path.name, options.urdf
    session.note(
        findings_of(
            robot, urdf, name, body.mass_kg, carried_n, posture, found, known=base_m is not None
        )
    )
    outcome = outcome_of(
        robot.name, name, body.mass_kg, time_s, posture, found, tuple(feet), options.cutoff_hz
    )
    noise = noise_lines(body.mass_kg, posture, found)

    def write(path: Path) -> None:
        path.write_text(noise, encoding="utf-8")

    return replace(outcome, files={"noise.toml": write})
