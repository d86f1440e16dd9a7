"""Six-axis transducers and plates under feet: plans for standing and walking.

Room: sniff; asked by six_axis.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from footcal_cli.sniff.axes import axes_of, said_above
from footcal_cli.sniff.cells import toml_key
from footcal_cli.sniff.foot_mounts import Mount, foot_mount, point_down
from footcal_cli.sniff.groups import transducers_by_stem
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.in_series import quiet_start_s
from footcal_cli.sniff.motion import body_entries, upright, walks
from footcal_cli.sniff.plan import IN_NEWTON, MASS, Blank, Entry, LogPlan, times
from footcal_cli.sniff.still_feet import on_still_feet


def in_series(
    file: FileGuess, pairs: Sequence[tuple[str, str]], time: Mapping[str, Entry]
) -> LogPlan:
    """Two transducers in each leg, and nothing else known of the robot: what each pair must share.

    Parameters
    ----------
    file
        The log.
    pairs
        Names of transducers, the upper one first.
    time
        The entry of stamps.
    """
    groups, said = transducers_by_stem(file), said_above(file)
    names = [name for pair in pairs for name in pair]
    entries = dict(time)
    for name in names:
        entries |= axes_of(groups[name], said, prefix=f"{name}_")
    listed = ", ".join(f'["{upper}", "{lower}"]' for upper, lower in pairs)
    return LogPlan(
        file, f"{len(names)} six-axis transducers, two in series in each of {len(pairs)} legs",
        "the forces in a leg change together, and no attitude, mass or motion of the body is "
        "there", "likely", "pose-calib", "six_axis_feet", entries,
        options=(
            'fit = "series"', f"series = [{listed}]",
            f"quiet_s = {quiet_start_s(file, names):g}    # likely: then the forces move",
        ),
    )  # fmt: skip


def plates_of(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], rate: float | None,
    blanks: tuple[Blank, ...],
) -> LogPlan:  # fmt: skip
    """Six-axis plates that carry one weight: their vertical forces, which need no body stream."""
    entries, _, _ = times(file, needed=True)
    said, tables, down = said_above(file), [], point_down(six)
    for name, group in six.items():
        entries[f"{name}_plate_counts"] = axes_of(group, said, -1.0 if down else 1.0)["fz_n"]
        tables.append(f"[robot.feet.{toml_key(name)}.cells]\nplate = {{ x_m = 0.0, y_m = 0.0 }}")
    return LogPlan(
        file, f"{len(six)} six-axis plates under one weight", "vertical forces that add up to what "
        "hardly changes", "likely", "static-init", "cells", entries,
        tuple(f"{name}_plate" for name in six), rate_hz=rate, robot=(*tables, IN_NEWTON),
        blanks=(MASS, *blanks),
        warnings=("the vertical forces are calibrated; horizontal forces and moments need the "
                  "motion of the body, [data] body",
                  *((_REVERSED,) * down)),
        moving=ankles(file, six, dict(entries), ()),
    )  # fmt: skip


_PLATE = re.compile(r"(?i)plat|\bfp|belt|^f?p?_?\d+$")
_NOTHING_BELOW = "weight_below_sd_n = 0.0    # likely: a plate, below which nothing hangs"
_SIX = ("_fx_n", "_fy_n", "_fz_n", "_tx_nm", "_ty_nm", "_tz_nm")
_REVERSED = "the vertical forces are negative: read with reversed sign"


def as_mounted(plan: LogPlan, mount: Mount | None) -> LogPlan:
    """A plan for transducers at feet whose signs and mounting the body's motion says."""
    if mount is None or not plan.feet:
        return plan
    entries = {
        name: replace(entry, factor=_signed(entry.factor, mount.sign))
        if name.endswith(_SIX) and entry.column is not None else entry
        for name, entry in plan.entries.items()
    }  # fmt: skip
    said = [one for one in plan.warnings if one != _REVERSED]
    warnings = (*said, *((_REVERSED,) * (mount.sign < 0)))
    return replace(plan, entries=entries, mounting=mount.line or plan.mounting, warnings=warnings)


def _signed(factor: float | None, sign: float) -> float | None:
    """A factor with that sign; None for one."""
    made = abs(1.0 if factor is None else factor) * sign
    return None if made == 1.0 else made


MOTION = Blank(
    ('# body = ["…"]    # in [data]: CoM, its acceleration and places of the feet;',
     "#                 # footcal kinematics makes them of joint positions and a URDF"),
    "transducers at feet are weighed with the body's motion, which the log does not have",
)  # fmt: skip


def ankles(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], entries: dict[str, Entry],
    blanks: tuple[Blank, ...],
) -> LogPlan:  # fmt: skip
    """Transducers at feet, with the motion of the body where the log has it."""
    entries = {name: entry for name, entry in entries.items() if name == "time_s"}
    said, logged = said_above(file), body_entries(file, on_cells=False)
    mount = foot_mount(six, logged) if len(six) > 1 else None
    mounting = "" if mount is None else mount.line
    down = point_down(six) if mount is None else mount.sign < 0
    for name, group in six.items():
        entries |= axes_of(group, said, -1.0 if down else 1.0, prefix=f"{name}_")
    still = on_still_feet(logged, tuple(six), entries)
    body = still.entries
    entries |= {name: entry for name, entry in body.items() if name != "time_s"}
    if all(_PLATE.search(name) for name in six):
        mounting = "\n".join([*([mounting] if mounting else []), _NOTHING_BELOW])
    command = "online-replay" if file.of("com") and walks(body) else "static-init"
    moves = ", with the body's motion" if file.of("com") else ""
    return LogPlan(
        file, f"six-axis transducers at {'two' if len(six) == 2 else len(six)} feet{moves}",
        "six axes of each, that carry a weight together", "likely", command, "cells", entries, (),
        robot=upright(file, body), feet=tuple(six), mounting=mounting,
        blanks=(MASS, *(() if file.of("com") else (MOTION,)), *still.blanks, *blanks),
        warnings=(_REVERSED,) * down,
    )  # fmt: skip
