"""``footcal simulate``: what the sensors of a robot would have shown, and what was true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    NoPictures,
    Out,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    Seed,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.core.parameters import FloatArray
    from footcal_cli.core.simulation.robots import Biped, Hexapod
    from footcal_cli.core.simulation.scenario import EffectRequest, Plans, Scenario
    from footcal_cli.records.results import TruthRecord
    from footcal_cli.report import Picture
    from footcal_cli.session.session import Outcome, Session

Kind = Literal["weights", "placements", "stand", "walk", "hang", "pose"]


class SimulateOptions(CommandOptions):
    """``[simulate]`` of a recipe."""

    experiment: Kind | None = None
    effects: tuple[str, ...] = ()
    duration_s: float = Field(default=60.0, gt=0, le=86_400)
    speed_mps: float = Field(default=0.04, ge=0, le=0.3)
    turn_radps: float = Field(default=0.0, ge=-1, le=1)
    com_height_m: float = Field(default=0.26, gt=0)
    stances: int = Field(default=10, ge=1, le=10_000)
    one_foot_stances: int = Field(default=0, ge=0, le=10_000)
    sessions: int = Field(default=3, ge=1, le=1000)
    repeats: int = Field(default=20, ge=1, le=10_000)
    cycles: int = Field(default=10, ge=1, le=1000)
    poses: int = Field(default=120, ge=1, le=100_000)
    tripods: int = Field(default=0, ge=0, le=100_000)
    noise: float = Field(default=1.0, ge=0)
    scale_sd: float = Field(default=0.02, ge=0)
    bias_sd_n: float = Field(default=0.3, ge=0)
    hang_tilt_sd_rad: float = Field(default=0.035, ge=0)
    mount_rotation_sd_rad: float = Field(default=0.02, ge=0)
    mount_translation_sd_m: float = Field(default=0.003, ge=0)


def simulate(
    logs: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[MOTION]",
            help="A recorded stand or walk with its true cell loads, in place of the planned one.",
        ),
    ] = None,
    experiment: Annotated[
        str | None, typer.Option("--experiment", help=", ".join(get_args(Kind)) + ".")
    ] = None,
    effect: Annotated[
        list[str] | None,
        typer.Option(
            "--effect",
            metavar="[OWNER.]NAME[=VALUE]",
            help="An effect to put in; of every channel, or of OWNER only. Shapes follow after "
            "commas: left_rr.bias_jump=1.5,jump_time=30. Without a value its usual size.",
        ),
    ] = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    duration_s: Annotated[
        float | None, typer.Option("--duration-s", help="Length of a walk.")
    ] = None,
    speed_mps: Annotated[float | None, typer.Option("--speed-mps", help="Walking speed.")] = None,
    noise: Annotated[
        float | None, typer.Option("--noise", help="Factor on all noise; 0 for none.")
    ] = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/simulate"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Simulate an experiment with any effects; write its logs and its truth."""
    session = begin(
        "simulate",
        SimulateOptions,
        logs=logs,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
        experiment=experiment,
        effects=tuple(effect) if effect else None,
        duration_s=duration_s,
        speed_mps=speed_mps,
        noise=noise,
    )
    raise typer.Exit(session.finish(_simulate(session)))


def _simulate(session: Session[SimulateOptions]) -> Outcome:
    from footcal_cli.errors import UsageError

    options = session.options
    if options.experiment is None:
        raise UsageError(
            "no experiment named", file=session.recipe.path,
            remedy=f"add --experiment, one of {', '.join(get_args(Kind))}",
        )  # fmt: skip
    from footcal_cli.core.simulation.scenario import Spread, simulate
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import simulated as sheets

    robot = _robot(session, options.experiment)
    requests = [parse_effect(text, session.table) for text in options.effects]
    plans = _plans(options, session.request.seed)
    motion = _motion(session, robot)
    with session.step("simulate"):
        scenario = simulate(
            options.experiment,
            robot,
            plans,
            requests,
            seed=session.request.seed,
            motion=motion,
            spread=Spread(
                options.scale_sd,
                options.bias_sd_n,
                options.hang_tilt_sd_rad,
                options.mount_rotation_sd_rad,
                options.mount_translation_sd_m,
            ),
            given=_given(session),
        )
    pictures = _pictures(scenario)
    return Outcome(
        report=Report(
            title=f"Simulated {options.experiment} of {session.recipe.robot.name}",
            verdict=sheets.verdict(options.experiment, scenario, requests),
            pictures=pictures,
            sheets=(sheets.file_sheet(scenario), sheets.effect_sheet(requests)),
            footer=(
                "The logs hold what the sensors showed; truth.json holds every parameter they were "
                "distorted with. The same recipe, effects and seed give the same bytes.",
            ),
        ),
        records={"truth.json": _truth(session, scenario, plans, robot)},
        files={f"{stem}.parquet": partial(_write, scenario, stem) for stem in scenario.files},
    )


def parse_effect(text: str, table: Mapping[str, Effect]) -> EffectRequest:
    """``[OWNER.]NAME[=VALUE][,PARAMETER=VALUE ...]`` as a request.

    Raises
    ------
    UsageError
        Unknown effect or parameter (names the nearest), or not a number.
    """
    from footcal_cli.core.simulation.scenario import EffectRequest
    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.records.effects import known_effect

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
    from footcal_cli.errors import UsageError

    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"'{item}': not a number", value=text, remedy="write NAME=VALUE in the table's unit"
        ) from None


def _robot(session: Session[SimulateOptions], experiment: Kind) -> Biped | Hexapod:
    """The recipe's robot; without a recipe a NAO-like biped or a BigAnt-like hexapod."""
    from footcal_cli.core.simulation.robots import Biped, Hexapod, leg_at
    from footcal_cli.core.simulation.scenario import ON_CELLS
    from footcal_cli.errors import UsageError

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


def _plans(options: SimulateOptions, seed: int) -> Plans:
    from footcal_cli.core.simulation.bench_logs import PlacementsPlan, WeightsPlan
    from footcal_cli.core.simulation.biped_logs import StandPlan
    from footcal_cli.core.simulation.gait import WalkPlan
    from footcal_cli.core.simulation.hexapod_logs import HangPlan, PosePlan
    from footcal_cli.core.simulation.scenario import Plans

    return Plans(
        weights=WeightsPlan(sessions=options.sessions),
        placements=PlacementsPlan(repeats=options.repeats),
        stand=StandPlan(stances=options.stances, one_foot=options.one_foot_stances),
        walk=WalkPlan(
            duration_s=options.duration_s,
            speed_mps=options.speed_mps,
            turn_radps=options.turn_radps,
            variation_seed=seed,
        ),
        hang=HangPlan(cycles=options.cycles),
        pose=PosePlan(poses=options.poses, tripods=options.tripods),
    ).with_noise(options.noise)


def _motion(
    session: Session[SimulateOptions], robot: Biped | Hexapod
) -> dict[str, FloatArray] | None:
    """The columns of a recorded motion, None where the motion is planned."""
    from footcal_cli.core.simulation.recorded import motion_columns
    from footcal_cli.core.simulation.robots import Biped
    from footcal_cli.errors import UsageError
    from footcal_cli.tables.columns import Column, TableType

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


def _given(session: Session[SimulateOptions]) -> dict[str, float] | None:
    if session.parameters is None:
        return None
    return {name: record.value for name, record in session.parameters.parameters.items()}


def _write(scenario: Scenario, stem: str, path: Path) -> None:
    import pandas as pd

    from footcal_cli.tables.table import write_parquet

    write_parquet(pd.DataFrame(dict(scenario.files[stem])), path)


def _truth(
    session: Session[SimulateOptions], scenario: Scenario, plans: Plans, robot: Biped | Hexapod
) -> TruthRecord:
    from footcal_cli.core.simulation.robots import Biped
    from footcal_cli.records.effects import record_of_effect
    from footcal_cli.records.results import TruthRecord

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


def _pictures(scenario: Scenario) -> tuple[Picture, ...]:
    from footcal_cli.plots.simulated import plot_shown_and_true
    from footcal_cli.report import Picture

    return (
        Picture(
            "shown_and_true",
            lambda: plot_shown_and_true(
                scenario.shown, scenario.truth, scenario.chain, scenario.values
            ),
            "What the sensors showed, converted with their true calibration (colour), over what "
            "was true (black); below, the difference: effects and noise.",
            title="Measured and true loads, and their difference",
            zoom=True,
        ),
    )
