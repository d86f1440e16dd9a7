"""Recipes: TOML to frozen models; an unknown key is an error that names the nearest known one.

A recipe says what the robot is (``[robot]``), how foreign columns are called (``[columns]``), where
the logs lie (``[data]``, relative to the recipe) and, in one table per command, its options.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from footcal_cli.errors import UsageError, nearest
from footcal_cli.recipe.filespecs import FileSpec, Place, as_file, as_places
from footcal_cli.records.models import Frozen, Model, validated
from footcal_cli.records.own_effects import OwnEffect
from footcal_cli.tables.canonical_names import canonical_names, is_canonical
from footcal_cli.tables.plates import Plate
from footcal_cli.tables.reading import Join, Reading
from footcal_cli.tables.textfiles import called_as, read_text
from footcal_cli.tables.world import WorldUp

__all__ = ["CommandOptions", "Frozen", "Gates", "Recipe", "Robot", "metres", "read_recipe",
           "validated"]  # fmt: skip

STANDARD_GRAVITY_MPS2 = 9.80665
STATED_MASS_SD = 0.01
"""Sd of the stated mass as a share of it where nobody says it: batteries, cables and covers."""
LARGEST_BYTES = 4 * 2**20
"""No recipe is larger."""
_COP_FORCE_N, _COP_SHARE = 5.0, 0.1
"""Below this force, or share of the weight where that is less, there is no CoP."""


Positive = Annotated[float, Field(gt=0)]


class Gates(Frozen):
    """``[gates]`` of a recipe, or ``[<command>.gates]``: what a result must meet to be accepted.

    `max_rmse` limits errors by quantity (``"force *"``, ``cop_x``; N, N·m or m), on held-out data
    where there are some; `verdicts` and `diagnoses` are those allowed. `max_change` limits what
    parameters may differ from those of `reference`, a ``parameters.json``, by name or by what
    follows the last dot (``bias``), in their unit; `max_change_sd` all of them, in sd.
    Names may hold ``*`` and ``?``.
    """

    max_rmse: dict[str, Positive] = Field(default_factory=dict)
    verdicts: tuple[Literal["good", "warning", "bad"], ...] | None = None
    diagnoses: (
        tuple[
            Literal[
                "none", "named", "ambiguous", "named+unknown", "unknown", "underpowered", "bad-data"
            ],
            ...,
        ]
        | None
    ) = None
    max_change: dict[str, Positive] = Field(default_factory=dict)
    max_change_sd: float | None = Field(default=None, gt=0)
    reference: str | None = None


def metres(millimetres: float | None) -> float | None:
    """A limit in mm as one in m."""
    return None if millimetres is None else millimetres / 1e3


class CommandOptions(Frozen):
    """Options of one command: its table in a recipe, overridden by the command line."""

    takes_rejected: ClassVar[bool] = False
    """Whether the command starts from a rejected calibration too: to say what is wrong with it."""

    strict_findings: bool = False
    pictures: bool = True
    gates: Gates = Gates()

    @property
    def limits(self) -> dict[str, float | None]:
        """Limits on errors that the command has short options for, by quantity, SI units."""
        return {}


class Cell(Frozen):
    """A load cell under a foot, position in the foot frame."""

    x_m: float
    y_m: float


class Foot(Frozen):
    """A foot: load cells by name, or one six-axis transducer at the ankle.

    With `force_and_cop` the log has the foot's vertical force and CoP (``left_fz_n``,
    ``left_cop_x_m``, ``left_cop_y_m``), as plates and insoles report them, and its three cells
    stand in for the plate, in the frame of the CoP.
    `transducer_rotation_rpy_rad` turns its axes into those of the logged foot; at `com_below_m`, in
    its own axes, hang `weight_below_n` ± `weight_below_sd_n` (plates: 0; else 0.45 % of all).
    """

    cells: dict[str, Cell] = Field(default_factory=dict)
    transducer_position_m: tuple[float, float, float] | None = None
    transducer_rotation_rpy_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weight_below_n: float = Field(default=0.0, ge=0)
    weight_below_sd_n: float | None = Field(default=None, ge=0)
    com_below_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outline_m: tuple[tuple[float, float], ...] = ()
    force_and_cop: bool = False

    @model_validator(mode="after")
    def _three_cells(self) -> Self:
        if not self.force_and_cop:
            return self
        places = [(cell.x_m, cell.y_m) for cell in self.cells.values()]
        if len(places) != 3:
            raise ValueError("force_and_cop needs three cells that stand in for the plate")
        (ax, ay), (bx, by), (cx, cy) = places
        if abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) < 1e-6:
            raise ValueError("force_and_cop needs three cells that are not in one line")
        return self


class Leg(Frozen):
    """A leg with a six-axis transducer at the hip, nominal pose in the body frame.

    `mass_kg` hangs below it. On the leg's side it `turns_about` a body axis, by `phase_rad`.
    """

    position_m: tuple[float, float, float] | None = None
    rotation_rpy_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turns_about: Literal["+x", "-x", "+y", "-y", "+z", "-z"] | None = None
    mass_kg: float | None = Field(default=None, gt=0)


class Adc(Frozen):
    """The converter behind the cells (HX711: 24 bits).

    `lost_reading` is what its logger writes where a sample was lost.
    """

    bits: int = Field(default=24, ge=8, le=32)
    lost_reading: float | None = None


class Nameplate(Frozen):
    """What the data sheet promises of each cell; the prior where nothing was calibrated.

    `mounted_scale_relative_sd` and `mounted_bias_sd_n` are what mounting, warmth and days may have
    changed since a calibration that a command starts from; without them as much as the data sheet
    leaves open, at most 2 % and 0.3 N or half a per cent of the robot's weight.
    """

    scale_n_per_count: float | None = None
    zero_counts: float = 0.0
    scale_relative_sd: float = Field(default=0.02, gt=0)
    bias_sd_n: float = Field(default=0.3, gt=0)
    mounted_scale_relative_sd: float | None = Field(default=None, gt=0)
    mounted_bias_sd_n: float | None = Field(default=None, gt=0)


class Robot(Frozen):
    """Geometry and masses.

    `world_up` is the axis that points up in the world of the logs' positions, accelerations and
    attitudes; they are turned to z up as they are read. Foot frames keep x forward, y left.
    `mass_sd_kg` is how well the mass is known: 1 % of it where it is not given. The scales that
    stands and walks find are as unsure, as far as the cells do not weigh the robot better.
    `min_force_n` is ε, the vertical force below which there is no CoP: not given 5 N, or a tenth of
    the weight where that is less.
    """

    name: str = "unnamed robot"
    mass_kg: float | None = Field(default=None, gt=0)
    mass_sd_kg: float | None = Field(default=None, gt=0)
    gravity_mps2: float = Field(default=STANDARD_GRAVITY_MPS2, gt=0)
    min_force_n: float | None = Field(default=None, gt=0)
    world_up: WorldUp = "+z"
    channels: tuple[str, ...] = ()
    feet: dict[str, Foot] = Field(default_factory=dict)
    legs: dict[str, Leg] = Field(default_factory=dict)
    adc: Adc = Adc()
    nameplate: Nameplate = Nameplate()

    @model_validator(mode="after")
    def _channels_once(self) -> Self:
        twice = sorted({c for c in self.channels if self.channels.count(c) > 1})
        if twice:
            raise ValueError(f"channel '{twice[0]}' is named twice")
        return self

    @property
    def cell_names(self) -> tuple[str, ...]:
        """Channels of the load cells: ``<foot>_<cell>`` of the feet, or others as listed."""
        own = tuple(f"{foot}_{cell}" for foot, spec in self.feet.items() for cell in spec.cells)
        same = set(self.channels) == set(own)  # in the order of the feet's cells
        return own if same else self.channels or own

    @property
    def weight_n(self) -> float | None:
        """Body weight m·g, None where the mass is not given."""
        return None if self.mass_kg is None else self.mass_kg * self.gravity_mps2

    @property
    def mass_share_sd(self) -> float:
        """Sd of the mass as a share of it."""
        if self.mass_sd_kg is None or self.mass_kg is None:
            return STATED_MASS_SD
        return self.mass_sd_kg / self.mass_kg

    @property
    def least_force_n(self) -> float:
        """ε of every CoP that no command's own `min_force_n` overrides."""
        if self.min_force_n is not None:
            return self.min_force_n
        return min(_COP_FORCE_N, _COP_SHARE * (self.weight_n or float("inf")))


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else value


class Recipe(Frozen):
    """A whole recipe; `options` keeps the commands' tables as read.

    `data_root` is the folder, relative to the recipe, that its relative paths must not leave: a
    recipe that came from somebody else reads nothing next to it unless it says so.
    """

    name: str = "unnamed"
    description: str = ""
    robot: Robot = Robot()
    columns: dict[str, Place] = Field(default_factory=dict)
    files: tuple[FileSpec, ...] = ()
    data: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    data_root: str = "."
    effect: tuple[OwnEffect, ...] = ()
    gates: dict[str, Any] = Field(default_factory=dict)
    options: dict[str, dict[str, Any]] = Field(default_factory=dict)
    path: Path | None = None

    def every_place(self) -> list[tuple[str, Place]]:
        """All entries of ``[columns]``, those of ``[[files]]`` too."""
        tables = [self.columns]
        for spec in self.files:
            tables += [spec.columns, *spec.wide.values()]
        return [entry for table in tables for entry in table.items()]

    def reading(self, path: Path) -> Reading:
        """How a log is to be read: ``[columns]`` and the entry of ``[[files]]`` that it matches.

        Raises
        ------
        UsageError
            A file to be joined is not there, or joins others itself.
        """
        spec = self._spec_of(path)
        plates = tuple(
            Plate(name, {n: (c.x_m, c.y_m) for n, c in foot.cells.items()})
            for name, foot in self.robot.feet.items() if foot.force_and_cop
        )  # fmt: skip
        if spec is None:
            return Reading(self.columns, plates=plates, world_up=self.robot.world_up)
        joins = []
        for join in spec.join:
            beside = path.parent / join.file
            if not beside.is_file():
                raise UsageError(
                    f"no file '{join.file}' to join to {path.name}", file=self.path,
                    remedy="correct [[files]] join; the file lies in the log's folder",
                )  # fmt: skip
            if self._spec_of(beside) is spec:
                raise UsageError(
                    f"'{join.file}' is joined to itself: match = '{spec.match}'",
                    file=self.path,
                    remedy=f"put its own [[files]] entry, match = '{join.file}', above that one",
                )
            other = self.reading(beside)
            if other.joins:
                raise UsageError(
                    f"'{join.file}' is joined to {path.name} and has a join itself",
                    file=self.path, remedy="let one [[files]] entry hold all joins",
                )  # fmt: skip
            how = (join.by, join.offset_s, join.how, join.tolerance_s, join.apart_s)
            joins.append(Join(beside, other, *how, join.only_where))
        return Reading(
            {**self.columns, **spec.columns}, spec.layout(), spec.rate_hz, spec.wide_into,
            spec.wide, tuple(joins), spec.rows_of, plates, self.robot.world_up, spec.zeros_where,
        )  # fmt: skip

    def _spec_of(self, path: Path) -> FileSpec | None:
        """The first entry of ``[[files]]`` that a log matches."""
        return next((s for s in self.files if fnmatch(called_as(path, s.match), s.match)), None)

    def data_paths(self, role: str) -> list[Path]:
        """Logs of one role in ``[data]``, resolved against the recipe's folder."""
        folder = self.path.parent if self.path is not None else Path()
        found: list[Path] = []
        for pattern in self.data.get(role, ()):
            matches = sorted(folder.glob(pattern)) if "*" in pattern else [folder / pattern]
            if not matches:
                raise UsageError(
                    f"[data] {role} = '{pattern}' matches no file", file=self.path,
                    remedy="check the pattern; paths are relative to the recipe",
                )  # fmt: skip
            if not Path(pattern).is_absolute():
                self._refuse_outside(pattern, matches)
            found += matches
        return found

    def options_for(
        self, model: type[Model], table: str, given: Mapping[str, object] | None = None
    ) -> Model:
        """Options of a command: its table, overridden by what is given and not None.

        ε of the CoP (`min_force_n`) is the robot's where the table gives none.
        """
        over = {key: value for key, value in (given or {}).items() if value is not None}
        own = self.options.get(table, {})
        if "min_force_n" in model.model_fields:
            own = {"min_force_n": self.robot.least_force_n, **own}
        return validated(model, {**own, **over}, file=self.path, table=table)

    def hip_position_m(self, leg: str) -> tuple[float, float, float]:
        """Where the recipe says that a leg's transducer sits, body frame, m; refused without."""
        position = self.robot.legs[leg].position_m
        if position is None:
            raise UsageError(
                f"[robot.legs.{leg}] has no position_m", file=self.path,
                remedy="give x, y, z of the transducer's origin in the body frame, in m",
            )  # fmt: skip
        return position

    def _refuse_outside(self, pattern: str, paths: Collection[Path]) -> None:
        folder = self.path.parent if self.path is not None else Path()
        root = (folder / self.data_root).resolve()
        if any(not path.resolve().is_relative_to(root) for path in paths):
            raise UsageError(
                f"[data] '{pattern}' leaves the recipe's folder", file=self.path,
                remedy='write data_root = ".." (the folder that holds the data) at the top of the '
                "recipe if that is on purpose, or an absolute path",
            )  # fmt: skip


def read_recipe(path: Path, commands: Collection[str]) -> Recipe:
    """Read a recipe.

    Parameters
    ----------
    commands
        Names of the tables that hold options of commands.
    """
    text = read_text(path, at_most=LARGEST_BYTES)
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise UsageError("nested too deeply", file=path, remedy="write it flatter") from None
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise UsageError(f"not valid TOML: {error}", file=path, remedy="correct the line") from None
    if not content:
        raise UsageError("the recipe is empty", file=path, remedy="copy it again, or leave it out")
    tables = (
        "name",
        "description",
        "robot",
        "columns",
        "files",
        "data",
        "data_root",
        "effect",
        "gates",
    )
    for key in content:
        if key not in tables and key not in commands:
            raise UsageError(
                f"unknown table or key '{key}'{nearest(key, [*tables, *commands])}", file=path,
                remedy=f"known are {', '.join([*tables, *sorted(commands)])}",
            )  # fmt: skip
    options = {name: table for name, table in content.items() if name in commands}
    top: dict[str, Any] = {name: table for name, table in content.items() if name in tables}
    top["columns"] = as_places(top.get("columns", {}))
    if isinstance(top.get("data"), dict):
        top["data"] = {key: _as_list(value) for key, value in top["data"].items()}
    if isinstance(top.get("files"), list):
        top["files"] = [as_file(entry) for entry in top["files"]]
    recipe = validated(Recipe, {**top, "options": options, "path": path}, file=path)
    validated(Gates, recipe.gates, file=path, table="gates")
    robot = recipe.robot
    cells = (*robot.cell_names, *(cell for foot in robot.feet.values() for cell in foot.cells))
    for name, _ in recipe.every_place():
        if not is_canonical(name, cells):
            raise UsageError(
                f"[columns]: no log has a column '{name}'{nearest(name, canonical_names(cells))}",
                file=path, remedy="the left side is footcal's name, the right side yours",
            )  # fmt: skip
    return recipe
