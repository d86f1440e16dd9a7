"""Weights on the holes of a foot as the core takes them: forces, holes and repeats of each foot.

Room: intake; asked by offline_fit and every_kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.bench.cop_study import FootStudy, study_cop
from footcal_cli.core.bench.placement_rows import (
    PlacementRows,
    condense_points,
    filmed_visits,
    holes_of,
)
from footcal_cli.core.bench.shared_loads import common_scale, zeros_seen
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.errors import UsageError, nearest
from footcal_cli.intake.empty_plate import carried, with_others
from footcal_cli.intake.zeros_of_series import with_own_zeros
from footcal_cli.recipe import Robot
from footcal_cli.recipe.options import OfflineFitOptions
from footcal_cli.tables.columns import cop_points_table, placements_table
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_ALIKE, _MISSED = 0.1, 0.2
"""How far scales of one make differ; share of a weight by which forces miss it without zeros."""
FRAMES_OF_A_POINT = 50
"""With more rows than this per point they are frames of a recording, condensed to medians."""


@dataclass(frozen=True)
class PlacementLog:
    """The placements of one foot.

    Parameters
    ----------
    rows
        With calibrated cell forces.
    names
        Name of the placement of every row, shape (n,).
    before
        The same rows with nominal forces, None where no nameplate scale is known.
    """

    rows: PlacementRows
    names: Any
    before: PlacementRows | None = None


def placed(session: Session[Any]) -> list[Table]:
    """Logs of a weight on the holes of feet, by the zeros of each series; empty without."""
    feet = session.recipe.robot.feet.values()
    cells = next((tuple(foot.cells) for foot in feet if foot.cells), ())
    if not cells:
        return []
    tables, findings = with_own_zeros(session.read(placements_table(cells)), cells)
    session.note(f for f in findings if f not in session.noted)
    return tables


def read_feet(
    session: Session[OfflineFitOptions],
    calibration: dict[str, tuple[float, float]],
    *,
    believed: bool,
) -> tuple[dict[str, PlacementLog], dict[str, PlacementLog]]:
    """Placements of every foot and of an instrument, and of feet those to keep apart."""
    robot, least = session.recipe.robot, session.options.min_force_n
    logs, apart = {}, {}
    cells = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    if cells:
        table = placements_table(cells)
        if tables := placed(session):
            logs = read_placements(tables, robot, calibration, least, believed=believed)
        held = [] if session.request.logs else session.read(table, "placements_held_out")
        if held:
            apart = read_placements(held, robot, calibration, least, believed=believed)
    elif (paths := session.recipe.data_paths("placements")) and not session.request.logs:
        session.note([Finding(
            "placements_left_out", "warning", ", ".join(path.name for path in paths),
            "no foot of the recipe has cells: these placements are not used, and the weights alone "
            "are fitted",
            "say where the cells sit, in [robot.feet.<name>.cells]",
        )])  # fmt: skip
    if tables := session.read(cop_points_table()):
        logs["instrument"] = read_cop_points(tables)
    return logs, apart


def believed_cells(robot: Robot, tables: Sequence[Table]) -> list[Estimates]:
    """Scale and bias of each cell before anyone calibrated it.

    As ``[robot.nameplate]`` has them: cells that were calibrated by their maker, and then put under
    a plate, know no other weights. Where it has none, or zeros that are far off, as the placements
    say of all cells together.
    """
    plate, made = robot.nameplate, list[Estimates]()
    where = np.concatenate([table.text("foot") for table in tables])
    for foot, own in robot.feet.items():
        at, columns = where == foot, [f"{cell}_counts" for cell in own.cells]
        if not at.any():
            continue
        counts, load, hole = (
            np.concatenate([table.numbers(names) for table in tables])[at]
            for names in (columns, ["load_n"], ["hole_x_m", "hole_y_m"])
        )
        places = np.array([[c.x_m, c.y_m] for c in own.cells.values()])
        scale = plate.scale_n_per_count
        if scale is None or _far_off(scale * (counts - plate.zero_counts), load[:, 0]):
            scale, bias = common_scale(counts, load[:, 0], hole, places, scale)
        elif (zeros := zeros_seen(counts, load[:, 0], hole)) is not None:
            bias = -scale * zeros
        else:
            bias = np.full(len(columns), -scale * plate.zero_counts)
        sd = plate.scale_relative_sd if plate.scale_n_per_count is not None else _ALIKE
        variance = np.diag([(scale * sd) ** 2, plate.bias_sd_n**2])
        made += [
            Estimates(
                (f"{foot}_{cell}.scale", f"{foot}_{cell}.bias"), ("N/count", "N"),
                np.array([scale, b]), variance, (Status.PRIOR_KEPT,) * 2,
            )
            for cell, b in zip(own.cells, bias.tolist(), strict=True)
        ]  # fmt: skip
    return made


def _far_off(forces_n: FloatArray, load_n: FloatArray) -> bool:
    """Whether forces (n, c) add up to something else than the loads (n,)."""
    missed = np.median(np.abs(forces_n.sum(axis=1) - load_n))
    return bool(missed > _MISSED * np.max(np.abs(load_n), initial=0.0))


def read_placements(
    tables: Sequence[Table],
    robot: Robot,
    calibration: dict[str, tuple[float, float]],
    min_force_n: float,
    *,
    believed: bool = False,
) -> dict[str, PlacementLog]:
    """Forces and holes of every foot in the logs.

    Parameters
    ----------
    robot
        Feet with their cells' positions; the nameplate for the forces before calibration.
    calibration
        Channel -> scale (N/count) and bias (N).
    min_force_n
        Below this total force there is no CoP.
    believed
        Whether no weights stand behind the scales (`believed_cells`).

    Raises
    ------
    UsageError
        A foot the recipe does not have, or a cell without a calibration.
    """
    found: dict[str, PlacementLog] = {}
    foot_of_row = np.concatenate([table.text("foot") for table in tables])
    for foot in dict.fromkeys(foot_of_row):
        if foot not in robot.feet:
            raise UsageError(
                f"the recipe has no foot '{foot}'{nearest(str(foot), robot.feet)}",
                file=tables[0].path, column="foot", remedy="describe it under [robot.feet]",
            )  # fmt: skip
        at = foot_of_row == foot
        cells = tuple(robot.feet[foot].cells)
        channels = tuple(f"{foot}_{cell}" for cell in cells)
        missing = [channel for channel in channels if channel not in calibration]
        if missing:
            raise UsageError(
                f"placements need calibrated cells; '{missing[0]}' has no scale and bias",
                remedy="give its weights too, an earlier calibration with --parameters, or "
                "scale_n_per_count in [robot.nameplate] where its maker calibrated it",
            )
        columns = [f"{cell}_counts" for cell in cells]
        scale, bias = np.array([calibration[channel] for channel in channels]).T
        every = np.concatenate([table.numbers(columns) for table in tables])
        known = np.concatenate([table.number("load_n") for table in tables])
        at[at] = ~carried(every[at] * scale, known[at])
        first, counts = filmed_visits(every[at], _visits(tables)[at])
        at = np.flatnonzero(at)[first]
        position = np.array([[c.x_m, c.y_m] for c in robot.feet[foot].cells.values()])
        hole = np.concatenate([table.numbers(["hole_x_m", "hole_y_m"]) for table in tables])[at]

        load = known[at]
        nominal, zero = robot.nameplate.scale_n_per_count, float(np.median(-bias / scale))
        rows = PlacementRows(
            cells=channels,
            forces_n=counts * scale + bias,
            cell_pos_m=position,
            hole_m=hole,
            load_n=load,
            placement=with_others(holes_of(hole), load),
            min_force_n=min_force_n,
            believed_scale=scale if believed else None,
        )
        # nameplate scale, common zero: what a foot reads before anyone calibrates it
        before = None if nominal is None else replace(rows, forces_n=nominal * (counts - zero))
        names = np.concatenate([table.text("placement") for table in tables])[at]
        found[str(foot)] = PlacementLog(rows, _named_by_place(names.astype(str), hole), before)
    return found


def _visits(tables: Sequence[Table]) -> IntArray:
    """Number of the visit of each row, shape (n,): the same hole, weight and repeat in one go."""
    keys = []
    for number, table in enumerate(tables):
        again = table.text("repeat") if "repeat" in table else np.full(len(table), "")
        code = np.unique(again.astype(str), return_inverse=True)[1].ravel()
        own = table.numbers(["hole_x_m", "hole_y_m", "load_n"]).round(6)
        keys.append(np.column_stack([np.full(len(table), number), code, own]))
    key = np.concatenate(keys)
    return np.asarray(np.cumsum(np.any(np.diff(key, axis=0, prepend=key[:1]) != 0, axis=1)))


def _named_by_place(names: NDArray[np.str_], hole: FloatArray) -> NDArray[np.str_]:
    """Names of points (n,), by their places (n, 2) where all bear one name."""
    place = holes_of(hole)
    several = 1 < len(np.unique(place)) <= len(place) / 2
    if len(set(names.tolist())) > 1 or not several:
        return names
    return np.array([f"{1e3 * x:.1f}, {1e3 * y:.1f} mm" for x, y in hole])


def read_cop_points(tables: Sequence[Table]) -> PlacementLog:
    """Reported CoP at known points of an instrument whose cells were not logged."""
    names = np.concatenate([table.text("placement") for table in tables])
    hole = np.concatenate([table.numbers(["hole_x_m", "hole_y_m"]) for table in tables])
    cop = np.concatenate([table.numbers(["cop_x_m", "cop_y_m"]) for table in tables])
    names = _named_by_place(names.astype(str), hole)
    _, index = np.unique(names.astype(str), return_inverse=True)
    n = len(names)
    rows = PlacementRows(
        cells=(),
        forces_n=np.zeros((n, 0)),
        cell_pos_m=np.zeros((0, 2)),
        hole_m=hole,
        load_n=np.full(n, np.nan),
        placement=index.astype(np.int64),
        given_cop_m=cop,
    )
    labels = np.unique(names.astype(str))
    if n > FRAMES_OF_A_POINT * len(labels):
        rows = condense_points(rows)
    return PlacementLog(rows, labels[rows.placement])


def study_foot(foot: str, log: PlacementLog, held: BoolArray) -> FootStudy:
    """Compare the corrections on the placements that are not held out."""
    return FootStudy(
        foot=foot,
        rows=log.rows.select(~held),
        study=study_cop(log.rows.select(~held)),
        held_out=log.rows.select(held) if held.any() else None,
        before=log.before,
    )
