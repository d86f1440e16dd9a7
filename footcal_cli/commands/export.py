"""``footcal export``: a calibration as the file that a robot's software reads."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import typer

from footcal_cli.commands.options import Overwrite, Quiet, RecipeFile
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from footcal_cli.exporters.contract import Exported, HungWeight, Pose, ToExport
    from footcal_cli.recipe import Recipe
    from footcal_cli.records.results import ParametersRecord

Target = Literal["kth-yaml", "mc_rtc", "ros2_control", "wbd-xml", "urdf", "c-header", "matlab"]
_OF_CELLS = ("c-header", "matlab")


class ExportOptions(CommandOptions):
    """``[export]`` of a recipe.

    `to` is the consumer; `sensors` the ones to write (all where none is named), each
    ``name`` or ``name=what the consumer calls it``.
    """

    to: Target | None = None
    sensors: tuple[str, ...] = ()


def export(
    calibration: Annotated[
        Path | None, typer.Argument(metavar="PARAMETERS", help="parameters.json of a run.")
    ] = None,
    to: Annotated[str | None, typer.Option("--to", help=", ".join(get_args(Target)) + ".")] = None,
    sensor: Annotated[
        list[str] | None,
        typer.Option(
            "--sensor",
            metavar="NAME[=THEIRS]",
            help="Sensor to write, and its name there; repeatable.",
        ),
    ] = None,
    recipe: RecipeFile = None,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="File to write.")] = Path(
        "out/export"
    ),
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Write a calibration for ROS, mc_rtc, YARP, URDF, C or MATLAB."""
    from footcal_cli.commands import option_tables
    from footcal_cli.errors import UsageError
    from footcal_cli.recipe import Recipe, read_recipe
    from footcal_cli.session.request import read_calibration

    read = read_recipe(recipe, option_tables()) if recipe is not None else Recipe()
    given = {"to": to, "sensors": tuple(sensor) if sensor else None}
    options = read.options_for(ExportOptions, "export", given)
    if calibration is None:
        raise UsageError("no calibration given", remedy="name a parameters.json")
    if options.to is None:
        raise UsageError("no consumer given", remedy=f"--to {' | '.join(get_args(Target))}")
    if out.exists() and (out.is_dir() or not overwrite):
        raise UsageError("the file is there already" if out.is_file() else "--out is a folder",
                         file=out, remedy="name another --out or --overwrite")  # fmt: skip
    record = read_calibration(calibration)
    exported = _exported(calibration, record, read, options)
    _write(exported, options.to, out)
    for warning in exported.warnings:
        typer.echo(f"footcal: warning: {warning}", err=True)
    if not quiet:
        typer.echo(f"{out}  {options.to} of {calibration}")


def _exported(
    path: Path, record: ParametersRecord, recipe: Recipe, options: ExportOptions
) -> Exported:
    from importlib import import_module

    from footcal_cli.exporters.contract import ToExport

    assert options.to is not None, "checked by the caller"
    nominal, hung = _of_recipe(recipe)
    source = ToExport(record, path.name, nominal, hung)
    names = _names(source, path, options)
    module = options.to.replace("-", "_")
    exported: Exported = import_module(f"footcal_cli.exporters.{module}").export(source, names)
    return exported


def _of_recipe(recipe: Recipe) -> tuple[dict[str, Pose], dict[str, HungWeight]]:
    """Nominal poses, and what the recipe says hangs below."""
    import numpy as np

    from footcal_cli.core.spatial import rotation_of_rpy
    from footcal_cli.exporters.contract import HungWeight, Pose

    robot = recipe.robot
    nominal = {
        name: Pose(np.array(recipe.hip_position_m(name)), rotation_of_rpy(leg.rotation_rpy_rad))
        for name, leg in robot.legs.items()
    }
    hung = {}
    for name, foot in robot.feet.items():
        if foot.transducer_position_m is not None:
            place = np.array(foot.transducer_position_m)
            nominal[name] = Pose(place, rotation_of_rpy(foot.transducer_rotation_rpy_rad))
            hung[name] = HungWeight(foot.weight_below_n, np.array(foot.com_below_m))
    return nominal, hung


def _names(source: ToExport, path: Path, options: ExportOptions) -> Mapping[str, str]:
    """Sensors to write -> the consumer's names for them.

    Raises
    ------
    UsageError
        A sensor that the calibration lacks, or cells for a consumer of wrenches.
    """
    from footcal_cli.errors import UsageError, nearest

    cells, transducers = source.cells, source.transducers
    known = (*cells, *transducers)
    if not known:
        raise UsageError("neither load cells nor six-axis transducers in it", file=path,
                         remedy="give the parameters.json of a calibration")  # fmt: skip
    names = {}
    for asked in options.sensors:
        name, _, theirs = asked.partition("=")
        if name not in known:
            raise UsageError(f"no sensor '{name}'{nearest(name, known)}", file=path,
                             remedy=f"one of {', '.join(known)}")  # fmt: skip
        names[name] = theirs or name
    names = names or {name: name for name in known}
    unfit = [name for name in names if name in cells]
    if unfit and options.to not in _OF_CELLS:
        raise UsageError(
            f"{options.to} holds wrenches of six-axis transducers, not load cells "
            f"({', '.join(unfit)})", file=path,
            remedy="export cells to c-header or matlab, or choose a transducer with --sensor",
        )  # fmt: skip
    return names


def _write(exported: Exported, target: Target, out: Path) -> None:
    """Write under a temporary name and rename."""
    from footcal_cli.errors import UsageError

    waiting = out.with_name(f".{out.name}.partial-{os.getpid()}")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        if target == "matlab" and out.suffix.lower() == ".mat":
            from footcal_cli.exporters.mat_files import write_mat

            write_mat(exported.content or {}, waiting)
        else:
            waiting.write_text(exported.text, encoding="utf-8")
        waiting.replace(out)
    except OSError as error:
        raise UsageError(f"cannot write there: {error.strerror}", file=out,
                         remedy="name another --out") from None  # fmt: skip
    finally:
        waiting.unlink(missing_ok=True)
