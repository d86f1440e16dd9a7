r"""Where feet stand that no column says, by the CoM above what they carry.

Room: sniff; asked by plates, six_axis_feet and robot_files.

A body at rest has its CoM above its centre of pressure. With the moment of each foot about its own
origin, :math:`m_k = f_k (x, y)_k`, and its place :math:`p_k`,

.. math:: W c - \sum_k m_k = \sum_k f_k p_k

is linear in the places, means over half a second of a stand being the rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.sniff.guesses import seconds_of
from footcal_cli.sniff.motion import walks
from footcal_cli.sniff.plan import Blank, Entry
from footcal_cli.sniff.units import GRAVITY_MPS2
from footcal_cli.tables.units import conversion

_MEAN_S = 0.5
_SHIFTS = 0.03
"""Change of a foot's share of the weight (sd) from which its place shows."""
_UNSURE_M, _UNSURE_SHARE = 0.005, 0.2
"""How far the CoM may lie off the centre of pressure: so much, or this share of how it moves."""
_SAME_M = 0.03
"""Places so near to one another are one: feet that report in the frame of the CoM."""
_CARRIES, _GAINS = 0.05, 0.2
WHERE_FEET_STAND = "no log says where the feet stand: m, in the frame of the CoM"


@dataclass(frozen=True)
class StillFeet:
    """The body's motion with the feet where they stand.

    Parameters
    ----------
    entries
        CoM, and a place for each foot, by canonical name.
    blanks
        What is to be filled in where the log does not show the places.
    """

    entries: Mapping[str, Entry]
    blanks: tuple[Blank, ...] = ()


def on_still_feet(
    body: Mapping[str, Entry], feet: Sequence[str], sensors: Mapping[str, Entry],
    at_rows: Mapping[str, Entry] | None = None,
) -> StillFeet:  # fmt: skip
    """The motion of a body that stands on feet without places of their own.

    Parameters
    ----------
    body
        Entries of the motion as logged.
    feet
        Names of the feet or plates.
    sensors
        Entries of what they carry.
    at_rows
        The motion at the rows of the sensors, where it is in a file of its own.
    """
    named = [f"{foot}_foot_{axis}_m" for foot in feet for axis in "xy"]
    if not feet or not {"com_x_m", "com_y_m", "com_z_m"} <= set(body) or walks(body):
        return StillFeet(body)
    logged = set(named) <= set(body)
    if logged and not all(f"{foot}_cop_x_m" in sensors for foot in feet):
        return StillFeet(body)
    places = _places(sensors, feet, body if at_rows is None else at_rows)
    if logged and (places is None or np.abs(places).max() >= _SAME_M):
        return StillFeet(body)
    if places is None:
        asked = (f"# {foot}_foot_{axis}_m = {{ value =  }}" for foot in feet for axis in "xyz")
        return StillFeet(body, (Blank(("# in [columns]:", *asked), WHERE_FEET_STAND),))
    why = "where the CoM lies above what the feet carry"
    if np.abs(places).max() < _SAME_M:
        places, why = np.zeros_like(places), "what it reports is in the frame of the CoM"
    entries = dict(body)
    for foot, place in zip(feet, places.tolist(), strict=True):
        for axis, value in zip("xyz", (*place, 0.0), strict=True):
            entries[f"{foot}_foot_{axis}_m"] = Entry(
                value=f"{value + 0.0:.3f}", sure="likely" if axis == "z" else "guess", why=why
            )
    return StillFeet(entries)


def _places(
    sensors: Mapping[str, Entry], feet: Sequence[str], body: Mapping[str, Entry]
) -> FloatArray | None:
    """Places (feet, 2) of feet that stand still; None where the log does not show them."""
    com = [_in(body.get(f"com_{axis}_m"), "m") for axis in "xy"]
    force = [_in(sensors.get(f"{foot}_fz_n"), "N") for foot in feet]
    moment = [_moment(sensors, foot) for foot in feet]
    time = sensors.get("time_s")
    stamps = None if time is None or time.column is None else seconds_of(time.column)
    if stamps is None:
        return None
    columns = [*com, *force, *(m for both in moment for m in both)]
    if any(c is None or c.shape != stamps.shape for c in columns):
        return None
    table = np.column_stack([c for c in columns if c is not None])
    rows = _means(stamps, table)
    load = rows[:, 2 : 2 + len(feet)]
    whole = load.sum(axis=1)
    least = _CARRIES * float(np.median(whole)) if whole.size else 0.0
    if whole.size < 8 * len(feet) or least <= 0.0 or whole.min() < least:
        return None
    if len(feet) > 1 and (load / whole[:, None]).std(axis=0).min() < _SHIFTS:
        return None
    moments = rows[:, 2 + len(feet) :].reshape(len(rows), len(feet), 2)
    # what the feet carry together does not change: one that reads too much shows as weight shifts
    gains = np.linalg.lstsq(load / np.median(whole), np.ones(len(load)), rcond=None)[0]
    if np.abs(gains - 1.0).max() < _GAINS:
        load, moments = load * gains, moments * gains[:, None]
    whole = load.sum(axis=1)
    share = load / whole[:, None]
    wanted = rows[:, :2] - moments.sum(axis=1) / whole[:, None]
    still = _still(rows[:, :2])
    places = np.linalg.lstsq(share[still], wanted[still], rcond=None)[0]
    off = np.sqrt(np.mean((wanted - share @ places)[still] ** 2, axis=0))
    if np.any(off > np.maximum(_UNSURE_M, _UNSURE_SHARE * rows[:, :2].std(axis=0))):
        return None
    return np.asarray(places)


def _still(com_m: FloatArray) -> BoolArray:
    """Half of the rows, those between which the CoM moves least, shape (b,)."""
    moved = np.linalg.norm(np.gradient(com_m, axis=0), axis=1)
    return np.asarray(moved <= np.median(moved))


def _moment(sensors: Mapping[str, Entry], foot: str) -> tuple[FloatArray | None, FloatArray | None]:
    """``f x`` and ``f y`` of a foot about its own origin, by its CoP or its moments."""
    force = _in(sensors.get(f"{foot}_fz_n"), "N")
    place = [_in(sensors.get(f"{foot}_cop_{axis}_m"), "m") for axis in "xy"]
    if force is not None and place[0] is not None and place[1] is not None:
        x, y = (np.where(np.isfinite(c), force * c, 0.0) for c in place if c is not None)
        return x, y
    about = [_in(sensors.get(f"{foot}_t{axis}_nm"), "N*m") for axis in "xy"]
    return (None if about[1] is None else -about[1]), about[0]


def _in(entry: Entry | None, unit: str) -> FloatArray | None:
    """A column in a unit, shape (n,)."""
    if entry is None or entry.column is None or entry.column.values is None:
        return None
    slope = conversion(entry.unit, unit, GRAVITY_MPS2).slope if entry.unit else 1.0
    return np.asarray(entry.column.values * slope * (entry.factor or 1.0))


def _means(stamps_s: FloatArray, table: FloatArray) -> FloatArray:
    """Means (b, k) over half a second each of the rows that are whole."""
    whole = np.isfinite(table).all(axis=1) & np.isfinite(stamps_s)
    if not whole.any():
        return table[:0]
    number = np.floor((stamps_s[whole] - stamps_s[whole].min()) / _MEAN_S).astype(np.int64)
    _, at, count = np.unique(number, return_inverse=True, return_counts=True)
    sums = np.zeros((count.size, table.shape[1]))
    np.add.at(sums, at, table[whole])
    return np.asarray(sums / count[:, None])
