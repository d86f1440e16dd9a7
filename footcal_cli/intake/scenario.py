"""What `simulate` is asked for: robot, effects, plans, a recorded motion; and the truth of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import PlacementsPlan, WeightsPlan
from footcal_cli.core.simulation.biped_logs import StandPlan
from footcal_cli.core.simulation.gait import WalkPlan
from footcal_cli.core.simulation.hexapod_logs import HangPlan, PosePlan
from footcal_cli.core.simulation.recorded import motion_columns
from footcal_cli.core.simulation.robots import Biped, Hexapod, leg_at
from footcal_cli.core.simulation.scenario import ON_CELLS, EffectRequest, Plans, Scenario
from footcal_cli.errors import UsageError, nearest
from footcal_cli.recipe.options import SimulateOptions
from footcal_cli.records.effects import known_effect, record_of_effect
from footcal_cli.records.results import TruthRecord
from footcal_cli.tables.columns import Column, TableType

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


def parse_effect(text: str, table: Mapping[str, Effect]) -> EffectRequest:
    """``[OWNER.]NAME[=VALUE][,PARAMETER=VALUE ...]`` as a request.

    Raises
    ------
    UsageError
        Unknown effect or parameter (names the nearest), or not a number.
    """
    head, *rest = text.split(",")
    full_name, given, size = head.partition("=")
    owner, dot, name = full_name.strip().rpartition(".")
    effect = known_effect(name, table)
    values = {effect.size.name: _number(size, head) if given else _usual_size(effect)}
    known = {p.name for p in effect.parameters}
    for item in rest:
        parameter, _, value = item.partition("=")
        if parameter.strip() not in known:
            raise UsageError(
                f"{name} has no parameter '{parameter.strip()}'{nearest(parameter.strip(), known)}",
                remedy=f"it has {', '.join(sorted(known))}",
            )
        values[parameter.strip()] = _number(value, item)
    return EffectRequest(effect, owner if dot else None, values)


def _usual_size(effect: Effect) -> float:
    """The size of an effect that was asked for without one: whole faults whole, else its sd."""
    size = effect.size
    whole = (size.lower, size.neutral, size.upper) == (0.0, 0.0, 1.0)
    return 1.0 if whole else size.neutral + size.prior_sd


def _number(text: str, item: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"'{item}': not a number", value=text, remedy="write NAME=VALUE in the table's unit"
        ) from None


def robot_of(session: Session[SimulateOptions], experiment: str) -> Biped | Hexapod:
    """The recipe's robot; without a recipe a NAO-like biped or a BigAnt-like hexapod."""
    spec = session.recipe.robot
    if experiment in ON_CELLS:
        default = Biped(com_height_m=session.options.com_height_m)
        if not spec.feet and session.recipe.path is None:
            return default
        feet = {
            foot: {name: (cell.x_m, cell.y_m) for name, cell in part.cells.items()}
            for foot, part in spec.feet.items()
        }
        if len(feet) != 2 or not all(len(cells) >= 3 for cells in feet.values()):
            raise UsageError(
                f"'{experiment}' needs two feet with three or more cells each",
                file=session.recipe.path, remedy="give [robot.feet.left.cells] and right",
            )  # fmt: skip
        counts = 2**spec.adc.bits
        return Biped(
            feet=feet,
            mass_kg=spec.mass_kg or default.mass_kg,
            gravity_mps2=spec.gravity_mps2,
            com_height_m=session.options.com_height_m,
            scale_n_per_count=spec.nameplate.scale_n_per_count or default.scale_n_per_count,
            zero_counts=default.zero_counts / default.adc_counts * counts,
            adc_counts=counts,
        )
    if not spec.legs and session.recipe.path is None:
        return Hexapod()
    if len(spec.legs) < 3:
        raise UsageError(
            f"'{experiment}' needs three or more legs with transducers",
            file=session.recipe.path, remedy="give [robot.legs.<name>] with position_m",
        )  # fmt: skip
    return Hexapod(
        legs={
            name: leg_at(name, session.recipe.hip_position_m(name), leg.rotation_rpy_rad)
            for name, leg in spec.legs.items()
        },
        mass_kg=spec.mass_kg or Hexapod().mass_kg,
        gravity_mps2=spec.gravity_mps2,
    )


def plans_of(session: Session[SimulateOptions]) -> Plans:
    """How the experiments go; a hanging's orientations mean what ``[hang_calib]`` says."""
    options = session.options
    hanging = session.recipe.options.get("hang_calib", {})
    return Plans(
        weights=WeightsPlan(sessions=options.sessions),
        placements=PlacementsPlan(repeats=options.repeats),
        stand=StandPlan(stances=options.stances, one_foot=options.one_foot_stances),
        walk=WalkPlan(
            duration_s=options.duration_s,
            speed_mps=options.speed_mps,
            turn_radps=options.turn_radps,
            variation_seed=session.request.seed,
        ),
        hang=HangPlan(
            cycles=options.cycles,
            orientation_of=hanging.get("orientation_of", "transducer"),
        ),
        pose=PosePlan(poses=options.poses, tripods=options.tripods),
    ).with_noise(options.noise)


def motion_of(
    session: Session[SimulateOptions], robot: Biped | Hexapod
) -> dict[str, FloatArray] | None:
    """The columns of a recorded motion, None where the motion is planned."""
    if not session.paths("motion"):
        return None
    if not isinstance(robot, Biped) or session.options.experiment not in ("stand", "walk"):
        raise UsageError(
            "a recorded motion serves the experiments stand and walk only",
            remedy="leave the motion out, or add --experiment walk",
        )
    names = motion_columns(robot)
    table = TableType("motion", tuple(Column(name, "motion and true loads") for name in names))
    (read, *more) = session.read_required(table, role="motion")
    if more:
        raise UsageError("one recorded motion at a time", remedy="name one file")
    columns = {name: read.number(name) for name in names}
    return columns | {"time_s": columns["time_s"] - columns["time_s"][0]}


def truth_of(
    session: Session[SimulateOptions], scenario: Scenario, plans: Plans, robot: Biped | Hexapod
) -> TruthRecord:
    """``truth.json``: every parameter that the logs were distorted with."""
    assert session.options.experiment is not None
    on_cells = isinstance(robot, Biped)
    streams = asdict(plans.streams)
    noise = _flat(streams.pop("cell_noise")) if on_cells else {}
    if not on_cells:
        noise = {
            f"{kind}_{name}": value
            for kind, sizes in (
                ("force", plans.hang.force_noise),
                ("torque", plans.hang.torque_noise),
            )
            for name, value in _flat(asdict(sizes)).items()
        }
    return TruthRecord(
        experiment=session.options.experiment,
        seed=session.request.seed,
        robot=asdict(robot),
        parameters=dict(scenario.values),
        effects=tuple(
            record_of_effect(item.effect, item.owners, session.recipe.effect)
            for item in scenario.chain.links
        ),
        noise=noise,
        details={
            "effects_asked_for": list(session.options.effects),
            "streams": streams if on_cells else {},
            "options": session.options.model_dump(mode="json"),
        },
    )


def _flat(sizes: Mapping[str, float]) -> dict[str, float]:
    return {name: float(value) for name, value in sizes.items()}
