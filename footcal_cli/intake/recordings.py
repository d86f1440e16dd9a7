"""Logs of standing and walking as the core wants them: tables and recipe to streams and beliefs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.body_stream import check_overlap, check_rates, note_differentiated
from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import calibration_of
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import BIAS_SD_N, GAIN_SD, Belief, belief_from, nameplate
from footcal_cli.core.online.merging import merge_cells, merge_six_axis
from footcal_cli.core.online.six_axis import BELOW_SHARE, PRIOR_SD
from footcal_cli.core.online.streams import BodyStream, Merged, MergeRule, SensorStream
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.plausibility import check_total_force, check_walking_cells
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import interpolate_slow
from footcal_cli.core.spatial import rotation_of_rpy
from footcal_cli.errors import DataError, UsageError
from footcal_cli.intake.cell_effects import cells_in_feet, without_cell_effects
from footcal_cli.intake.continued import with_parts_joined
from footcal_cli.intake.streams import body_stream_of, has_momentum, no_body, sensor_stream_of
from footcal_cli.intake.wiring import wiring_of
from footcal_cli.intake.zeros import Zeros, use_zeros
from footcal_cli.recipe import Foot, Robot
from footcal_cli.records.effects import effect_of
from footcal_cli.records.results import ParametersRecord
from footcal_cli.tables.columns import TableType, body_table, cells_table, six_axis_feet_table
from footcal_cli.tables.places import every_entry
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_NAMED = 8
"""So many columns are named in one finding."""
_LEAST_BIAS_SD_N = 1e-3
_DRIFT_SHARE = 0.005
"""What a cell's zero may move by, of the robot's weight, since it was calibrated."""
_FEWEST_ROWS = 4
"""Filters need as many; a file of fewer rows holds something else, such as readings in the air."""


@dataclass(frozen=True)
class Recording:
    """One log of standing or walking, read.

    Parameters
    ----------
    belief
        Prior of the cells; None for six-axis feet.
    name
        File name of the sensors' log.
    no_body, no_angular_momentum
        What the log came without.
    temperature_degc
        At the rows of the merged log, (n,); None where it was not recorded.
    """

    merged: Merged
    belief: Belief | None
    feet: tuple[str, ...]
    name: str
    no_body: bool
    no_angular_momentum: bool
    temperature_degc: FloatArray | None = None


def is_six_axis_robot(robot: Robot) -> bool:
    """Whether the feet stand on six-axis transducers."""
    return bool(robot.feet) and all(not foot.cells for foot in robot.feet.values())


def read_recordings(
    session: Session[Any], rule: MergeRule, experiment: str, *, body_needed: bool = True
) -> list[Recording]:
    """Read every sensor log of a session with its body stream and merge them.

    The body stream stands in the same file or, log by log in the same order, in files of its own.

    Raises
    ------
    UsageError
        The recipe lacks the feet or the mass, or nothing says what the cells' counts mean.
    DataError
        A log lacks its body stream.
    """
    robot, feet = _walker(session), tuple(session.recipe.robot.feet)
    sensor_type = (
        six_axis_feet_table(feet) if is_six_axis_robot(robot) else cells_table(robot.cell_names)
    )
    sensors, bodies = _pairs(session, sensor_type, body_table(feet))
    zeros = None if is_six_axis_robot(robot) else use_zeros(session, robot.cell_names)
    if body_needed and not bodies:
        raise _body_missing(session, body_table(feet), sensors[0].path)
    return [
        _read_one(session, table, bodies[i] if bodies else None, rule, experiment, zeros)
        for i, table in enumerate(sensors)
    ]


def _walker(session: Session[Any]) -> Robot:
    """The recipe's robot, which has feet and a mass."""
    robot, path = session.recipe.robot, session.recipe.path
    if not robot.feet:
        raise session.lacks("no feet are described", "add [robot.feet.<name>] to the recipe")
    if robot.mass_kg is None:
        raise session.lacks(
            "no mass is given", "give mass_kg in [robot], batteries and cables included"
        )
    if not is_six_axis_robot(robot):
        require_feet_of_cells(robot, path)
    return robot


def _read_one(
    session: Session[Any], table: Table, body: Table | None, rule: MergeRule, experiment: str,
    zeros: Zeros | None,
) -> Recording:  # fmt: skip
    """One sensor log and its body stream, merged; what looks wrong is noted."""
    if len(table) < _FEWEST_ROWS:
        raise DataError(
            f"{len(table)} rows are no recording of a robot that stands or walks", file=table.path,
            remedy="take the file out of the cells in [data], or record for some seconds",
        )  # fmt: skip
    robot, feet = session.recipe.robot, tuple(session.recipe.robot.feet)
    six_axis = is_six_axis_robot(robot)
    channels = (
        tuple(f"{foot}.{axis}" for foot in feet for axis in AXES) if six_axis else robot.cell_names
    )
    stream = sensor_stream_of(table, channels, feet if six_axis else (), robot.adc.lost_reading)
    motion = body_stream_of(body, feet) if body is not None else no_body(stream, len(feet))
    belief = None
    if six_axis:
        merged = _merge_six_axis(stream, motion, robot, rule, experiment)
        if session.parameters is not None:
            log = without_transducer_effects(merged.log, session.parameters)
            merged = replace(merged, log=log)
    else:
        assert robot.mass_kg is not None, "a walker"
        belief = prior_belief(session.parameters, robot, channels, zeros)
        moving = None if body is None else _moving(stream, motion, rule, robot.mass_kg)
        stream, belief, places = _checked_cells(session, table, stream, belief, moving, experiment)
        merged = merge_cells(
            stream, motion, belief, places, robot.mass_kg, robot.gravity_mps2,
            experiment=experiment, rule=rule,
        )  # fmt: skip
    if body is not None:
        _note_clocks(session, stream, motion, table.path, body.path)
    session.note(wiring_of(merged, belief, experiment))
    return Recording(
        merged, belief, feet, table.path.name, body is None,
        body is None or not has_momentum(body), _temperature(table, stream, merged),
    )  # fmt: skip


def _note_clocks(
    session: Session[Any], stream: SensorStream, motion: BodyStream, log: Path, body: Path
) -> None:
    """Note stamps of both streams that do not fit each other, and rates that cannot be."""
    own = body.name if body != log else "its body stream"
    session.note(check_overlap(stream.time_s, motion.time_s, log.name, own))
    acc = motion.com_acc_mps2
    moved = np.hstack([motion.com_m, acc] if np.isfinite(acc).any() else [motion.com_m])
    session.note(note_differentiated(acc, velocity=motion.com_vel_mps is not None))
    session.note(check_rates(stream.time_s, stream.readings, motion.time_s, moved, log.name))


def _temperature(table: Table, stream: SensorStream, merged: Merged) -> FloatArray | None:
    """Temperature at the rows of a merged log; it changes slowly."""
    if "temperature_degc" not in table:
        return None
    return interpolate_slow(stream.time_s, table.number("temperature_degc"), merged.log.time_s)


def _checked_cells(
    session: Session[Any],
    table: Table,
    stream: SensorStream,
    belief: Belief,
    moving: dict[str, FloatArray] | None,
    experiment: str,
) -> tuple[SensorStream, Belief, tuple[FloatArray, ...]]:
    """Cells without the effects that a calibration knows, what is then believed, and their places.

    What looks wrong with the readings is noted.
    """
    robot = session.recipe.robot
    start_n = belief.scale_n_per_count * stream.readings + belief.bias_n
    note_carried(session, start_n, table.path.name, walking=experiment == "walk")
    if session.parameters is None:
        if experiment == "walk" and "bias_sd_n" not in robot.nameplate.model_fields_set:
            belief = belief.with_zeros_in_the_air(start_n)
        return stream, belief, cells_in_feet(robot)
    warmth = table.number("temperature_degc") if "temperature_degc" in table else None
    undone = without_cell_effects(stream, session.parameters, robot, warmth, moving=moving)
    session.note(undone.findings)
    return undone.stream, belief.widened(undone.gain_sd, undone.bias_sd_n), undone.cells_m


def note_carried(session: Session[Any], forces_n: FloatArray, name: str, *, walking: bool) -> None:
    """Note what is odd about cell forces (n, c) as first believed: their sum and, walking, each."""
    robot = session.recipe.robot
    session.note(check_total_force(forces_n.sum(axis=1), robot.weight_n, name))
    if walking:
        foot_of = [foot for foot, spec in robot.feet.items() for _ in spec.cells]
        known = {f.where for f in session.noted if f.severity == "alarm"}
        found = check_walking_cells(forces_n, robot.cell_names, foot_of, name)
        session.note(f for f in found if f.where not in known)


def _moving(
    stream: SensorStream, motion: BodyStream, rule: MergeRule, mass_kg: float
) -> dict[str, FloatArray]:
    """Mass and acceleration of the CoM when the cells were read; the body's stamps are late."""
    good = np.isfinite(motion.time_s) & np.isfinite(motion.com_acc_mps2).all(axis=1)
    if not good.any():
        return {}
    then = motion.time_s[good] - rule.delay_s
    acc = [np.interp(stream.time_s, then, a) for a in motion.com_acc_mps2[good].T]
    return {
        "mass_kg": np.full(len(stream.time_s), mass_kg), "com_acc_mps2": np.stack(acc, axis=1)
    }  # fmt: skip


def _body_missing(session: Session[Any], body_type: TableType, log: Path) -> DataError:
    """What the body stream lacks, as far as it stands in the sensors' own log."""
    lacks = ""
    try:
        session.read_required(body_type, role="cells")
    except DataError as error:
        lacks = f": {error.problem}"
    return DataError(
        f"no log has the whole body stream{lacks}", file=log,
        remedy="name its log in [data] body, or map its columns; `footcal kinematics` makes them",
    )  # fmt: skip


def _pairs(
    session: Session[Any], sensor_type: TableType, body_type: TableType
) -> tuple[list[Table], list[Table]]:
    """Sensor logs, and the body logs that belong to them; copies of sensor logs go with theirs."""
    in_order = session.read_in_order(sensor_type, role="cells")
    if not in_order:
        session.read_required(sensor_type, role="cells")  # says what is missing
    # a body stream is no evidence of its own: two sensor logs may share one
    role = "body" if session.paths("body") else "cells"
    bodies: list[Table] = []
    if role == "body" or session.holds(body_type, role):
        bodies = [t for t in session.read_in_order(body_type, role, copies=True) if t is not None]
    else:
        session.note(_incomplete(session, body_type))
    if bodies and len(bodies) != len(in_order):
        raise UsageError(
            f"{len(in_order)} sensor logs but {len(bodies)} body logs",
            remedy="name one body log per sensor log, in the same order",
        )
    kept = [i for i, table in enumerate(in_order) if table is not None]
    sensors = [table for table in in_order if table is not None]
    return with_parts_joined(sensors, [bodies[i] for i in kept] if bodies else [])


def _incomplete(session: Session[Any], body_type: TableType) -> Iterator[Finding]:
    """The first log whose motion is left out because columns are missing, and which these are."""
    needed = [column.name for column in body_type.columns if not column.optional]
    for path in filter(Path.is_file, session.paths("cells")):
        found = every_entry(body_type, session.recipe.reading(path), path)[0].found
        there = [name for name in needed if name in found and name != "time_s"]
        lacks = [name for name in needed if name not in found]
        if not there or not lacks:
            continue
        flat = all(name.endswith("_foot_z_m") for name in lacks)
        yield Finding(
            "body_incomplete", "warning", path.name,
            f"the motion is left out: {', '.join(there[:_NAMED])} … are there, "
            f"{', '.join(lacks[:_NAMED])} {'is' if len(lacks) == 1 else 'are'} missing",
            "where soles lie on the floor from which the CoM's z counts, say in [columns]: "
            + ", ".join(f"{name} = {{ value = 0.0 }}" for name in lacks) if flat
            else "log them, or map them in [columns]",
        )  # fmt: skip
        return


def without_transducer_effects(log: Log, record: ParametersRecord) -> Log:
    """What transducers and body without the effects of a calibration would have shown.

    Offsets stay in: the walk or the stand finds them.
    """
    offsets = Chain((link(calibration_of(log.channels), log.channels),))
    extended = offsets
    for item in record.effects:
        effect = effect_of(item)
        if Trait.CALIBRATION not in effect.traits:
            extended = extended.with_link(Link(effect, dict(item.owners)))
    if len(extended.links) == 1:
        return log
    values = record.values
    good = np.asarray(np.isfinite(log.readings).all(axis=1))
    truth, _ = extended.remove(log.with_readings(np.nan_to_num(log.readings)), values)
    shown, _ = offsets.apply(truth, values)
    return shown.with_readings(np.where(good[:, None], shown.readings, np.nan))


def require_feet_of_cells(robot: Robot, path: Path | None) -> None:
    """Refuse channels that are the cells of no foot, and cells that no channel reads.

    Raises
    ------
    UsageError
        Names them.
    """
    own = [f"{foot}_{cell}" for foot, spec in robot.feet.items() for cell in spec.cells]
    odd = [name for name in robot.cell_names if name not in own]
    odd += [name for name in own if name not in robot.cell_names]
    if odd:
        raise UsageError(
            f"channels and feet of the recipe do not fit: {', '.join(odd[:4])}", file=path,
            remedy="name channels <foot>_<cell> of [robot.feet.<foot>.cells], or leave them out",
        )  # fmt: skip


def prior_belief(
    record: ParametersRecord | None, robot: Robot, channels: tuple[str, ...],
    zeros: Zeros | None = None,
) -> Belief:  # fmt: skip
    """What is believed of the cells: an earlier calibration, or the nameplate.

    An earlier calibration is widened: mounting a cell moves scale and zero, and so do days. Zeros
    that were read on the mounted cells (in `record` already) are as sure as they came again.
    """
    plate = robot.nameplate
    if record is not None:
        for channel in channels:
            record.value(f"{channel}.scale")
            record.value(f"{channel}.bias")
        scale = np.array([record.value(f"{channel}.scale") for channel in channels])
        drift = plate.mounted_bias_sd_n or min(
            plate.bias_sd_n, max(BIAS_SD_N, _DRIFT_SHARE * (robot.weight_n or 0.0))
        )
        if zeros is not None and zeros.sd_n(scale) is not None:
            drift = _LEAST_BIAS_SD_N
        return belief_from(
            record.estimates, channels,
            least_gain_sd=plate.mounted_scale_relative_sd or min(plate.scale_relative_sd, GAIN_SD),
            least_bias_sd_n=drift,
        )  # fmt: skip
    if plate.scale_n_per_count is None:
        raise UsageError(
            "nothing says what the counts mean",
            remedy="give --parameters (from offline-fit), or scale_n_per_count and zero_counts in "
            "[robot.nameplate]",
        )
    scale = np.full(len(channels), plate.scale_n_per_count)
    at, sd = (plate.zero_counts, None) if zeros is None else (zeros.counts, zeros.sd_n(scale))
    return nameplate(
        channels, scale, -scale * at, plate.scale_relative_sd,
        plate.bias_sd_n if sd is None else max(sd, _LEAST_BIAS_SD_N),
    )  # fmt: skip


def _sd_below(foot: Foot, robot: Robot) -> float:
    """How far the stated weight below a transducer may be off, N."""
    if foot.weight_below_sd_n is not None:
        return foot.weight_below_sd_n
    return BELOW_SHARE * robot.weight_n if robot.weight_n else PRIOR_SD["weight"][1]


def _merge_six_axis(
    stream: SensorStream, body: BodyStream, robot: Robot, rule: MergeRule, experiment: str
) -> Merged:
    feet: Mapping[str, Any] = robot.feet
    placed = tuple(
        (
            np.array(foot.transducer_position_m or (0.0, 0.0, 0.0)),
            rotation_of_rpy(foot.transducer_rotation_rpy_rad),
        )
        for foot in feet.values()
    )
    return merge_six_axis(
        stream,
        body,
        placed,
        np.array([(foot.weight_below_n, _sd_below(foot, robot)) for foot in feet.values()]),
        np.array([foot.com_below_m for foot in feet.values()]),
        float(robot.mass_kg or 0.0),
        robot.gravity_mps2,
        experiment=experiment,
        rule=rule,
    )
