"""Logs of six-axis transducers: hanging under gravity, or under the feet of a robot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import Attitude, attitude_of, named_orientation
from footcal_cli.sniff.axes import axes_of, said_above, unit_asked
from footcal_cli.sniff.cells import toml_key
from footcal_cli.sniff.groups import AT_THE_FOOT
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.hangings import (
    NO_ATTITUDE,
    OF_THE_BODY,
    not_one_weight,
    of_a_body,
    unnamed,
)
from footcal_cli.sniff.in_series import pairs_in_series
from footcal_cli.sniff.mounts import Mounts, mounts_of
from footcal_cli.sniff.plan import MASS, Blank, Entry, LogPlan, of, rate_said, times
from footcal_cli.sniff.pose_numbers import pose_numbers
from footcal_cli.sniff.shafts import beside, legs_first, shafts
from footcal_cli.sniff.six_axis_feet import ankles, in_series, plates_of
from footcal_cli.sniff.turned_legs import hung_in_own_frames
from footcal_cli.sniff.turning import turned_along
from footcal_cli.sniff.two_tools import tools_of

COUNTED = Blank(
    ("# in [columns]: factor of fx_n … tz_nm, newtons or newton metres in one count",),
    "the six axes are counts, and nothing says how many make a newton",
)
_MOST_N = 20_000.0
_LOADED, _TOGETHER = 10.0, 0.2
"""A weight is so much larger than its changes; what is shifted adds up to so much less."""
_ROWS_OF_A_POSE = 0.5
"""A pose that has two rows of each leg and more is a stretch of a stream."""
_HELD = 0.05
"""Share of the forces' variance over all poses that may be within one."""
_STILL = 0.05
"""Forces that scatter by so small a share of another transducer's do not feel what it feels."""
WHERE_LEGS = "no log says where the transducers sit"
HUNG_FIRST = Blank(
    ("# footcal hang-calib first, then pose-calib … --parameters …/parameters.json",),
    "standing poses need offsets and leg weights of a hanging calibration",
)
NO_PHASE = Blank(
    ('# in [files.wide…] of the poses: phase_rad = { column = "…", unit = "rad" }',),
    "the shaft turns while the robot hangs, and nothing says its angle in the poses",
)
TURNED = Blank(
    ("# the attitude in [columns] must be the transducer's own",),
    "in this attitude the forces are not the weight of one thing: it may be that of another frame",
)


_WEIGHT = "# leg_weight_n =    # if known roughly: what hangs on the transducer, a start of the fit"

_CHASSIS = "# chassis_com_m = [0.0, 0.0, 0.0]    # if known: CoM of what the transducers carry"


def transducers(file: FileGuess, six: dict[str, dict[str, ColumnGuess]]) -> LogPlan:
    """Six-axis transducers: hanging with an attitude, or feet that stand and walk."""
    if still := _still(six):
        plan = transducers(file, {name: group for name, group in six.items() if name not in still})
        why = f"{', '.join(still)}: left out, stands still while the others move"
        return replace(plan, warnings=(*plan.warnings, why))
    labels = legs_first([c for c in file.of("label") if c.words])
    forces = _forces(six, labels)
    pose = attitude_of(file, None if labels else forces_of(next(iter(six.values()))))
    orientation = [c for c in file.of("orientation") if c.words]
    mounts = None
    if len(forces) > 1 or (not orientation and pose is not None and pose.explains is False):
        mounts = mounts_of(file, forces)
    if orientation and mounts is not None:  # numbers are more exact than words, if forces agree
        orientation, mounts = ([], mounts) if mounts.hang else (orientation, None)
    if mounts is not None and mounts.hang is False:
        mounts = hung_in_own_frames(file, six, forces, mounts) or mounts
    hang = mounts is not None and mounts.hang is True
    if mounts is not None and mounts.hang is False and len(forces) > 2:
        standing = _poses(file, six, labels, mounts)
        if standing is not None:
            return standing
    pose = mounts.attitude if hang and mounts is not None else pose
    time, rate, blanks = times(file, needed=True)
    entries: dict[str, Entry] = dict(time)
    warnings = [] if pose is None else list(pose.warnings)
    if pose is not None:
        entries |= pose.entries
    elif orientation:
        body = of_a_body(orientation[0], forces) if len(forces) > 1 else None
        if body is not None:
            pose, mounts, hang = body.attitude, body.mounts, True
        else:
            pose = _named_rows(orientation[0], None if labels else next(iter(six.values())))
        entries |= {"orientation": of(orientation[0])} if pose is None else pose.entries
        warnings = [] if pose is None else list(pose.warnings)
    own = _own_attitudes(file, six) if len(six) > 1 and not orientation and not hang else {}
    if own:
        return _each_by_itself(file, six, own, time, rate, tuple(blanks))
    pairs = [] if pose is not None or orientation or file.of("com") else pairs_in_series(file)
    if pairs and time:
        return in_series(file, pairs, time)
    sides = {name.partition("_")[0]: group for name, group in six.items()}
    if sides.keys() >= {"left", "right"} and len(six) == 2 and not orientation and not hang:
        return ankles(file, sides, entries, tuple(blanks))
    moves = len(six) > 1 and bool(file.of("com"))
    if pose is None and not orientation and (moves or _stand(six)):
        if moves or _at_feet(six):
            return ankles(file, six, entries, tuple(blanks))
        return plates_of(file, six, rate, tuple(blanks))
    sign = -1.0 if pose is not None and pose.reacts else 1.0
    said = said_above(file)
    warnings += unit_asked(six.values(), said)
    wide = {name: axes_of(group, said, sign) for name, group in six.items()} if len(six) > 1 else {}
    if not wide:
        entries |= axes_of(next(iter(six.values())), said, sign)
        leg = next(iter(six))
        one = tools_of(file, six[leg]) or Entry(value=leg, why="one transducer")
        entries["leg"] = of(labels[0]) if labels else one
    elif not hang:
        warnings.append("every transducer is taken to hang free of the ground")
    entries |= _with_shafts(_without(file, entries), six, wide)
    for column in file.of("temperature"):
        entries.setdefault("temperature_degc", of(column, column.unit))
    missing: tuple[Blank, ...] = ()
    if pose is not None and pose.explains is False:
        known = _turned_along(file, six) or _dead_axis(six)
        missing = (not_one_weight(orientation, known) or TURNED,)
    elif pose is None and orientation:
        missing = (unnamed(orientation[0]),)
    elif pose is None and not orientation:
        missing = (NO_ATTITUDE,)
    if _counted(six) and "f" not in said.per_count:
        missing = (*missing, COUNTED)
    world: tuple[str, ...] = ()
    if pose is not None and pose.world_up != "+z":
        world = (f'world_up = "{pose.world_up}"    # in the attitudes',)
    turned = leg_tables(forces, mounts) if mounts is not None or len(forces) > 1 else ()
    axes_of_body = (OF_THE_BODY,) if "orientation" in entries and mounts is not None else ()
    if NO_ATTITUDE in missing and len(forces) > 1:
        axes_of_body = (f"# {OF_THE_BODY}",)
    return LogPlan(
        file, f"{len(forces)} six-axis transducer{'s' * (len(forces) > 1)} turned under gravity",
        "six axes" + (" and an attitude" if pose else " and orientations" if orientation else ""),
        "likely" if pose or orientation else "guess", "hang-calib", "hang", entries, (), wide,
        "leg", rate, (*world, *turned), (*axes_of_body, _WEIGHT), blanks=(*missing, *blanks),
        warnings=tuple(warnings),
    )  # fmt: skip


def _turned_along(file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]) -> Blank | None:
    """Transducers on the legs' side of their shafts, whose attitude is not the body's."""
    found = turned_along(file, six)
    return found and Blank(
        ("# body_… in [columns]: the attitude of each row, turned by the leg's angle",
         "# gravity_x, gravity_y, gravity_z in [files.wide…] where each leg has angles of its own"),
        f"the forces of {found[0]} turn with {found[1]}: it turns with its leg, so that each row "
        "has an attitude of its own; write it into the log (roll, pitch, yaw of the transducer)",
    )  # fmt: skip


def _dead_axis(six: Mapping[str, Mapping[str, ColumnGuess]]) -> Blank | None:
    """A force that hardly moves while its siblings carry a weight that is turned; None without."""
    for group in six.values():
        moved = np.nanstd(forces_of(dict(group)), axis=0)
        least = int(np.argmin(moved))
        if moved[least] < _STILL * moved.max():
            name = group[("fx", "fy", "fz")[least]].column
            return Blank(
                (f"# in [columns]: {name}, once it is connected and refreshed",),
                f"{name} hardly moves while the other forces turn with the weight: it looks dead",
            )
    return None


def _still(six: Mapping[str, Mapping[str, ColumnGuess]]) -> list[str]:
    """Wrenches that hardly move beside one that does: the tool's weight was taken out of them."""
    moved = {name: float(np.nanstd(forces_of(dict(group)), axis=0).max())
             for name, group in six.items()}  # fmt: skip
    most = max(moved.values())
    return [name for name, one in moved.items() if one < _STILL * most]


def _own_attitudes(
    file: FileGuess, six: Mapping[str, dict[str, ColumnGuess]]
) -> dict[str, Attitude]:
    """The attitude of each of several transducers by its own columns; empty unless all have one."""
    found = {}
    for name, group in six.items():
        side, place = group["fx"].name.side, group["fx"].name.place
        columns = tuple(c for c in file.columns if (c.name.side, c.name.place) == (side, place))
        pose = attitude_of(replace(file, columns=columns), forces_of(group))
        if pose is None or not pose.explains:
            return {}
        found[name] = pose
    apart = {tuple(e.column.column for e in p.entries.values() if e.column) for p in found.values()}
    return found if len(apart) == len(found) else {}


def _each_by_itself(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], own: Mapping[str, Attitude],
    time: Mapping[str, Entry], rate: float | None, blanks: tuple[Blank, ...],
) -> LogPlan:  # fmt: skip
    """Several transducers that hang free, each with an attitude of its own: two arms."""
    said = said_above(file)
    wide = {
        name: {**axes_of(group, said, -1.0 if own[name].reacts else 1.0), **own[name].entries}
        for name, group in six.items()
    }
    warnings = tuple(dict.fromkeys(w for pose in own.values() for w in pose.warnings))
    return LogPlan(
        file, f"{len(six)} six-axis transducers, each with its own attitude",
        "six axes and an attitude of each", "likely", "hang-calib", "hang", dict(time), (), wide,
        "leg", rate, blanks=blanks, warnings=warnings,
    )  # fmt: skip


def _stand(six: Mapping[str, dict[str, ColumnGuess]]) -> bool:
    """Whether several transducers carry one weight together: plates, or feet that stand.

    Their vertical forces have one sign, and add up to what changes less than they do by themselves;
    or each is at a foot by its name.
    """
    if len(six) < 2:
        return False
    vertical = np.column_stack([numbers_of(group["fz"]) for group in six.values()])
    return share_a_weight(vertical, named=_at_feet(six))


def _at_feet(six: Mapping[str, dict[str, ColumnGuess]]) -> bool:
    """Whether all transducers are at feet by their names."""
    return all(AT_THE_FOOT.search(group["fz"].column) for group in six.values())


def share_a_weight(vertical: FloatArray, *, named: bool = False) -> bool:
    """Whether vertical forces (n, k) are of one sign and add up to what hardly changes.

    `named`: they are at feet by their names, and may stand still.
    """
    means = np.nanmean(vertical, axis=0)
    if not (np.all(means > 0) or np.all(means < 0)):
        return False
    together, alone = np.nanstd(vertical.sum(axis=1)), np.nanstd(vertical, axis=0).max()
    loaded = np.abs(means).sum() > _LOADED * np.nanstd(vertical.sum(axis=1))
    return bool(loaded and (named or together < _TOGETHER * alone))


def _forces(
    six: Mapping[str, dict[str, ColumnGuess]], labels: Sequence[ColumnGuess]
) -> dict[str, FloatArray]:
    """Forces of each transducer by name, shape (n, 3); NaN in the rows of others."""
    if not labels or labels[0].codes is None or len(six) > 1:
        return {name: forces_of(group) for name, group in six.items()}
    whole, codes = forces_of(next(iter(six.values()))), labels[0].codes
    return {
        word: np.where((codes == i)[:, None], whole, np.nan)
        for i, word in enumerate(labels[0].words)
    }


UNPLACED = "# position_m = [0.0, 0.0, 0.0]    # the transducer in the body frame: pose-calib's"


def leg_tables(names: Iterable[str], mounts: Mounts | None) -> tuple[str, ...]:
    """``[robot.legs…]``: where the transducers sit, and how they are turned if forces say so."""
    tables = []
    for name in names:
        lines = [
            f"[robot.legs.{toml_key(name)}]",
            UNPLACED,
        ]
        if mounts is not None and name in mounts.rotation:
            angles = ", ".join(f"{angle:g}" for angle in mounts.rpy_rad(name))
            why = "likely: so the forces are the leg's weight; the drawing knows better"
            lines.append(f"rotation_rpy_rad = [{angles}]    # {why}")
            if axis := mounts.turns_about.get(name):
                lines.append(f'turns_about = "{axis}"    # likely: it turns with its leg')
        else:
            lines.append("# rotation_rpy_rad = [0.0, 0.0, 0.0]    # from its frame to the body's")
        tables.append("\n".join(lines))
    return tuple(tables)


def _poses(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], labels: Sequence[ColumnGuess],
    mounts: Mounts,
) -> LogPlan | None:  # fmt: skip
    """Transducers at the hips of a robot that stands in many poses: by name, or in time.

    A row for each leg and pose has its name; in a stream the still stretches are the poses. None
    where neither names nor stamps are there.
    """
    named = pose_numbers(file, labels) or file.of("placement", "sequence", "repeat")
    time, rate, open_yet = times(file, needed=bool(rate_said(file)))
    whole = bool(named) and (_once_each(named[0], file, six, labels) or _held_in(named[0], six))
    streamed = bool(time or rate) and not whole
    if not (named or streamed):
        return None
    entries = {**(time if streamed else {"pose": of(named[0])}), **mounts.attitude.entries}
    contact = file.of("contact")
    wide: dict[str, dict[str, Entry]] = {}
    said = said_above(file)
    if len(six) > 1:
        wide = {name: axes_of(group, said) for name, group in six.items()}
        for name, column in beside(file, six, "contact").items():
            wide[name]["contact"] = of(column)
    else:
        entries |= {"leg": of(labels[0]), **axes_of(next(iter(six.values())), said)}
        if contact:
            entries["contact"] = of(contact[0])
    entries |= _with_shafts(file, six, wide)
    if "phase_rad" not in entries and not any("phase_rad" in own for own in wide.values()):
        why = "no shaft angle: each leg is taken to keep its posture"
        entries["phase_rad"] = Entry(value="0", sure="guess", why=why)
    legs = list(six) if wide else list(labels[0].words)
    return LogPlan(
        file, f"six-axis transducers at {len(legs)} hips while the robot stands in poses",
        "six axes of several legs, an attitude, and loads that are no leg's weight", "likely",
        "pose-calib", "still" if streamed else "poses", entries, (), wide, "leg",
        rate if streamed else None, leg_tables(legs, None), (_CHASSIS,),
        blanks=(
            MASS,
            Blank(("# position_m of each leg above, in m",), WHERE_LEGS),
            HUNG_FIRST, *(open_yet if streamed else ()),
        ),
        warnings=unit_asked(six.values(), said),
    )  # fmt: skip


def _once_each(
    pose: ColumnGuess, file: FileGuess, six: Mapping[str, object], labels: Sequence[ColumnGuess]
) -> bool:
    """Whether each pose has a row for each leg, no more; a number that counts rows names none.

    Rows of a stream follow each other within a second.
    """
    rows = file.rows / (len(labels[0].words) if len(six) == 1 and labels else 1)
    different = len(pose.words) or np.unique(numbers_of(pose)).size
    often = (file.rate_hz or 0.0) > 1.0 and bool(file.of("time"))
    return bool(different > _ROWS_OF_A_POSE * rows) and not (often and pose.quantity == "sequence")


def _held_in(pose: ColumnGuess, six: Mapping[str, dict[str, ColumnGuess]]) -> bool:
    """Whether each number or name of a pose is one stretch of a stream, in which forces hold still.

    Where the way from pose to pose is in a stretch, forces move there.
    """
    called = numbers_of(pose) if pose.codes is None else pose.codes.astype(float)
    starts = np.flatnonzero(np.diff(called, prepend=np.nan) != 0)
    if not np.isfinite(called).all() or not 2 < starts.size == np.unique(called).size:
        return False
    force = np.column_stack([forces_of(group) for group in six.values()])
    within = [np.nanvar(own, axis=0).sum() for own in np.split(force, starts[1:]) if len(own)]
    return bool(max(within) < _HELD * np.nanvar(force, axis=0).sum())


def _without(file: FileGuess, entries: Mapping[str, Entry]) -> FileGuess:
    """The log without the columns that are taken for something."""
    taken = {entry.column.column for entry in entries.values() if entry.column}
    return replace(file, columns=tuple(c for c in file.columns if c.column not in taken))


def _with_shafts(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], wide: dict[str, dict[str, Entry]]
) -> dict[str, Entry]:
    """The shaft angle of every row; those of each leg are put into `wide`."""
    one, each = shafts(file, six)
    for name, entry in each.items():
        if name in wide:
            wide[name]["phase_rad"] = entry
    return {} if one is None else {"phase_rad": one}


def forces_of(group: dict[str, ColumnGuess]) -> FloatArray:
    """Forces of a transducer, shape (n, 3)."""
    return np.column_stack([numbers_of(group[axis]) for axis in ("fx", "fy", "fz")])


def _named_rows(column: ColumnGuess, six: dict[str, ColumnGuess] | None) -> Attitude | None:
    """Orientations that a column of texts names, as the forces say they were meant."""
    if six is None or column.codes is None:
        return None
    force = forces_of(six)
    there = [i for i in range(len(column.words)) if np.any(column.codes == i)]
    means = np.array([np.nanmean(force[column.codes == i], axis=0) for i in there])
    return named_orientation([column.words[i] for i in there], of(column), means)


def _counted(six: dict[str, dict[str, ColumnGuess]]) -> bool:
    """Whether all axes are whole numbers of a size that newtons do not have."""
    axes = [c for group in six.values() for c in group.values()]
    return all(c.counts and c.unit is None and c.name.factor == 1.0 for c in axes) and any(
        c.values is not None and float(np.nanmax(np.abs(c.values))) > _MOST_N for c in axes
    )
