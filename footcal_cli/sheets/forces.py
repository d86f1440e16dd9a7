"""`apply` on load cells: the report on the forces of a log."""

from __future__ import annotations

from footcal_cli.core.signals import Seen
from footcal_cli.recipe import Robot
from footcal_cli.records.results import RmseRecord, VerdictRecord
from footcal_cli.report import Sheet, number
from footcal_cli.report.outcome import Outcome


def outcome_of(
    robot: Robot, total: Seen, feet: dict[str, Seen], lost: int, min_force_n: float
) -> Outcome:
    """Sum of all forces next to the robot's weight, and the load of each foot."""
    weight = "no mass_kg to compare it with"
    actions: tuple[str, ...] = (
        "Add mass_kg to [robot]: the sum of all forces is then compared with the weight.",
    )
    if robot.weight_n is not None:
        weight = f"the robot weighs {number(robot.weight_n, 4)} N"
        actions = ()
    rows = [
        (
            foot,
            number(seen.median, 4),
            number(seen.largest, 4),
            f"{100 * seen.loaded / seen.count:.0f}",
        )
        for foot, seen in feet.items()
    ]
    return Outcome(
        title=f"Forces of {robot.name}",
        verdict=VerdictRecord(
            level="good",
            sentence=f"{len(robot.cell_names)} cells calibrated over {total.count:,} samples; sum "
            f"of all forces {number(total.median, 4)} N (median), {weight}.",
            actions=actions,
        ),
        sheets=(Sheet("Feet", ("foot", "median Fz (N)", "largest Fz (N)", "loaded (%)"), rows),),
        footer=(
            "F = scale · S + bias per cell; CoP = Σ p F / Σ F in the foot frame, absent where "
            f"Fz ≤ {min_force_n:g} N (NAO CoP self-calibration, eqs. (1), (2), (8)).",
        ),
        rmse=RmseRecord(rows=(), rejected={"reading is missing": lost} if lost else {}),
    )
