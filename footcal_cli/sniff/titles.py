"""What of a column's name says what it is: without what all names share, with what the file says.

Room: sniff; asked by columns.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from footcal_cli.sniff.names import NameGuess, name_guess
from footcal_cli.sniff.vocabulary import WITH_A_LEG
from footcal_cli.tables.reading import Pivot

_LEAST_NAMES = 2
_BARE_AXES = {"x", "y", "z", "w"}
_OF_A_BODY = re.compile(
    r"(?P<stem>.*[\W_])(?P<axis>ML|AP|V|VT|vert|vertical)(?P<unit>\s*[(\[].*[)\]])?", re.IGNORECASE
)
_AXES = {"A": "x", "M": "y", "V": "z"}
_SIDE = re.compile(rf"(?<![^\W_])(?:{'|'.join(WITH_A_LEG)})(?![^\W_])", re.IGNORECASE)
_OF_A_FILE = ("acceleration", "gravity", "quaternion")


def said_by_names(
    names: Sequence[str], stem: str, pivot: Pivot | None, empty: Collection[str] = ()
) -> list[str]:
    """What each column's name says.

    A title that all names begin with (``Run 1: Force (N)``) is left out, and bare axes are of what
    the file is called after (``x`` in ``Gravity.csv``). Of ``<label>.<column>`` in a turned table
    it is the label, where that says what the value is, and the column, where that is no value.

    Parameters
    ----------
    names
        Of the columns.
    stem
        The file's name without its suffix.
    pivot
        How the table was turned, None where it was not.
    empty
        Names of columns without a value: of messages, the groups that stand before their axes.
    """
    titles = {name.partition(":")[0] for name in names}
    titled = len(names) >= _LEAST_NAMES and len(titles) == 1 and all(": " in n for n in names)
    said = [name.partition(":")[2].strip() or name for name in names] if titled else list(names)
    said = _of_two_feet([_of_its_file(name, stem) for name in _in_groups(said, empty)])
    said = _anatomical(said)
    if pivot is None:
        return said
    alone = len({pivot.parts_of(name)[1] for name in said if pivot.parts_of(name)[0]}) == 1
    return [_labelled(name, pivot, alone=alone) for name in said]


def _in_groups(names: Sequence[str], empty: Collection[str]) -> list[str]:
    """Bare axes behind the group that they are of: ``force,x,y,z,torque,x.1`` of a flat message."""
    group, said = "", []
    for name in names:
        axis = re.sub(r"\.\d+$", "", name.strip().lower())
        bare = axis in _BARE_AXES
        if not bare:
            group = name if name in empty else ""
        within = f"{group} {axis}"
        said.append(within if bare and group and name_guess(within).axis else name)
    return said


def _of_two_feet(names: Sequence[str]) -> list[str]:
    """Names with left and right for ``sol`` and ``sağ``, ``sx`` and ``dx``, where both are of feet.

    Each alone may be the ground or a change of x: under both words the same names stand, several.
    """
    found = [_SIDE.search(name) for name in names]
    rests: dict[str, list[str]] = {"left": [], "right": []}
    for one in found:
        if one:
            rest = one.string[: one.start()], one.string[one.end() :]
            rests[WITH_A_LEG[one[0].lower()]].append("|".join(rest))
    left, right = map(sorted, rests.values())
    if left != right or len(left) < _LEAST_NAMES:
        return list(names)
    return [
        f"{name[: one.start()]}{WITH_A_LEG[one[0].lower()]}{name[one.end() :]}" if one else name
        for name, one in zip(names, found, strict=True)
    ]


def _of_its_file(name: str, stem: str) -> str:
    """A bare axis with its file's name before it, if that is one of a quantity with axes."""
    if name.strip().lower() not in _BARE_AXES:
        return name
    guess = name_guess(f"{stem} {name.strip().lower()}")
    return f"{stem} {name.strip().lower()}" if guess.quantity in _OF_A_FILE and guess.axis else name


def _anatomical(names: Sequence[str]) -> list[str]:
    """Forces along the axes of a body, as axes: ``GRF_ML``, ``GRF_AP``, ``GRF_V`` are y, x and z.

    They are recognised by standing side by side: alone ``ML`` is a place, and ``V`` a volt.
    """
    found = [_OF_A_BODY.fullmatch(name.strip()) for name in names]
    by_stem: dict[str, set[str]] = {}
    for one in found:
        if one:
            by_stem.setdefault(one["stem"].lower(), set()).add(one["axis"].upper()[:1])
    whole = {stem for stem, axes in by_stem.items() if axes == {"M", "A", "V"}}
    return [
        f"{one['stem']}{_AXES[one['axis'].upper()[:1]]}{one['unit'] or ''}"
        if one and one["stem"].lower() in whole and name_guess(one["stem"]).quantity == "force"
        else name
        for name, one in zip(names, found, strict=True)
    ]


def _labelled(name: str, pivot: Pivot, *, alone: bool) -> str:
    """What a column of a turned table is called; one `alone` is the value, whatever its name."""
    label, column = pivot.parts_of(name)
    own = NameGuess("unknown") if alone else name_guess(column)
    if not label or own.quantity not in ("reading", "unknown", "other"):
        return name
    if own.quantity == "other":
        return column
    said = name_guess(label).quantity != "unknown"
    if own.quantity == "reading" and not said and name_guess(name).quantity == "unknown":
        return f"{label} reading"  # RAW alone would be taken for a unit
    return label if said and own.unit is None else name
