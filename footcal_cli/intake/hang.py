"""Tables of a hanging robot as one list of logs per leg."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.hang.intake import (
    between_holds,
    finite_rows,
    gravity_of_orientation,
    hang_log,
    held_still,
    legs_in_order,
)
from footcal_cli.core.hang.joint import HangOptions
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.spatial import gravity_in, rotation_exp, rotation_of_rpy, rotations_logged
from footcal_cli.errors import DataError, UsageError
from footcal_cli.intake.legs import without_effects
from footcal_cli.tables.columns import AXIS_COLUMNS, GRAVITY, QUATERNION

if TYPE_CHECKING:
    from footcal_cli.recipe import Recipe
    from footcal_cli.recipe.options import HangCalibOptions
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.tables.table import Table


def hang_options(options: HangCalibOptions, recipe: Recipe, tables: Sequence[Table]) -> HangOptions:
    """What the core is asked to fit; a measured attitude is askew by the mount alone."""
    measured = not any("orientation" in table for table in tables)
    return HangOptions(
        order=options.order,
        max_order=options.max_order,
        tilt=options.tilt or ("mount" if measured else "per_log"),
        tilt_sd_rad=options.tilt_sd_rad,
        temperature=options.temperature,
        drift=options.drift,
        white=options.white,
        gravity_mps2=recipe.robot.gravity_mps2,
    )


def leg_logs(
    tables: Sequence[Table],
    recipe: Recipe,
    options: HangCalibOptions,
    undone: ParametersRecord | None = None,
) -> tuple[dict[str, list[Log]], dict[str, int]]:
    """Logs per leg, and rejected rows by reason.

    Parameters
    ----------
    recipe
        Legs in order, and their nominal mounting.
    options
        Whose axis an orientation names, and the believed weight of a leg.
    undone
        Calibration whose effects are taken off the readings.
    """
    logs: dict[str, list[Log]] = {}
    broken = moving = silent = 0
    for table in tables:
        whose = table.text("leg")
        for leg in legs_in_order(whose, tuple(recipe.robot.legs)):
            part = np.flatnonzero(whose == leg)
            wrench = table.numbers(AXIS_COLUMNS)[part]
            phase = table.number("phase_rad")[part] if "phase_rad" in table else np.zeros(part.size)
            gravity, level = _gravity(table, part, leg, recipe, options.orientation_of)
            at_rest = gravity
            if leg in recipe.robot.legs and (axis := recipe.robot.legs[leg].turns_about):
                if all(name in table for name in GRAVITY):
                    raise UsageError(
                        f"gravity_x … gravity_z are in the transducer's axes already, and "
                        f"turns_about of leg '{leg}' would turn them again", file=recipe.path,
                        remedy="drop turns_about, or log the attitude of the body",
                    )  # fmt: skip
                gravity, level = _turned(gravity, level, phase, leg, axis, recipe)
                phase = np.zeros(part.size)  # what turns with its leg sees one CoM
            sound = finite_rows(wrench, phase, gravity)
            broken += int((~sound).sum())
            # noise alone moves an axis off 0: six zeros are a sample that was never received
            nothing = sound & ~wrench.any(axis=1)
            silent, sound = silent + int(nothing.sum()), sound & ~nothing
            if "orientation" not in table:
                moves = sound & between_holds(at_rest)
                moving, sound = moving + int(moves.sum()), sound & ~moves
            if not sound.any():
                raise DataError(f"leg {leg} has no complete row", file=table.path)
            warmth = table.number("temperature_degc")[part] if "temperature_degc" in table else None
            log = hang_log(
                leg,
                table.number("time_s")[part][sound],
                phase[sound],
                wrench[sound],
                gravity[sound],
                leg_weight_n=options.leg_weight_n,
                temperature_degc=None if warmth is None else warmth[sound],
                level_t=None if level is None else level[sound],
            )
            logs.setdefault(leg, []).append(without_effects(log, undone))
    rejected = {
        "reading is not a number": broken,
        "all six axes read 0": silent,
        "moving between holds": moving,
    }
    return logs, {reason: count for reason, count in rejected.items() if count}


def _turned(
    gravity: FloatArray, level: FloatArray | None, phase: FloatArray, leg: str, axis: str,
    recipe: Recipe,
) -> tuple[FloatArray, FloatArray | None]:  # fmt: skip
    """Directions in a transducer that turns with its leg: ``Rᵀ exp(−φ a) R`` of those at φ = 0."""
    rot = rotation_of_rpy(recipe.robot.legs[leg].rotation_rpy_rad)
    along = (1.0 if axis[0] == "+" else -1.0) * rot.T @ np.eye(3)["xyz".index(axis[1])]
    back = rotation_exp(-phase[:, None] * along)
    turned = np.einsum("nij,nj->ni", back, gravity)
    return held_still(turned), None if level is None else np.einsum("nij,njk->nik", back, level)


def _gravity(
    table: Table, part: IntArray, leg: str, recipe: Recipe, orientation_of: str
) -> tuple[FloatArray, FloatArray | None]:
    """Nominal direction of gravity in the transducer frame of a leg's rows, shape (n, 3).

    With it the horizontal axes of the world in which an attitude was measured, shape (n, 3, 2).
    """
    if all(name in table for name in GRAVITY):
        return held_still(table.numbers(GRAVITY)[part]), None
    rot = None
    by_attitude = "orientation" not in table
    if orientation_of == "body" or by_attitude:
        if leg in recipe.robot.legs:
            rot = rotation_of_rpy(recipe.robot.legs[leg].rotation_rpy_rad)
        elif not by_attitude:
            raise UsageError(
                f"orientation_of = 'body' needs the mounting of leg '{leg}'", file=recipe.path,
                remedy=f"add [robot.legs.{leg}]",
            )  # fmt: skip
    if by_attitude:
        attitude = rotations_logged(table.numbers(QUATERNION)[part])
        attitude = attitude if rot is None else attitude @ rot
        return held_still(gravity_in(attitude)), attitude[:, :2].swapaxes(1, 2)
    gravity, unknown = gravity_of_orientation(table.text("orientation")[part], rot)
    if unknown:
        raise DataError(
            f"orientation '{unknown[0]}' is none of +x −x +y −y +z −z",
            file=table.path, column="orientation",
            remedy="say in [columns] which axis points along gravity in each, orientation = "
            f'{{ column = "…", names = {{ "{unknown[0]}" = "+x", … }} }}, or give gravity_x '
            "gravity_y gravity_z or body_qx body_qy body_qz body_qw",
        )  # fmt: skip
    return gravity, None
