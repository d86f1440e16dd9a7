"""Logs of any kind, as `check` reads them, and what shows only where several come together."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.quality import Finding, check_clock
from footcal_cli.errors import DataError, FitError, UsageError
from footcal_cli.intake.closer import look_closer
from footcal_cli.recipe.options import HangCalibOptions, PoseCalibOptions
from footcal_cli.session.inspection import weights_findings
from footcal_cli.tables import columns
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.sources import source_names
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_TIMED_BY_PARTS = frozenset({"weights", "hang", "legs", "placements"})
"""Kinds of log in which stamps rise only within one channel, leg or placement."""


def read_every_kind(session: Session[Any]) -> list[tuple[Table, TableType]]:
    """Every log as each kind that its columns allow; what its stamps say is noted.

    Raises
    ------
    DataError, UsageError
        No log, or none of a kind that is known.
    """
    read = [(table, kind) for kind in _table_types(session) for table in session.read_any(kind)]
    # a recording of known loads is no walk; without loads it is none of weights
    weighed = {table.path for table, kind in read if "load_n" in table}
    tables = [
        (table, kind)
        for table, kind in read
        if not (kind.name == "cells" and table.path in weighed)
        and not (kind.name == "weights_stream" and table.path not in weighed)
    ]
    if not tables:
        _refuse(session)
    for table, kind in tables:
        if "time_s" in table and kind.name not in _TIMED_BY_PARTS:
            session.note(check_clock(table.number("time_s"), table.path.name))
        elif "time_s" in table:
            session.note(_clocks(table))
    return tables


def _clocks(table: Table) -> list[Finding]:
    """Stamps of a long log, channel by channel or leg by leg, and orientation by orientation."""
    groups = [g for g in ("leg", "channel", "orientation", "session") if g in table]
    if "leg" not in groups:  # single readings may lie any time apart
        return []
    keys = list(zip(*(table.text(g) for g in groups), strict=True))
    found: list[Finding] = []
    for key in dict.fromkeys(keys):
        at = np.array([k == key for k in keys])
        found += check_clock(table.number("time_s")[at], ", ".join(map(str, key)))
    return found


def compare(
    session: Session[Any],
    tables: Sequence[tuple[Table, TableType]],
    intended_load_n: tuple[float, float] | None,
) -> None:
    """What shows only where streams, recipe and calibration come together."""
    by_kind: dict[str, list[Table]] = {}
    for table, kind in tables:
        by_kind.setdefault(kind.name, []).append(table)
    robot = session.recipe.robot
    if "weights" in by_kind:
        session.note(weights_findings(by_kind["weights"], robot, intended_load_n))
    if "placements" in by_kind and session.parameters is not None:
        _placements(session, by_kind["placements"])
    session.note(look_closer(by_kind, robot))
    # what a log lacks for a check is no fault of the log
    with suppress(DataError, UsageError, FitError, ValueError):
        if "hang" in by_kind:
            from footcal_cli.core.pose.turned import check_mirrored_hanging, check_turned_hanging
            from footcal_cli.intake.hang import leg_logs

            given = session.recipe.options.get("hang_calib", {})
            asked = HangCalibOptions(orientation_of=given.get("orientation_of", "transducer"))
            logs, _ = leg_logs(by_kind["hang"], session.recipe, asked)
            for leg, own in logs.items():
                turned = check_turned_hanging(leg, own)
                session.note(turned or check_mirrored_hanging(leg, own))
        if "poses" in by_kind:
            _standing_legs(session)
    with suppress(DataError, UsageError, FitError, ValueError):
        if "body" in by_kind and ("cells" in by_kind or "six_axis_feet" in by_kind):
            _walking(session)


def _placements(session: Session[Any], tables: Sequence[Table]) -> None:
    """Weights on feet against the calibration of their cells."""
    from footcal_cli.core.checks.holes import check_placed
    from footcal_cli.intake.placed_weights import read_placements

    if session.parameters is None:
        return
    with suppress(UsageError):  # cells without a calibration
        logs = read_placements(
            tables, session.recipe.robot, session.parameters.calibrated_cells, 0.0
        )
        for log in logs.values():
            rows = log.rows
            session.note(check_placed(rows.forces_n, rows.cells, rows.load_n))


def _asked_of_poses(session: Session[Any]) -> PoseCalibOptions:
    """What the recipe asks of `pose-calib`."""
    return PoseCalibOptions.model_validate(session.recipe.options.get("pose_calib", {}))


def _standing_legs(session: Session[Any]) -> None:
    """How legs sit by their poses, from what hanging knew of them."""
    from footcal_cli.core.pose.data import pose_data
    from footcal_cli.core.pose.seating import standing_axes
    from footcal_cli.intake.legs import without_effects
    from footcal_cli.intake.poses import noise_sd_of, raw_poses

    asked = _asked_of_poses(session)
    log, legs, _ = raw_poses(session, asked)
    data = pose_data(without_effects(log, session.parameters))
    sd, _ = noise_sd_of(asked, len(legs), data.robot_weight_n)
    session.note(standing_axes(data, legs, sd, asked.com_sd_m, asked.translation_sd_m))


def _walking(session: Session[Any]) -> None:
    """The checks of `footcal_cli.intake.recordings`; those of walks where every foot is lifted."""
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.intake.recordings import read_recordings

    rule = MergeRule(min_force_n=session.recipe.robot.least_force_n)
    for recording in read_recordings(session, rule, "stand"):
        lifted = (recording.merged.log.known["contact"] == 0.0).mean(axis=0)
        if lifted.size and lifted.min() > LIFTED_SHARE:
            read_recordings(session, rule, "walk")
            return


LIFTED_SHARE = 0.03
"""A log in which every foot is in the air for longer is a walk."""


def _table_types(session: Session[Any]) -> list[TableType]:
    """Kinds of log to try, as far as the recipe or the files' headers name their channels."""
    robot = session.recipe.robot
    headers = [
        source_names(path, session.recipe.reading(path))
        for path in session.every_path()
        if path.is_file()
    ]
    loaded = "load_n" in session.recipe.columns or any("load" in n for h in headers for n in h)
    counted = [name.removesuffix("_counts") for h in headers for name in h if "_counts" in name]
    channels = robot.cell_names or tuple(dict.fromkeys(counted))
    feet = tuple(robot.feet) or ("left", "right")
    in_series = tuple(dict.fromkeys(n for pair in _asked_of_poses(session).series for n in pair))
    cells_of_a_foot = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    kinds = [
        columns.weights_table(),
        columns.hang_table(),
        columns.poses_table(),
        columns.legs_table(),
        columns.cop_points_table(),
        columns.body_table(feet),
        columns.six_axis_feet_table(feet),
    ]
    if in_series:
        kinds.append(columns.six_axis_feet_table(in_series))
    if cells_of_a_foot:
        kinds.append(columns.placements_table(cells_of_a_foot))
    if channels:
        kinds.append(columns.weights_together_table(channels))
        kinds.append(columns.weights_together_table(channels, known_wrench=True))
        kinds.append(columns.cells_table(channels))
        if loaded:
            kinds.append(columns.weights_stream_table(channels))
    return kinds


def _refuse(session: Session[Any]) -> None:
    paths = session.every_path()
    if paths:
        missing = next((path for path in paths if not path.is_file()), None)
        if missing is None:
            raise DataError(
                "the columns are those of no known kind of log", file=paths[0],
                remedy="map them in the recipe's [columns]", foreign=True,
            )  # fmt: skip
    session.read_required(columns.weights_table())
