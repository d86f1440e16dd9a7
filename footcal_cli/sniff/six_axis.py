"""Logs of six-axis transducers: hanging under gravity, or under the feet of a robot."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import Attitude, attitude_of, named_orientation
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.plan import MASS, Blank, Entry, Plan, of, times
from footcal_cli.sniff.units import known_unit

_AXIS_COLUMNS = {"fx": "fx_n", "fy": "fy_n", "fz": "fz_n", "tx": "tx_nm", "ty": "ty_nm",
                 "tz": "tz_nm"}  # fmt: skip


COUNTED = Blank(
    ("# in [columns]: factor of fx_n … tz_nm, newtons or newton metres in one count",),
    "the six axes are counts, and nothing says how many make a newton",
)
_MOST_N = 20_000.0
_LONGEST_LEVER = 5.0
"""Torques that change so much beside forces of unknown unit are not in Nm."""
TURNED = Blank(
    ("# the attitude in [columns] must be the transducer's own",),
    "in this attitude the forces are not the weight of one thing: it may be that of another frame",
)


def transducers(file: FileGuess, six: dict[str, dict[str, ColumnGuess]]) -> Plan:
    """Six-axis transducers: hanging with an attitude, or feet that stand and walk."""
    labels = [c for c in file.of("label") if c.words]
    pose = attitude_of(file, None if labels else forces_of(next(iter(six.values()))))
    orientation = [c for c in file.of("orientation") if c.words]
    time, rate, blanks = times(file, needed=True)
    entries: dict[str, Entry] = dict(time)
    warnings = [] if pose is None else list(pose.warnings)
    if pose is not None:
        entries |= pose.entries
    elif orientation:
        pose = _named_rows(orientation[0], None if labels else next(iter(six.values())))
        entries |= {"orientation": of(orientation[0])} if pose is None else pose.entries
        warnings = [] if pose is None else list(pose.warnings)
    sides = {name.partition("_")[0] for name in six}
    if sides >= {"left", "right"} and len(six) == 2 and not orientation:
        return _ankles(file, six, entries, tuple(blanks))
    sign = -1.0 if pose is not None and pose.reacts else 1.0
    said = _said_above(file)
    wide = {name: _axes(group, said, sign) for name, group in six.items()} if len(six) > 1 else {}
    if not wide:
        entries |= _axes(next(iter(six.values())), said, sign)
        leg = next(iter(six))
        entries["leg"] = of(labels[0]) if labels else Entry(value=leg, why="one transducer")
    else:
        warnings.append("every transducer is taken to hang free of the ground")
    for column in file.of("phase", "temperature"):
        key = "phase_rad" if column.quantity == "phase" else "temperature_degc"
        entries.setdefault(key, of(column, column.unit))
    missing: tuple[Blank, ...] = ()
    if pose is not None and pose.explains is False:
        missing = (TURNED,)
    elif pose is None and not orientation:
        missing = (Blank(
            ('# body_qx = "…"    # the attitude: body_qx … body_qw, or body_roll_rad …, or',
             "#                  # body_r11 … body_r33, or gravity_x gravity_y gravity_z"),
            "the log has no attitude, so nothing says which way gravity pulls",
        ),)  # fmt: skip
    if _counted(six) and "f" not in said.per_count:
        missing = (*missing, COUNTED)
    weight = Blank(("# leg_weight_n =    # what hangs on the transducer, roughly",),
                   "a start only: the weight is estimated", False)  # fmt: skip
    return Plan(
        file, f"{len(six)} six-axis transducer{'s' * (len(six) > 1)} turned under gravity",
        "six axes" + (" and an attitude" if pose else " and orientations" if orientation else ""),
        "likely" if pose or orientation else "guess", "hang-calib", "hang", entries, (), wide,
        "leg", rate, blanks=(*missing, weight, *blanks), warnings=tuple(warnings),
    )  # fmt: skip


def forces_of(group: dict[str, ColumnGuess]) -> FloatArray:
    """Forces of a transducer, shape (n, 3)."""
    return np.column_stack([group[axis].values for axis in ("fx", "fy", "fz")])  # type: ignore[misc]


def _named_rows(column: ColumnGuess, six: dict[str, ColumnGuess] | None) -> Attitude | None:
    """Orientations that a column of texts names, as the forces say they were meant."""
    if six is None or column.codes is None:
        return None
    force = forces_of(six)
    there = [i for i in range(len(column.words)) if np.any(column.codes == i)]
    means = np.array([np.nanmean(force[column.codes == i], axis=0) for i in there])
    return named_orientation([column.words[i] for i in there], of(column), means)


@dataclass(frozen=True)
class _Said:
    """What lines above the table say of forces (``f``) and torques (``t``).

    Parameters
    ----------
    per_count
        Newtons or newton metres, or what `unit` says, in one count.
    unit
        Of the values.
    """

    per_count: Mapping[str, float]
    unit: Mapping[str, str]


def _said_above(file: FileGuess) -> _Said:
    """Counts per newton and units in the lines above a table, as Net F/T writes them."""
    per_count, unit = {}, {}
    for line in file.text.above:
        plain = line.replace('"', "")
        counts = re.search(r"counts per (?:unit )?(force|torque)\W+([\d.]+(?:e\d+)?)", plain, re.I)
        if counts and float(counts[2]) > 0:
            per_count[counts[1][0].lower()] = 1.0 / float(counts[2])
        named = re.search(r"(force|torque) units?\W+([A-Za-z.*-]+)", plain, re.I)
        if named and (known := known_unit(named[2])) is not None:
            unit[named[1][0].lower()] = known
    return _Said(per_count, unit)


def _counted(six: dict[str, dict[str, ColumnGuess]]) -> bool:
    """Whether all axes are whole numbers of a size that newtons do not have."""
    axes = [c for group in six.values() for c in group.values()]
    return all(c.counts and c.unit is None and c.name.factor == 1.0 for c in axes) and any(
        c.values is not None and float(np.nanmax(np.abs(c.values))) > _MOST_N for c in axes
    )


def _lever(group: dict[str, ColumnGuess]) -> float:
    """How much the torques change beside the forces: metres, if they are in N and Nm."""
    values = np.column_stack([group[axis].values for axis in _AXIS_COLUMNS])  # type: ignore[misc]
    spread = np.nanstd(values, axis=0)
    force, torque = float(np.linalg.norm(spread[:3])), float(np.linalg.norm(spread[3:]))
    return torque / force if force > 0 else 0.0


def _axes(
    group: dict[str, ColumnGuess], said: _Said, sign: float = 1.0, prefix: str = ""
) -> dict[str, Entry]:
    entries = {}
    torque = "N*mm" if _lever(group) > _LONGEST_LEVER else "N*m"
    for axis, name in _AXIS_COLUMNS.items():
        column, kind = group[axis], axis[0]
        unit = column.unit or said.unit.get(kind) or ("N" if kind == "f" else torque)
        factor = sign * column.name.factor
        factor *= said.per_count.get(kind, 1.0) if column.counts else 1.0
        entries[prefix + name] = replace(of(column, unit), factor=None if factor == 1 else factor)
    return entries


_MOUNTED = (
    "# if known: no log says how the transducer is mounted.\n"
    "# transducer_position_m = [0.0, 0.0, 0.0]    # in the logged foot frame\n"
    "# weight_below_n = 0.0    # what hangs below the transducer"
)


def _ankles(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], entries: dict[str, Entry],
    blanks: tuple[Blank, ...],
) -> Plan:  # fmt: skip
    entries = {name: entry for name, entry in entries.items() if name == "time_s"}
    said = _said_above(file)
    for name, group in six.items():
        entries |= _axes(group, said, prefix=f"{name.partition('_')[0]}_")
    body = body_entries(file)
    entries |= {name: entry for name, entry in body.items() if name != "time_s"}
    command = "online-replay" if file.of("com") else "static-init"
    moves = ", with the body's motion" if file.of("com") else ""
    return Plan(
        file, f"six-axis transducers at two feet{moves}",
        "six axes on the left and on the right", "likely", command, "cells", entries, (),
        robot=(f"[robot.feet.left]\n{_MOUNTED}", f"[robot.feet.right]\n{_MOUNTED}"),
        blanks=(MASS, *blanks),
    )  # fmt: skip


def body_entries(file: FileGuess) -> dict[str, Entry]:
    """The robot's own stream: stamps, centre of mass, its acceleration, poses of the feet."""
    entries, _, _ = times(file, needed=False)
    for quantity, pattern in (("com", "com_{}_m"), ("com_acc", "com_acc_{}_mps2")):
        entries |= {pattern.format(c.name.axis): of(c) for c in file.of(quantity)}
    return entries | _feet_poses(file)


def _feet_poses(file: FileGuess) -> dict[str, Entry]:
    """Poses of the feet beside the transducers."""
    found: dict[str, Entry] = {}
    for side in ("left", "right"):
        for column in file.columns:
            if column.name.side != side or column.values is None:
                continue
            plain = column.column.lower()
            last = re.split(r"[_.\s]", plain)[-1]
            if column.quantity == "quaternion" and column.name.axis in "xyzw":
                found[f"{side}_foot_q{column.name.axis}"] = of(column)
            elif last in ("x", "y", "z") and "foot" in plain and column.quantity != "force":
                found[f"{side}_foot_{last}_m"] = of(column, column.unit or "m")
            elif last == "yaw" and "foot" in plain:
                found[f"{side}_foot_yaw_rad"] = of(column, column.unit or "rad")
    return found
