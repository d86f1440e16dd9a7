"""The signature of an effect: a clean recording against the same one with the effect in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.contract import Effect, units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import AFTER, BEFORE, REFERENCE, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LARGER = 3.0
"""How many usual sizes are drawn, so that the eye sees them."""
UNITS = {
    "load_n": "N", "hole_m": "m", "com_m": "m", "com_acc_mps2": "m/s²", "angmom_rate_nm": "Nm",
    "mass_kg": "kg", "cell_pos_m": "m", "leg_weight_n": "N", "leg_com_m": "m", "gravity_dir": "-",
    "robot_weight_n": "N", "rot_wb": "-", "foot_yaw_rad": "rad",
}  # fmt: skip


@dataclass(frozen=True)
class Signature:
    """What an effect changes most in a recording.

    Parameters
    ----------
    quantity, unit
        What is drawn.
    time_s, clean, distorted
        Shape (n,).
    sizes
        The values it was drawn with, in words.
    """

    quantity: str
    unit: str
    time_s: FloatArray
    clean: FloatArray
    distorted: FloatArray
    sizes: str


def drawn_sizes(effect: Effect, shapes: dict[str, float]) -> dict[str, float]:
    """Three usual sizes of the first parameter (a whole fault whole), the given shapes."""
    size = effect.size
    whole = (size.lower, size.neutral, size.upper) == (0.0, 0.0, 1.0)
    large = 1.0 if whole else size.neutral + LARGER * size.prior_sd
    values = {size.name: float(np.clip(large, 0.9 * size.lower, 0.9 * size.upper + 0.1 * whole))}
    return values | {p.name: shapes.get(p.name, p.neutral) for p in effect.shapes}


def signature(effect: Effect, clean: Log, values: dict[str, float]) -> Signature:
    """Apply an effect and find the quantity that it changes most, relative to its range."""
    units = len(units_of(effect.scope, clean.channels))
    theta = {p.name: np.full(units, values.get(p.name, p.neutral)) for p in effect.parameters}
    distorted, _ = effect.apply(clean, theta, None)
    columns: list[tuple[float, str, str, FloatArray, FloatArray]] = []
    for i, channel in enumerate(clean.channels):
        unit = "Nm" if ".t" in channel else "N"
        columns.append(_column(channel, unit, clean.readings[:, i], distorted.readings[:, i]))
    for name, unit in UNITS.items():
        if name in clean.known:
            before = clean.known[name].reshape(len(clean), -1)
            after = distorted.known[name].reshape(len(clean), -1)
            for k in range(before.shape[1]):
                columns.append(_column(name, unit, before[:, k], after[:, k]))
    _, quantity, unit, before, after = max(columns, key=lambda column: column[0])
    said = ", ".join(
        f"{name} = {value:g} {next(p.unit for p in effect.parameters if p.name == name)}"
        for name, value in values.items()
    )
    return Signature(quantity, unit, clean.time_s, before, after, said.replace(" -", ""))


def _column(
    name: str, unit: str, before: FloatArray, after: FloatArray
) -> tuple[float, str, str, FloatArray, FloatArray]:
    change = float(np.sqrt(np.mean((after - before) ** 2)))
    spread = max(float(np.std(before)), 1e-3 * float(np.abs(before).max()))
    return change / (spread or 1.0), name, unit, before, after


def plot_signature(found: Signature) -> Figure:
    """Clean and distorted over time; their difference against the clean value."""
    figure = new_figure(2.3)
    left, right = figure.subplots(1, 2, width_ratios=[1.7, 1.0])
    dots = len(found.time_s) < 150
    style = {"marker": "o", "linestyle": "", "markersize": 3} if dots else {"linewidth": 1.1}
    left.plot(found.time_s, found.clean, color=BEFORE, label="clean", **style)
    left.plot(found.time_s, found.distorted, color=AFTER, label="distorted", **style)
    tidy(left, "", "time (s)", f"{found.quantity} ({found.unit})")
    left.legend(fontsize=8, frameon=False, loc="upper right")
    difference = found.distorted - found.clean
    right.axhline(0.0, color=REFERENCE, linewidth=0.7)
    right.plot(found.clean, difference, ".", color=AFTER, markersize=2.5)
    tidy(right, "", f"clean {found.quantity} ({found.unit})", "distorted − clean")
    return figure
