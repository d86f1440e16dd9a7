"""Orientations in words, of a body that carries several transducers: which axis points down.

Room: sniff; called by six_axis. A word names an axis that points up or down, ``x_up``, ``kopf
oben``; what says neither, ``+x``, names the axis along gravity unless the forces say otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import Attitude
from footcal_cli.sniff.file_loads import whole_name
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.mounts import Mounts, hung_on
from footcal_cli.sniff.plan import Blank, Entry, LogPlan, of
from footcal_cli.sniff.sides import opposite, pulls, says_up, sides_in
from footcal_cli.sniff.tokens import SIDES

OF_THE_BODY = 'orientation_of = "body"    # its axes; transducers by rotation_rpy_rad of each leg'
"""The line in ``[hang_calib]``."""
_REACT = (
    "the transducers read the opposite of what pulls on them, or are turned half round about the "
    "axis that all orientations leave level: their six axes were turned round"
)
_TURNED = "each name was turned round: it says which axis points up, so the legs have weight"
_NOT_ONE_WEIGHT = Blank(
    ("# body_qx … body_qw, or gravity_x gravity_y gravity_z, of every row, in the transducer's",
     "# own axes if it turns with the leg"),
    "in the orientations named the forces are not one weight's: a transducer may turn with its leg",
)  # fmt: skip


_ONE_ORIENTATION = (
    "every row is in the one orientation {}: one alone does not separate weight from offset; give "
    "the logs of the others, too"
)
NO_ATTITUDE = Blank(
    ('# body_qx = "…"    # the attitude: body_qx … body_qw, or body_roll_rad …, or',
     "#                  # body_r11 … body_r33, or gravity_x gravity_y gravity_z"),
    "the log has no attitude, so nothing says which way gravity pulls",
)  # fmt: skip


def not_one_weight(named: Sequence[ColumnGuess], known: Blank | None) -> Blank | None:
    """What is asked where forces are not one weight's in the orientations that a column names.

    One orientation explains nothing; else `known` is what other signs say. None without a column.
    """
    if not named or len(named[0].words) > 1:
        return known or (_NOT_ONE_WEIGHT if named else None)
    return Blank(
        ("# in [data]: hang = […], a log of each orientation, and its name above",),
        _ONE_ORIENTATION.format(named[0].words[0]),
    )


def unnamed(column: ColumnGuess) -> Blank:
    """What is asked where words for orientations name no axis."""
    names = ", ".join(f'"{word}" = ""' for word in column.words[:6])
    return Blank(
        (f"# in [columns]: orientation = {{ column = \"{column.column}\", names = {{ {names} }} }}",
         "# each the axis along gravity: +x -x +y -y +z -z"),
        f"nothing says which axis points down in each {column.column}",
    )  # fmt: skip


def asked_by_file(plan: LogPlan, names: Sequence[str]) -> LogPlan:
    """A plan of one log for each attitude that asks which axis points down in each of them.

    Of logs that say no attitude, and whose names say none that is understood.
    """
    own = plan.entries.get("leg")
    if len(names) < SIDES or "orientation" in plan.entries or (own and own.file_name):
        return plan
    said = ", ".join(f'"{name}" = ""' for name in names)
    file_name = f"file_name = '{whole_name(names)}'"
    asked = Blank(
        (f"# in [columns]: orientation = {{ {file_name}, names = {{ {said} }} }}",
         "# each the axis along gravity: +x -x +y -y +z -z; or the attitude in a column"),
        f"no attitude in the logs, and nothing says which axis points down in {names[0]} …",
    )  # fmt: skip
    blanks = (asked if blank is NO_ATTITUDE else blank for blank in plan.blanks)
    return replace(plan, blanks=tuple(blanks))


@dataclass(frozen=True)
class Named:
    """What names of orientations say.

    Parameters
    ----------
    attitude
        Their entry; whether the transducers react, and whether a weight explains the forces.
    mounts
        Rotation of each transducer, where it is looked for.
    """

    attitude: Attitude
    mounts: Mounts


def axes_named(words: tuple[str, ...], called: str) -> tuple[dict[str, str], bool] | None:
    """Words -> the axis along gravity, and whether they or their column say what is up.

    None where a word names no axis.
    """
    sides = sides_in(words)
    up, names = says_up(called), {}
    for word, (axis, said) in sides.items():
        if axis is None:
            return None
        names[word] = opposite(axis) if up and not said else axis
    return names, up is not None or any(said for _, said in sides.values())


def of_a_body(
    column: ColumnGuess, forces: Mapping[str, FloatArray], entry: Entry | None = None
) -> Named | None:
    """Orientations that a column names; None where one of its words names no axis.

    Parameters
    ----------
    column
        Texts, one of few in each row.
    forces
        Of each transducer, shape (n, 3), NaN in the rows of others.
    entry
        Where the recipe finds them, the column where None.
    """
    found = axes_named(column.words, column.column)
    if found is None or column.codes is None:
        return None
    names, said = found
    table = np.array([*map(pulls, names.values()), np.full(3, np.nan)])
    hung = hung_on(table[column.codes], forces)
    reacts, warnings = hung.reacts, list[str]()
    if not hung.explained:
        reacts = False
    elif reacts and not said:
        names, reacts = {word: opposite(axis) for word, axis in names.items()}, False
        warnings.append(_TURNED)
    elif reacts:
        warnings.append(_REACT)
    where = replace(entry or of(column), names=names)
    attitude = Attitude({"orientation": where}, tuple(warnings), reacts, hung.explained)
    return Named(attitude, Mounts(attitude, hung.rotation if hung.explained else {}, True))
