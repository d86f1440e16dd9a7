"""The option tables of a recipe that more than their command reads.

Each is written once: it checks the recipe's table, and what carries a `Flag` is an option of the
command line too (`footcal_cli.commands.options.command`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field, model_validator

from footcal_cli.recipe import CommandOptions, Positive, metres
from footcal_cli.recipe.filespecs import as_place
from footcal_cli.records.models import Frozen
from footcal_cli.records.own_effects import ExperimentName


@dataclass(frozen=True)
class Flag:
    """An option of the command line.

    Parameters
    ----------
    help
        What ``--help`` says of it.
    name
        How it is called; the field's name where empty.
    """

    help: str
    name: str = ""
    metavar: str | None = None


Limit = Positive | None
Vector = tuple[float, float, float]


class ApplyOptions(CommandOptions):
    """``[apply]`` of a recipe.

    `chassis_com_m` is used where the calibration does not say which chassis CoM it means;
    `cop_correction` is a ``cop_correction.json`` of offline-fit.
    """

    chassis_com_m: Vector = (0.0, 0.0, 0.0)
    min_force_n: Positive = 5.0
    cop_correction: Annotated[
        str | None, Flag("cop_correction.json of offline-fit.", metavar="FILE")
    ] = None

    @model_validator(mode="before")
    @classmethod
    def _as_of_1_0(cls, given: dict[str, object]) -> dict[str, object]:
        """`min_force_n` was called `least_force_n` in recipes of 1.0."""
        old = {"min_force_n": given["least_force_n"]} if "least_force_n" in given else {}
        return {k: v for k, v in given.items() if k != "least_force_n"} | old


class DiagnoseOptions(CommandOptions):
    """``[diagnose]`` of a recipe."""

    takes_rejected: ClassVar[bool] = True

    experiment: Annotated[
        ExperimentName, Flag("weights, placements, stand, walk, hang, pose.", metavar="KIND")
    ] = "weights"
    tolerance_n: Annotated[Limit, Flag("Smallest RMS error of a force that matters.")] = None
    tolerance_mm: Annotated[Positive, Flag("Smallest error of the centre of pressure.")] = 1.0
    without: Annotated[
        tuple[str, ...], Flag("Leave an effect out of the table.", metavar="EFFECT")
    ] = ()
    most_effects: int = Field(default=4, ge=1, le=4)
    delay_s: float = 0.0
    between: Annotated[
        tuple[str, ...], Flag("Rivals that --plan should distinguish.", metavar="EFFECT")
    ] = ()
    after: Annotated[
        Path | None,
        Flag(
            "diagnosis.json of an earlier log, whose rivals this log should distinguish.",
            metavar="FILE",
        ),
    ] = None


PRIOR = "Count the calibration of --parameters as prior, covariance included."


class HangCalibOptions(CommandOptions):
    """``[hang_calib]`` of a recipe.

    `orientation_of` says whose axis the log's orientation names: the transducer's own, or the
    body's (a transducer turned by π about z then reads −x in a log called ``+x``). `tilt` is one
    per named orientation (`per_log`), one of the sensor on its `mount`, or none; where nothing is
    said it is `mount` if the log has a measured attitude, else `per_log`.
    """

    method: Annotated[
        Literal["joint", "stepwise", "naive"], Flag("joint, or the paper's stepwise, or naive.")
    ] = "joint"
    prior: Annotated[bool, Flag(PRIOR)] = False
    order: int | None = Field(default=None, ge=0, le=8)
    max_order: int = Field(default=3, ge=0, le=8)
    tilt: Annotated[
        Literal["per_log", "mount", "none"] | None,
        Flag("per_log, mount (a sensor on a wrist) or none."),
    ] = None
    tilt_sd_rad: Positive = 0.2
    orientation_of: Literal["transducer", "body"] = "transducer"
    leg_weight_n: float = Field(default=0.0, ge=0)
    temperature: bool = False
    drift: bool = False
    white: bool = False
    compare: Annotated[
        bool, Flag("Run the paper's stepwise method too, side by side with the joint fit.")
    ] = False
    max_force_rmse_n: Annotated[Limit, Flag("Gate: exit 1 above this RMSE.")] = None

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"* force": self.max_force_rmse_n}


class JointColumn(Frozen):
    """Where a joint's position stands in the log."""

    column: str
    unit: str | None = None


class KinematicsOptions(CommandOptions):
    """``[kinematics]`` of a recipe.

    `joints` maps joints of the URDF to columns (``"knee"`` or ``{ column = "knee", unit = "deg"
    }``); `fixed` says where joints stand that the log lacks; `feet` names the link of each foot;
    `anchor` is a foot that never moves, for a log without the base's position.
    """

    urdf: Annotated[str | None, Flag("The robot's model.", metavar="FILE.urdf")] = None
    joints: dict[str, Annotated[JointColumn, BeforeValidator(as_place)]] = Field(
        default_factory=dict
    )
    joint_unit: Literal["rad", "deg"] = "rad"
    fixed: dict[str, float] = Field(default_factory=dict)
    feet: dict[str, str] = Field(default_factory=dict)
    anchor: Annotated[
        str | None, Flag("Foot that never moves, if there is one.", metavar="FOOT")
    ] = None
    cutoff_hz: Positive = 10.0


class PlateauSettings(Frozen):
    """``[offline_fit.plateaus]``: what counts as standing still in a running recording.

    Tolerances that are 0 are chosen from the recording. `loads` names the loads in the order in
    which they were put on, with their unit (``"0, 1, 2, 5 lb"``), where the recording does not have
    them; `loads_n` is the same in N.
    """

    window_s: Positive = 2.0
    min_hold_s: Positive = 3.0
    settle_s: float = Field(default=0.0, ge=0)
    max_change: float = Field(default=0.0, ge=0)
    max_scatter: float = Field(default=0.0, ge=0)
    same_level: float = Field(default=0.02, ge=0)
    glitch_sd: Positive = 8.0
    loads_n: tuple[float, ...] = ()
    loads: str = ""

    def known_n(self, gravity_mps2: float) -> tuple[float, ...]:
        """The loads in N, masses as their weight."""
        if not self.loads:
            return self.loads_n
        from footcal_cli.tables.units import load_list

        return load_list(self.loads, gravity_mps2)


class OfflineFitOptions(CommandOptions):
    """``[offline_fit]`` of a recipe."""

    method: Annotated[
        Literal["ordinary", "weighted", "robust"], Flag("ordinary, weighted or robust regression.")
    ] = "ordinary"
    models: Annotated[
        Literal["auto", "affine"], Flag("auto: beyond affine where held-out data ask for it")
    ] = "auto"
    prior: Annotated[bool, Flag(PRIOR)] = False
    most_degree: int = Field(default=3, ge=1, le=6)
    samples: bool | None = None
    plateaus: PlateauSettings = PlateauSettings()
    known_wrench: bool = False
    held_out_placements: tuple[str, ...] = ()
    min_force_n: Positive = 5.0
    intended_load_n: tuple[float, float] | None = None
    tolerance_percent: Positive = 1.0
    max_rmse_n: Annotated[Limit, Flag("Gate: exit 1 above this RMSE.")] = None
    max_cop_rmse_mm: Annotated[Limit, Flag("Gate on the CoP at left-out placements.")] = None

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"force *": self.max_rmse_n, "cop *": metres(self.max_cop_rmse_mm)}


class NoiseOptions(Frozen):
    """``[online_replay.noise]``: given values; absent ones are learnt from the innovations."""

    force_n: Limit = None
    moment_nm: Limit = None
    force_slow_n: Limit = None
    moment_slow_nm: Limit = None
    force_slow_s: Limit = None
    moment_slow_s: Limit = None
    sole_m: Limit = None
    jitter_s: Limit = None
    swing_n: Limit = None
    swing_slow_n: Limit = None
    swing_slow_s: Limit = None
    swing_fixed_n: float | None = Field(default=None, ge=0)
    swing_fixed_s: Limit = None
    gain_walk: Limit = None
    bias_walk_n: Limit = None
    state_walk: Limit = None


class OnlineReplayOptions(CommandOptions):
    """``[online_replay]`` of a recipe.

    `picture_span_s` says which part of the walk the figures show, from its first sample. `compare`
    runs all methods; `sensitivity` scales every setting of them, with `compare` unless
    it is said.
    """

    method: Annotated[
        Literal["memory", "window", "static"],
        Flag("memory, window (sliding Gauss-Newton) or static (zero acceleration, after Han)."),
    ] = "memory"
    delay_s: Annotated[float, Flag("Delay of the body stream to compensate.")] = 0.0
    cutoff_hz: Positive = 10.0
    causal: Annotated[bool, Flag("Filter, learn and find contact from the past only.")] = False
    min_force_n: Positive = 5.0
    largest_acceleration_mps2: Positive = 8.0
    update_hz: Positive = 20.0
    window_s: Positive = 0.5
    foot_length_m: Positive = 0.16
    force_weight: Limit = None
    cop_weight: Limit = None
    smooth_weight: Limit = None
    states: tuple[str, ...] = (
        "robot.delay",
        "robot.com_correction_x",
        "robot.com_correction_y",
        "robot.com_correction_z",
        "robot.angmom_loss",
        "robot.smoothing",
        "robot.smoothing_fourth",
    )
    hanging_plate: bool = True
    swing_rows: bool = True
    align_delay: bool = True
    scales: bool | None = None
    noise: NoiseOptions = NoiseOptions()
    compare: Annotated[bool, Flag("Run all methods; show how their settings matter.")] = False
    sensitivity: bool | None = None
    picture_span_s: tuple[float, float] | None = None
    baseline: Annotated[str | None, Flag("Calibration to compare with.", metavar="FILE.json")] = (
        None
    )
    truth: Annotated[str | None, Flag("True cell forces, to compare with.", metavar="FILE")] = None
    max_cop_rmse_mm: Annotated[Limit, Flag("Gate: exit 1 above this CoP error.")] = None
    max_vgrf_rmse_n: Annotated[Limit, Flag("Gate: exit 1 above this force error.")] = None

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"cop": metres(self.max_cop_rmse_mm), "vgrf": self.max_vgrf_rmse_n}


class PoseCalibOptions(CommandOptions):
    """``[pose_calib]`` of a recipe.

    `force_sd_n` and `torque_sd_nm` are the noise of one pose's reading; without them their level
    is estimated. `translation_sd_m` and `com_sd_m` are priors on each hip and on the chassis CoM.
    `robot_weight_sd_n`: `mass_sd_kg`, else 0.05 N or 0.05 % of the weight, where it is not given.
    `structure` names the free mounting errors; ``auto`` lets the evidence choose, and every hip
    shift within a prior. `series`: pairs of transducers on one stiff leg, for `fit` ``series``.
    """

    fit: Annotated[
        Literal["mounting", "offsets", "series"],
        Flag("mounting, offsets (again, from tripods), or series (pairs)."),
    ] = "mounting"
    method: Annotated[
        Literal["joint", "alternating"], Flag("joint, or the paper's alternating scheme.")
    ] = "joint"
    balance: Annotated[
        Literal["exact", "printed"],
        Flag("Balance of wrenches: exact, or as Wu & Revzen print it (method alternating only)."),
    ] = "exact"
    structure: Annotated[
        Literal["auto", "full", "body_rotations", "hip_rotations", "translations", "single"],
        Flag("auto, full, body_rotations, hip_rotations, translations, single."),
    ] = "auto"
    errors_in_variables: bool = True
    force_sd_n: Limit = None
    torque_sd_nm: Limit = None
    translation_sd_m: Limit = 0.005
    com_sd_m: Positive = 0.05
    rotation_sd_rad: Limit = None
    robot_weight_sd_n: Positive = 0.05
    chassis_com_m: Vector = (0.0, 0.0, 0.0)
    hang_directions: Literal["auto", "use", "ignore"] = "auto"
    folds: int = Field(default=5, ge=2)
    steady_rate_nps: Positive = 1.0
    steady_duration_s: Positive = 1.5
    steady_window_s: Positive = 0.5
    wanted_force_sd_n: Positive = 0.1
    wanted_torque_sd_nm: Positive = 0.01
    series: tuple[tuple[str, str], ...] = ()
    quiet_s: Positive = 10.0
    block_s: Positive = 0.5
    max_force_rmse_n: Annotated[Limit, Flag("Gate: exit 1 above this RMSE.")] = None

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        quantity = "* force" if self.fit == "series" else "sum of forces"
        return {quantity: self.max_force_rmse_n}


class SimulateOptions(CommandOptions):
    """``[simulate]`` of a recipe; a CoM height and spreads not given follow from its robot."""

    experiment: Annotated[
        ExperimentName | None, Flag(", ".join(get_args(ExperimentName)) + ".")
    ] = None
    effects: Annotated[
        tuple[str, ...],
        Flag(
            "Effect to add, to every channel or to OWNER only. Shapes follow after "
            "commas: left_rr.bias_jump=1.5,jump_time=30. Without a value its usual size.",
            name="effect",
            metavar="[OWNER.]NAME[=VALUE]",
        ),
    ] = ()
    duration_s: Annotated[float, Flag("Length of a walk.")] = Field(default=60.0, gt=0, le=86_400)
    speed_mps: Annotated[float, Flag("Walking speed.")] = Field(default=0.04, ge=0, le=0.3)
    turn_radps: float = Field(default=0.0, ge=-1, le=1)
    com_height_m: Limit = None
    stances: int = Field(default=10, ge=1, le=10_000)
    one_foot_stances: int = Field(default=0, ge=0, le=10_000)
    sessions: int = Field(default=3, ge=1, le=1000)
    repeats: int = Field(default=20, ge=1, le=10_000)
    cycles: int = Field(default=10, ge=1, le=1000)
    poses: int = Field(default=120, ge=1, le=100_000)
    tripods: int = Field(default=0, ge=0, le=100_000)
    noise: Annotated[float, Flag("Factor on all noise; 0 for none.")] = Field(default=1.0, ge=0)
    scale_sd: float | None = Field(default=None, ge=0)
    bias_sd_n: float | None = Field(default=None, ge=0)
    hang_tilt_sd_rad: float = Field(default=0.035, ge=0)
    mount_rotation_sd_rad: float = Field(default=0.02, ge=0)
    mount_translation_sd_m: float = Field(default=0.003, ge=0)


class StaticInitOptions(CommandOptions):
    """``[static_init]`` of a recipe.

    `force_sd_n`, `moment_sd_nm` and `lifted_sd_n` are what a stance's mean is worth at best;
    where they are not given 0.15 % of the weight, the weight times 0.2 % of the CoM's height, and
    0.3 % of the weight.
    """

    warm_s: float = Field(default=1.0, ge=0)
    largest_acceleration_mps2: Positive = 0.3
    largest_rate_radps: Positive = 0.1
    least_samples: int = Field(default=40, ge=4)
    until_s: Annotated[Limit, Flag("Use only the log's first seconds.")] = None
    delay_s: float = Field(default=0.0, ge=0)
    cutoff_hz: Positive = 10.0
    min_force_n: Positive = 5.0
    force_sd_n: Limit = None
    moment_sd_nm: Limit = None
    lifted_sd_n: Limit = None
    com_sd_m: Annotated[
        Limit, Flag("How far off the model's CoM may be; 0.4 % of its height where not given.")
    ] = None
    max_cop_rmse_mm: Annotated[Limit, Flag("Gate: exit 1 above this CoP error.")] = None

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits of `max_…`, by quantity, SI units."""
        return {"cop*": metres(self.max_cop_rmse_mm)}
