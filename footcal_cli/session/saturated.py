"""Readings at the end of a sensor's range, left out of what a calibration is fitted to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.saturation import find_saturated
from footcal_cli.recipe import Robot
from footcal_cli.tables.columns import AXIS_COLUMNS
from footcal_cli.tables.table import Table

FITS = frozenset({"online-replay", "static-init", "hang-calib", "pose-calib", "offline-fit"})
"""Commands that leave such readings out; the others show them."""
_MOTION = tuple(f"{kind}_acc_{axis}_mps2" for kind in ("com", "imu") for axis in "xyz")


def without_saturated(table: Table, robot: Robot) -> tuple[Table, list[Finding]]:
    """A log without saturated readings (NaN), and how many there were of each column.

    A row of a body stream in which any acceleration is cut has no acceleration of the CoM: that is
    made from the same sensor. Of single weights `footcal_cli.intake.bench` decides.
    """
    names = [n for n in table.data.columns if _is_reading(n)]
    if not names or "channel" in table:
        return table, []
    values = table.numbers(names)
    lost = robot.adc.lost_reading
    heard = values if lost is None else np.where(values == lost, np.nan, values)
    groups = _groups(table)
    cut = np.zeros(values.shape, dtype=bool)
    for rows in groups:
        for i, name in enumerate(names):
            cut[rows, i] = find_saturated(
                name, heard[rows, i], robot.adc.bits, in_time="time_s" in table
            )
    if not cut.any():
        return table, []
    findings = [
        _left_out(name, values[rows, i], cut[rows, i])
        for rows in groups
        for i, name in enumerate(names)
        if cut[rows, i].any()
    ]
    of_motion = np.array([n in _MOTION for n in names])
    cut[:, of_motion] |= cut[:, of_motion].any(axis=1, keepdims=True)
    if "placement" in table or any(
        n.endswith("_load_n") or _is_known(n) for n in table.data.columns
    ):
        # each row is a reading of its own
        whole = table.data.take(np.flatnonzero(~cut.any(axis=1))).reset_index(drop=True)
        return replace(table, data=whole), findings
    clean = {n: np.where(cut[:, i], np.nan, values[:, i]) for i, n in enumerate(names)}
    changed = {n: clean[n] for i, n in enumerate(names) if cut[:, i].any()}
    return replace(table, data=table.data.assign(**changed)), findings


def _is_reading(name: str) -> bool:
    of_axis = name in AXIS_COLUMNS or name.split("_", 1)[-1] in AXIS_COLUMNS
    return name.endswith("counts") or name in _MOTION or (of_axis and not _is_known(name))


def _is_known(name: str) -> bool:
    return name.startswith("known_")


def _groups(table: Table) -> list[BoolArray]:
    """Rows of one sensor each: those of a leg in a table of several."""
    if "leg" not in table:
        return [np.ones(len(table), dtype=bool)]
    leg = table.text("leg")
    return [np.asarray(leg == one) for one in dict.fromkeys(leg)]


def _left_out(name: str, values: FloatArray, cut: BoolArray) -> Finding:
    ends = ", ".join(f"{x:.6g}" for x in np.unique(values[cut]))
    return Finding(
        "saturated_left_out", "warning", name,
        f"{int(cut.sum())} of {cut.size} samples stand at the end of the sensor's range ({ends}) "
        "and are left out",
        "set a larger range, lower the gain or the load",
    )  # fmt: skip
