"""``footcal apply``: a calibration on a log: forces, centres of pressure, foot wrenches."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import ApplyOptions

if TYPE_CHECKING:
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(ApplyOptions, lacks=("reference",))
def apply(session: Session[ApplyOptions]) -> Outcome:
    """Turn a log into calibrated forces, centres of pressure or foot wrenches."""
    robot = session.recipe.robot
    if session.parameters is None:
        raise session.lacks("no calibration given", "give --parameters FILE.json")
    if robot.legs:
        return _wrenches(session)
    if not robot.cell_names:
        cells = tuple(session.parameters.calibrated_cells)
        if not cells:
            raise session.lacks(
                "neither the recipe nor the calibration names load cells, and the recipe no legs",
                "add [robot.legs.…], [robot.feet.…] or channels",
            )
        loose = robot.model_copy(update={"channels": cells})
        session.recipe = session.recipe.model_copy(update={"robot": loose})
    return _forces(session)


def _forces(session: Session[ApplyOptions]) -> Outcome:
    from dataclasses import replace

    from footcal_cli.core.plausibility import check_total_force
    from footcal_cli.intake.forces import SeenForces
    from footcal_cli.session.run_files import set_aside
    from footcal_cli.sheets.forces import outcome_of

    robot, seen = session.recipe.robot, SeenForces()
    with session.step("apply"):
        move = set_aside(seen.forces(session), "calibrated.parquet")
    session.note(check_total_force(seen.total.kept, robot.weight_n, "all cells"))
    found = outcome_of(robot, seen, session.options.min_force_n)
    return replace(found, files={"calibrated.parquet": move})


def _wrenches(session: Session[ApplyOptions]) -> Outcome:
    import numpy as np

    from footcal_cli.core.plausibility import check_total_force
    from footcal_cli.core.pose.mounted import Mounted
    from footcal_cli.core.pose.wrenches import foot_wrenches, naive_wrenches, tare_in_the_air
    from footcal_cli.intake.poses import read_steps
    from footcal_cli.sheets.feet import outcome_of

    with session.step("read"):
        data, legs, along, rejected = read_steps(session)
    with session.step("apply"):
        assert session.parameters is not None, "checked by the caller"
        values = session.parameters.values
        offset = np.stack([leg.offset for leg in legs])
        calibration = Mounted.of(values, data.geometry).feet(data, offset, legs)
        after = foot_wrenches(data, calibration)
        tare = tare_in_the_air(
            data.geometry.rot_bt, offset, calibration.leg_weight_n, calibration.leg_com_m
        )
        before = naive_wrenches(data, tare, calibration.origin_b_m)
    weight_n = session.recipe.robot.weight_n
    session.note(check_total_force(after[..., 2].sum(axis=1), weight_n, "all legs"))
    return outcome_of(
        session.recipe.robot.name, data, along, {"before": before, "after": after}, calibration,
        rejected=rejected, mounted=f"{data.geometry.legs[0]}.mount_rot_x" in values,
    )  # fmt: skip
