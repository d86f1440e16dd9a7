"""Load cells in time, standing or walking, alone or with the body's motion in the same table."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.clocks import restarts
from footcal_cli.sniff.groups import channel_names
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of, seconds_of
from footcal_cli.sniff.motion import body_entries, upright, walks
from footcal_cli.sniff.names import without_side, words_of
from footcal_cli.sniff.plan import (
    FORCES,
    IN_NEWTON,
    MASS,
    Blank,
    Entry,
    LogPlan,
    extras,
    reading_entry,
    times,
)
from footcal_cli.sniff.still_feet import on_still_feet

NAMEPLATE = Blank(
    ("# [robot.nameplate]", "# scale_n_per_count =    # by the data sheet; zero_counts too"),
    "nothing says how many newtons a count is; or give --parameters of a bench calibration",
)
WEIGHTS = Blank(
    (
        "# weights = […]    # in [data]: each cell under known weights; or by its maker:",
        "# [robot.nameplate]",
        "# scale_n_per_count = 1.0    # of readings in newtons",
    ),
    "no log calibrates the cells: their scale is found from the weights on the plate, better with "
    "weights on each cell, --parameters, or the makers' scale",
    needed=False,
)


def cells_in_time(file: FileGuess, cells: list[ColumnGuess], *, legs: bool = False) -> LogPlan:
    """Several cells in time: feet that stand or walk.

    Parameters
    ----------
    legs
        Whether the body's stream has a foot for each of front and rear, left and right.
    """
    cells = [_in_newton(c) for c in _of_feet(cells)]
    found = channel_names(cells)
    # hind legs: a cell in each foot
    points = {"hl", "hr"} <= set(found) or (legs and {"rl", "rr"} <= set(found))
    points |= len(cells) > 2 and [c.name.side for c in cells] == [*found]
    on = "plate" if _PLATES & set(words_of(f"{file.path.stem} {' '.join(found)}")) else "foot"
    # a vertical force of each of several plates: each is one by itself
    alone = on == "plate" and all(c.name.axis == "fz" and not c.name.side for c in cells)
    points = points or (alone and len(cells) > 1)
    cell = "plate" if alone else "foot"
    named = {f"{n}_{cell}" if points else _on_foot(n, c, on): c for n, c in found.items()}
    time, rate, blanks = times(file, needed=True)
    forces = all(c.unit in FORCES for c in cells)
    down = forces and float(np.nanmedian(np.sum([numbers_of(c) for c in cells], axis=0))) < 0
    read = {f"{n}_counts": reading_entry(c) for n, c in named.items()}
    if down:
        read = {name: replace(entry, factor=-1.0) for name, entry in read.items()}
    still = on_still_feet(body_entries(file) if file.of("com") else {}, tuple(
        dict.fromkeys(name.partition("_")[0] for name in named)
    ), {**time, **read})  # fmt: skip
    body = still.entries
    if {"com_x_m", "com_y_m"} <= {*body} and "com_z_m" not in body and not walks(body):
        body = {**body, "com_z_m": _HEIGHT}
    again = bool(body) and not walks(body) and _begins_again(file)
    if again:
        time, rate = {}, float(f"{file.rate_hz:.4g}")
        body = {name: entry for name, entry in body.items() if name != "time_s"}
    entries = {**time, **read}
    if "temperature_degc" in (beside := extras(file)):
        entries["temperature_degc"] = beside["temperature_degc"]
    feet: dict[str, list[str]] = {}
    for name in named:
        foot, _, place = name.partition("_")
        feet.setdefault(foot, []).append(place)
    lines: list[str] = []
    for foot, places in feet.items():
        lines.append(f"# [robot.feet.{foot}.cells]    # x forward, y left, from the foot's origin")
        lines += [f"# {toml_key(place)} = {{ x_m = , y_m =  }}" for place in places]
    positions = [Blank(tuple(lines), WHERE)]
    tables: tuple[str, ...] = ()
    if points:
        why = "likely: one cell in the foot's point" if cell == "foot" else "likely: its force"
        tables = tuple(
            f"[robot.feet.{foot}.cells]\n{cell} = {{ x_m = 0.0, y_m = 0.0 }}    # {why}"
            for foot in found
        )
        positions = []
    doubt = [] if any(said_to_be_cells(c) for c in cells) else [UNNAMED]
    doubt += [] if any(c.name.side or c.name.place for c in cells) or points else [_OR_WEIGHTS]
    plates = [] if forces else [NAMEPLATE]
    tables = (*tables, IN_NEWTON) if forces else tables
    return LogPlan(
        file,
        f"{len(cells)} load cells in time: standing or walking"
        + (", with the body's motion" if body else ""),
        f"a wide table of {len(cells)} readings" + (" and time" if time else ""),
        "guess" if UNNAMED in doubt else "likely",
        "online-replay" if walks(body) else "static-init", "cells", {**body, **entries},
        tuple(named),
        rate_hz=rate, robot=(*upright(file, body), *tables),
        blanks=(*doubt, MASS, *positions, *plates, *still.blanks, *blanks),
        warnings=(
            *(_COUNTED,) * again,
            *("the forces are negative when a cell is pressed: read with reversed sign",) * down,
            *(f"{c.column}: never changes, a dead cell" for c in cells if not _moves(c)),
        ),
    )  # fmt: skip


def _begins_again(file: FileGuess) -> bool:
    """Whether stamps begin again within the log, as those of stances below each other."""
    stamps = next((seconds_of(column) for column in file.of("time")), None)
    if stamps is None or not file.rate_hz or not restarts(stamps):
        return False
    return float(np.nanmin(np.diff(stamps))) * file.rate_hz < -_STANCE_ROWS


def _of_feet(cells: list[ColumnGuess]) -> list[ColumnGuess]:
    """Cells without what is under no foot, where several under each foot are named so."""
    return [c for c in cells if c.name.side] if of_both_feet(cells) else cells


def of_both_feet(columns: list[ColumnGuess]) -> bool:
    """Whether several columns each are of a left and of a right foot."""
    sides = [c.name.side for c in columns]
    return min(sides.count("left"), sides.count("right")) > 1


_HEIGHT = Entry(
    value="0.8", sure="guess", why="no log says how high it is: at rest it hardly matters"
)
WHERE = "no log says where the cells sit"
_STANCE_ROWS = 20
_COUNTED = "the stamps begin again, with each stance: rows are counted at their usual rate instead"
_PLATES = {"plate", "platform", "board", "platte"}
_OR_WEIGHTS = Blank(
    ("# under known weights: write them into a column of the log (load_kg), then footcal init",),
    "known weights that lay on the cells belong into a column of the log (load_kg): add it and run "
    "init again; without such",
)  # fmt: skip
UNNAMED = Blank(
    ("# keep only readings of load cells in [columns] below",),
    "nothing in the log says that its numbers are readings of load cells",
)


def said_to_be_cells(column: ColumnGuess) -> bool:
    """Whether a name, a unit or whole counts say that a column is the reading of a load cell."""
    named = column.quantity in ("reading", "force") or column.name.side or column.name.place
    return bool(named or column.counts or column.unit in FORCES)


def _moves(cell: ColumnGuess) -> bool:
    return bool(np.nanmax(numbers_of(cell)) > np.nanmin(numbers_of(cell)))


def _in_newton(cell: ColumnGuess) -> ColumnGuess:
    """A vertical force by its name is in newtons, unless the name says otherwise."""
    named = cell.quantity == "force" and cell.name.axis == "fz" and cell.unit is None
    return replace(cell, unit="N") if named and not cell.counts else cell


def _on_foot(name: str, cell: ColumnGuess, on: str) -> str:
    """A cell's name behind that of its foot: ``left_fl``; behind `on` where none is named."""
    if cell.name.side and cell.name.place and name == cell.name.address:
        return name.replace("_foot_", "_", 1)
    foot, _, place = name.partition("_")
    if foot in ("left", "right") and place:
        return f"{foot}_{place.removeprefix('foot_')}"
    side = cell.name.side
    plain = without_side(name, side).removeprefix("foot_") if side else name
    return f"{side or on}_{plain.removeprefix(f'{on}_') or 'cell'}"


def toml_key(name: str) -> str:
    """A name as the key of a TOML table."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else f'"{name}"'
