"""Whether the stamps of a log can be seconds, by what the file and the recipe say of their unit.

Part of the room `session`, beside `footcal_cli.session.inspection`, which asks it of every log.
"""

from __future__ import annotations

from footcal_cli.core.body_stream import SLOWEST_S, check_stamp_unit
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.tables.table import Table

_BY_HAND_S = 3600.0
"""Longest usual interval of rows read by hand whose unit of time is stated."""
_NO_UNIT = ("date", "duration", "nanosecond")
"""What stamps were read as that need no unit."""


def stamp_unit(
    table: Table, time_s: FloatArray, where: str, slowest_s: float = SLOWEST_S,
    *, by_hand: bool = False,
) -> list[Finding]:  # fmt: skip
    """Find stamps that cannot be seconds: bare numbers can be anything, a date is what it says.

    Parameters
    ----------
    time_s
        Stamps of the table, or some of them, shape (n,).
    slowest_s
        Longest usual interval of such a recording.
    by_hand
        Whether rows may be read by hand, minutes apart, where their unit is stated.
    """
    read = next((column for column in table.read_as if column.name == "time_s"), None)
    unit = read.unit if read is not None else ""
    if unit.startswith(_NO_UNIT):
        return []
    longest = _BY_HAND_S if by_hand and unit else slowest_s
    return check_stamp_unit(time_s, where, slowest_s=longest)
