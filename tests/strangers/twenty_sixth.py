"""Logs that could be read wrongly: sheets with fits of their own, compensated wrenches, signs.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    Tool,
    cell,
    rows,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)

_KG = (0, 0.5, 1, 2, 5)
_FT = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
_ANGLES = ["roll_deg", "pitch_deg", "yaw_deg"]


def trailing_minus(to: Path, rng: Rng) -> Made:
    """An old indicator that writes its minus behind the number."""
    one, load = Cell(-0.02, 5.0, 3.0), steps((0, 50, 100, 200, 100, 0), 4)
    read = one.read(load, rng)
    lines = ["Load (N);Indicator", *(f"{f:g};{abs(c):.0f}{'-' if c < 0 else ''}"
                                    for f, c in zip(load, read, strict=True))]  # fmt: skip
    return Made([write(to / "indicator.csv", lines)], truth_of(one, 200))


def unicode_minus(to: Path, rng: Rng) -> Made:
    """Numbers copied from a document, with the sign of mathematics for minus."""
    one, load = Cell(-0.02, 5.0, 3.0), steps((0, 50, 100, 200, 100, 0), 4)
    lines = ["Load (N),Reading", *rows(load, one.read(load, rng))]
    return Made([write(to / "copied.csv", [x.replace("-", "\N{MINUS SIGN}") for x in lines])],
                truth_of(one, 200))  # fmt: skip


def fit_beside_the_table(to: Path, rng: Rng) -> Made:
    """A sheet with slope and intercept in cells beside the first rows."""
    one, kg = cell(rng), steps(_KG, 3)
    body = rows(kg, one.read(kg * G, rng))
    notes = ["slope,-2.9E+05", "intercept,8.25E+06", "R2,0.99998"]
    lines = ["Load [kg],Reading,,", *(f"{x},{notes[i] if i < 3 else ','}" for i, x in
                                      enumerate(body))]  # fmt: skip
    return Made([write(to / "fit.csv", lines)], truth_of(one, 50))


def predicted_and_error(to: Path, rng: Rng) -> Made:
    """A sheet that holds what its author's own fit predicted, and the error."""
    one, kg = cell(rng), steps((*_KG, *_KG[::-1]), 2)
    read = one.read(kg * G, rng)
    slope, zero = np.polyfit(read, kg, 1)
    guess = slope * read + zero
    lines = ["Applied (kg),ADC,Predicted (kg),Error (g)",
             *rows(kg, read, guess, 1e3 * (guess - kg), form="%.7g")]  # fmt: skip
    return Made([write(to / "own_fit.csv", lines)], truth_of(one, 50))


def up_down_and_mean(to: Path, rng: Rng) -> Made:
    """One cell, loaded and unloaded: two columns of readings and their mean."""
    one = cell(rng)
    lines = ["Load (N),Loading,Unloading,Average"]
    for f in (0, 10, 20, 50, 100):
        up, down = one.read(np.full(2, float(f)), rng)
        lines.append(f"{f},{up:.0f},{down:.0f},{(up + down) / 2:.1f}")
    return Made([write(to / "cycle.csv", lines)], truth_of(one, 100))


def gauge_against_pounds(to: Path, rng: Rng) -> Made:
    """A force gauge that shows newtons under weights in pounds."""
    one, lb = Cell(1.06, -2.0, 0.02), steps((0, 1, 2, 5, 10), 4)
    read = one.read(lb * 0.45359237 * G, rng, whole=False)
    lines = ["Weight hung (lbs),Gauge (N)", *rows(lb, read, form="%.3f")]
    return Made([write(to / "gauge.csv", lines)], truth_of(one, 50))


def coloured_console(to: Path, rng: Rng) -> Made:
    """ESP-IDF's console with its colours, the load set by a command."""
    one, lines, ms = cell(rng), [], 300
    for kg in _KG:
        lines.append(f"\x1b[0;33mW ({ms}) bench: load set to {kg:g} kg\x1b[0m")
        for c in one.read(np.full(12, kg * G), rng):
            ms += 100
            lines.append(f"\x1b[0;32mI ({ms}) hx711: raw={c:.0f}\x1b[0m")
    return Made([write(to / "idf.log", lines)], truth_of(one, 50))


def mass_in_each_head(to: Path, rng: Rng) -> Made:
    """A file for each weight, numbered; the mass stands in a remark above the rows."""
    one, paths = cell(rng), []
    for i, kg in enumerate(_KG):
        lines = ["# HX711 capture", f"# mass: {1e3 * kg:g} g", "t,raw",
                 *rows(np.arange(30) / 10, one.read(np.full(30, kg * G), rng))]  # fmt: skip
        paths.append(write(to / f"capture_{i:03d}.csv", lines))
    return Made(paths, truth_of(one, 50))


def weights_with_tolerance(to: Path, rng: Rng) -> Made:
    """Loads as they stand in a certificate: `500 g ± 0.1 g`."""
    one, lines = cell(rng), ["weight;counts"]
    for g in (0, 500, 1000, 2000, 5000):
        lines += [f"{g} g ± 0.1 g;{c:.0f}" for c in one.read(np.full(3, g * 1e-3 * G), rng)]
    return Made([write(to / "certified.csv", lines)], truth_of(one, 50))


def compensated_wrench(to: Path, rng: Rng) -> Made:
    """A driver that takes the tool's weight and the offsets off: nothing is left of either."""
    _, wrench, rot = wrist(rng)
    noise = rng.normal(0, 1, wrench.shape) * np.repeat([0.05, 0.003], 3)
    lines = [",".join([*_FT, *_ANGLES]),
             *rows(*noise.T, *rot.as_euler("xyz", degrees=True).T, form="%.5f")]  # fmt: skip
    nothing = tool_truth(Tool(0.0, np.zeros(3), np.zeros(6)))
    return Made([write(to / "compensated.csv", lines)], nothing)


def wrench_in_the_base(to: Path, rng: Rng) -> Made:
    """Forces and torques turned into the frame of the arm's base, offsets and all."""
    _, wrench, rot = wrist(rng)
    turned = np.hstack([rot.apply(wrench[:, :3]), rot.apply(wrench[:, 3:])])
    lines = [",".join([*_FT, *_ANGLES]),
             *rows(*turned.T, *rot.as_euler("xyz", degrees=True).T, form="%.5f")]  # fmt: skip
    return Made([write(to / "base.csv", lines)], says="hang-calib")


def zeroed_half_way(to: Path, rng: Rng) -> Made:
    """Somebody pressed zero at the seventh hold of fourteen; offsets are not those of before."""
    _, wrench, rot = wrist(rng, 14, 25)
    wrench[175:] -= wrench[175]
    lines = [",".join(["t", *_FT, *_ANGLES]),
             *rows(np.arange(350) / 25, *wrench.T, *rot.as_euler("xyz", degrees=True).T,
                   form="%.5f")]  # fmt: skip
    return Made([write(to / "zeroed.csv", lines)], says="hang-calib")


def quaternion_in_counts(to: Path, rng: Rng) -> Made:
    """An inertial unit's quaternion in counts, 16384 of which are one."""
    made, wrench, rot = wrist(rng)
    quat = np.round(16384 * rot.as_quat()[:, [3, 0, 1, 2]])
    lines = [",".join(["t", *_FT, "qw", "qx", "qy", "qz"]),
             *rows(np.arange(300) / 50, *wrench.T, *quat.T, form="%.7g")]  # fmt: skip
    return Made([write(to / "bno.csv", lines)], tool_truth(made))


def milliradians(to: Path, rng: Rng) -> Made:
    """Angles of an inclinometer in mrad."""
    made, wrench, rot = wrist(rng)
    turned = 1e3 * rot.as_euler("xyz")
    lines = [",".join(["t_s", *_FT, "roll [mrad]", "pitch [mrad]", "yaw [mrad]"]),
             *rows(np.arange(300) / 50, *wrench.T, *turned.T, form="%.5f")]  # fmt: skip
    return Made([write(to / "tilt.csv", lines)], tool_truth(made))


TWENTY_SIXTH = (
    trailing_minus, unicode_minus, fit_beside_the_table, predicted_and_error, up_down_and_mean,
    gauge_against_pounds, coloured_console, mass_in_each_head, weights_with_tolerance,
    compensated_wrench, wrench_in_the_base, zeroed_half_way, quaternion_in_counts, milliradians,
)  # fmt: skip
