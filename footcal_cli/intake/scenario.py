"""What `simulate` is asked for: robot, effects, plans, a recorded motion; and the truth of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, get_args

import numpy as np

from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.log import ExperimentName
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import PlacementsPlan, WeightsPlan
from footcal_cli.core.simulation.biped_logs import StandPlan, Streams
from footcal_cli.core.simulation.gait import WalkPlan
from footcal_cli.core.simulation.hexapod_logs import HangPlan, PosePlan
from footcal_cli.core.simulation.plans import Plans, Spread
from footcal_cli.core.simulation.recorded import motion_columns
from footcal_cli.core.simulation.robots import (
    NAO_ANKLE_M,
    NAO_CELLS,
    NAO_COM_HEIGHT_M,
    NAO_HALF_WIDTH_M,
    Ankle,
    Biped,
    Hexapod,
    leg_at,
)
from footcal_cli.core.simulation.scenario import ON_FEET, EffectRequest, Scenario
from footcal_cli.errors import UsageError, nearest
from footcal_cli.intake.recordings import is_six_axis_robot
from footcal_cli.recipe import Foot, Robot
from footcal_cli.recipe.options import SimulateOptions
from footcal_cli.records.effects import known_effect, record_of_effect
from footcal_cli.records.results import TruthRecord
from footcal_cli.tables.columns import Column, TableType

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_FEWEST_LEGS, _FEWEST_CELLS, _BOTH = 3, 3, 2
_LEAST_M = 1e-3
"""Cells that lie closer to one line than this lie in it."""
_BETWEEN_M = 0.01
"""Between two feet side by side."""


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
    """The recipe's robot; without a recipe a NAO-like biped or a BigAnt-like hexapod.

    Raises
    ------
    UsageError
        The robot cannot do the experiment; says why, and what it can.
    """
    recipe = session.recipe
    if recipe.path is None and not (recipe.robot.feet or recipe.robot.legs):
        usual = Biped(com_height_m=session.options.com_height_m or NAO_COM_HEIGHT_M)
        return usual if experiment in ON_FEET else Hexapod()
    why = _what_it_lacks(recipe.robot, experiment)
    if why:
        able = [kind for kind in get_args(ExperimentName) if not _what_it_lacks(recipe.robot, kind)]
        raise UsageError(
            f"'{experiment}' needs {why}", file=recipe.path,
            remedy=f"this robot can do {', '.join(able)}" if able else "describe the robot "
            "in [robot.feet.<name>] or [robot.legs.<name>]",
        )  # fmt: skip
    if experiment in ON_FEET:
        return _on_feet(session)
    spec = recipe.robot
    return Hexapod(
        legs={
            name: leg_at(name, recipe.hip_position_m(name), leg.rotation_rpy_rad)
            for name, leg in spec.legs.items()
        },
        mass_kg=spec.mass_kg or Hexapod().mass_kg,
        gravity_mps2=spec.gravity_mps2,
    )


def _what_it_lacks(robot: Robot, experiment: str) -> str:
    """What a robot needs for an experiment and does not have; empty where it can do it."""
    if experiment not in ON_FEET:
        return "three or more legs with transducers" if len(robot.legs) < _FEWEST_LEGS else ""
    if experiment == "weights":
        return "" if robot.cell_names else "load cells"
    carried = [_spans_a_plane(foot) for foot in robot.feet.values()]
    if experiment == "placements":
        return "" if carried and all(carried) else "feet on three or more cells, not in one line"
    six_axis = is_six_axis_robot(robot)
    if len(robot.feet) != _BOTH or not (six_axis or all(carried)):
        return "two feet, each on three or more cells that are not in one line, or on a transducer"
    return ""


def _spans_a_plane(foot: Foot) -> bool:
    """Whether a foot's CoP can move both ways."""
    places = np.array([(cell.x_m, cell.y_m) for cell in foot.cells.values()]).reshape(-1, 2)
    if len(places) < _FEWEST_CELLS:
        return False
    return bool(np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[1] > _LEAST_M)


def _on_feet(session: Session[SimulateOptions]) -> Biped:
    """The recipe's biped: what it states, and the rest in the proportions of a NAO."""
    spec, usual, plate = session.recipe.robot, Biped(), session.recipe.robot.nameplate
    robot = replace(
        usual, mass_kg=spec.mass_kg or usual.mass_kg, gravity_mps2=spec.gravity_mps2,
        adc_counts=2**spec.adc.bits,
    )  # fmt: skip
    middle = usual.zero_counts / usual.adc_counts * robot.adc_counts
    known = plate.scale_n_per_count is not None or "zero_counts" in plate.model_fields_set
    feet = {
        foot: {name: (cell.x_m, cell.y_m) for name, cell in part.cells.items()}
        for foot, part in spec.feet.items()
    }
    ankles = {}
    if is_six_axis_robot(spec):
        feet = {foot: _sole(part, robot.length) for foot, part in spec.feet.items()}
        ankles = {foot: _ankle(part, robot.length) for foot, part in spec.feet.items()}
    widest = max((abs(y) for cells in feet.values() for _, y in cells.values()), default=0.0)
    return replace(
        robot,
        feet=feet,
        ankles=ankles,
        loose=() if feet else spec.cell_names,
        com_height_m=session.options.com_height_m or NAO_COM_HEIGHT_M * robot.length,
        half_width_m=max(NAO_HALF_WIDTH_M * robot.length, widest + _BETWEEN_M),
        scale_n_per_count=plate.scale_n_per_count or usual.scale_n_per_count,
        zero_counts=plate.zero_counts if known else middle,
    )


def _sole(foot: Foot, length: float) -> dict[str, tuple[float, float]]:
    """Corners of a sole: its outline, or that of a NAO of this size."""
    if len(foot.outline_m) >= _FEWEST_CELLS:
        return {str(i): corner for i, corner in enumerate(foot.outline_m)}
    return {name: (length * x, length * y) for name, (x, y) in NAO_CELLS.items()}


def _ankle(foot: Foot, length: float) -> Ankle:
    """A transducer; a foot whose frame is that of its ankle has it above the sole."""
    ankle = Ankle(
        foot.transducer_position_m or (0.0, 0.0, 0.0), foot.transducer_rotation_rpy_rad,
        foot.weight_below_n, foot.com_below_m,
    )  # fmt: skip
    above = float((ankle.rot_flat @ np.array(ankle.position_m))[2])
    return replace(ankle, frame_height_m=0.0 if above > 0 else NAO_ANKLE_M * length)


def plans_of(session: Session[SimulateOptions], robot: Biped | Hexapod) -> Plans:
    """How the experiments go; delays and the meaning of orientations are as the recipe states."""
    options, tables = session.options, session.recipe.options
    stated = tables.get("static_init" if options.experiment == "stand" else "online_replay", {})
    late_s = Streams().body_delay_s if session.recipe.path is None else 0.0
    plans = Plans(
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
            orientation_of=tables.get("hang_calib", {}).get("orientation_of", "transducer"),
        ),
        pose=PosePlan(poses=options.poses, tripods=options.tripods),
        streams=Streams(body_delay_s=stated.get("delay_s", late_s)),
    )
    if isinstance(robot, Biped):
        intended = tables.get("offline_fit", {}).get("intended_load_n")
        plans = plans.of_size(robot, None if intended is None else intended[1])
    return plans.with_noise(options.noise)


def spread_of(session: Session[SimulateOptions]) -> Spread:
    """How far the robot differs from what its recipe states."""
    options, plate = session.options, session.recipe.robot.nameplate
    scale, bias_n = options.scale_sd, options.bias_sd_n
    return Spread(
        plate.scale_relative_sd if scale is None else scale,
        plate.bias_sd_n if bias_n is None else bias_n,
        options.hang_tilt_sd_rad,
        options.mount_rotation_sd_rad,
        options.mount_translation_sd_m,
    )


def motion_of(
    session: Session[SimulateOptions], robot: Biped | Hexapod
) -> dict[str, FloatArray] | None:
    """The columns of a recorded motion, None where the motion is planned."""
    if not session.paths("motion"):
        return None
    walks = session.options.experiment in ("stand", "walk")
    if not isinstance(robot, Biped) or robot.ankles or not walks:
        raise UsageError(
            "a recorded motion serves stands and walks on load cells only",
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
