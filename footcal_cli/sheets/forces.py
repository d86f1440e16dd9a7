"""`apply` on load cells: the report on the forces of a log."""

from __future__ import annotations

import numpy as np

from footcal_cli.intake.forces import SeenForces
from footcal_cli.plots.forces import FootOutline, along_the_foot, plot_cop_in_feet, plot_forces
from footcal_cli.recipe import Robot
from footcal_cli.records.results import RmseRecord, VerdictRecord
from footcal_cli.report import Picture, Sheet, number
from footcal_cli.report.outcome import Outcome


def outcome_of(robot: Robot, seen: SeenForces, min_force_n: float) -> Outcome:
    """Sum of all forces next to the robot's weight, and the load of each foot."""
    total, lost = seen.total, seen.lost
    actions: tuple[str, ...] = (
        "Add mass_kg to [robot]: the sum of all forces is then compared with the weight.",
    )
    if robot.weight_n is not None:
        actions = ()
    rows = [
        (
            foot,
            number(load.median, 4),
            number(load.largest, 4),
            f"{100 * load.loaded / load.count:.0f}",
        )
        for foot, load in seen.feet.items()
    ]
    return Outcome(
        title=f"Forces of {robot.name}",
        verdict=VerdictRecord(
            level="good",
            sentence=f"{len(robot.cell_names)} cells calibrated over {total.count:,} samples. "
            f"{_sum_words(robot, seen)}",
            actions=actions,
        ),
        pictures=_pictures(robot, seen),
        sheets=(Sheet("Feet", ("foot", "median Fz (N)", "largest Fz (N)", "loaded (%)"), rows),),
        footer=(
            "F = scale · S + bias per cell; CoP = Σ p F / Σ F in the foot frame, absent where "
            f"Fz ≤ {min_force_n:g} N (NAO CoP self-calibration, eqs. (1), (2), (8)).",
        ),
        rmse=RmseRecord(rows=(), rejected={"reading is missing": lost} if lost else {}),
    )


def _sum_words(robot: Robot, seen: SeenForces) -> str:
    """The sum of all forces, and what it should be."""
    weight = "no mass_kg to compare it with"
    if robot.weight_n is not None:
        weight = f"the robot weighs {number(robot.weight_n, 4)} N"
    return f"Sum of all forces {number(seen.total.median, 4)} N (median), {weight}."


def _pictures(robot: Robot, seen: SeenForces) -> tuple[Picture, ...]:
    """Forces over time, and the CoP under each foot that has one."""
    shown = seen.shown
    if not shown:
        return ()
    time_s = shown["time_s"] - shown["time_s"][0]
    names = [f"{foot}_fz_n" for foot in seen.places_m] or [f"{c}_n" for c in robot.cell_names]
    forces = {name.removesuffix("_n").removesuffix("_fz"): shown[name] for name in names}
    cop = {
        foot: np.column_stack([shown[f"{foot}_cop_x_m"], shown[f"{foot}_cop_y_m"]])
        for foot in seen.places_m
    }
    feet = {
        foot: FootOutline(places, robot.feet[foot].outline_m)
        for foot, places in seen.places_m.items()
        if np.isfinite(cop[foot]).any()
    }
    span = f"The first {time_s[-1]:.0f} s of the log. " if seen.total.count > time_s.size else ""
    pictures = [
        Picture(
            "forces", lambda: plot_forces(time_s, forces, robot.weight_n),
            f"{span}Over standing feet the sum should be the robot's weight.",
            title="Vertical force over time",
            result=_sum_words(robot, seen), zoom=True,
        )
    ]  # fmt: skip
    if feet:
        pictures.append(
            Picture(
                "cop", lambda: plot_cop_in_feet({foot: cop[foot] for foot in feet}, feet),
                f"{span}CoP under each foot with its cells and outline; it should stay within "
                "them. Where there is no contact there is no point.",
                title="Centre of pressure under each foot",
                result=along_the_foot({foot: cop[foot] for foot in feet}),
            )
        )  # fmt: skip
    return tuple(pictures)
