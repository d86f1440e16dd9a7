"""Shapes of legged robots and benches that a stranger's tools wrote, by kind of mistake.

Names of feet in other words and cases beside a body's stream, days of one cell that was noted by
hand, degrees Fahrenheit, seconds without another name.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, Made, Rng, Truth, cell, rows, truth_of, write

LADDER_KG = np.array([0, 0.5, 1, 2, 3, 5, 3, 2, 1, 0.5, 0] * 3)


def scale_of(one: Cell, name: str = "") -> Truth:
    """Truth of a scale alone, to 0.3 %: the zero is each day's own."""
    return Truth({f"{name}.scale": one.scale}, {f"{name}.scale": 0.003 * abs(one.scale)})


def two_days_of_one_cell(to: Path, rng: Rng) -> Made:
    """66 rows, each a weight; on the second day stamps begin again and the zero is 0.5 N off."""
    one = cell(rng, "hx_small")
    kg = np.tile(LADDER_KG, 2)
    day = np.repeat([1, 2], LADDER_KG.size)
    read = one.read(9.80665 * kg + 0.5 * (day == 2), rng)
    at = np.tile(15.0 * np.arange(LADDER_KG.size), 2)
    body = [f"Tag {d};{t:.0f};{1000 * m:.0f};{r:.0f}" for d, t, m, r in
            zip(day, at, kg, read, strict=True)]  # fmt: skip
    return Made([write(to / "waage.csv", ["Tag;Sekunden;Masse [g];Rohwert", *body])], scale_of(one))


def degrees_fahrenheit(to: Path, rng: Rng) -> Made:
    """A zero that goes with the temperature, noted in °F under T_F; the clock is called sec."""
    one = cell(rng, "hx_small")
    kg = np.tile(LADDER_KG, 3)
    sec = 20.0 * np.arange(kg.size)
    warm = 20 + 9 * np.sin(sec / 700)
    read = one.read(9.80665 * kg + 1.0 * (warm - 20), rng)
    body = rows(sec, 32 + 1.8 * warm, kg, read, form="%.8g")
    return Made([write(to / "warm.csv", ["sec,T_F,load_kgf,reading", *body])], scale_of(one))


def _robot(to: Path, rng: Rng, cells: Sequence[str], feet: Sequence[str], ours: Sequence[str],
           weighed: str) -> Made:  # fmt: skip
    """Weights on each cell, a short walk and the body's stream, in a file each."""
    made = {name: cell(rng) for name in ours}
    newton = np.tile([0.0, 5, 10, 20, 10, 5, 0], 2)
    lines = [
        f"{theirs}{weighed},{n:g},{r:.0f}" for theirs, one in zip(cells, made.values(), strict=True)
        for n, r in zip(newton, one.read(newton, rng), strict=True)
    ]  # fmt: skip
    first = write(to / "weights.csv", ["sensor,load_n,adc", *lines])
    at = np.arange(120) / 50
    walked = [one.read(10 + 8 * np.sin(3 * at + i), rng) for i, one in enumerate(made.values())]
    names = ",".join(["time_s", *(f"{c}_counts" for c in cells)])
    second = write(to / "walk.csv", [names, *rows(at, *walked, form="%.9g")])
    places = [f"{foot}{axis} [mm]" for foot in feet for axis in "xyz"]
    motion = rng.normal(0, 20, (3 + len(places), 120)) + np.r_[0, 0, 400, np.zeros(len(places))][
        :, None
    ]  # fmt: skip
    names = ",".join(["time_s", "CoM.x [mm]", "CoM.y [mm]", "CoM.z [mm]", *places])
    third = write(to / "body.csv", [names, *rows(at, *motion, form="%.6g")])
    return Made([first, second, third], truth_of(made))


def german_feet(to: Path, rng: Rng) -> Made:
    """Cells of ``links`` and ``rechts``, whose feet are ``L.x`` and ``R.x``."""
    theirs = [f"{side}_{i}" for side in ("links", "rechts") for i in (1, 2, 3)]
    ours = [f"{side}_{i}" for side in ("left", "right") for i in (1, 2, 3)]
    return _robot(to, rng, theirs, ("L.", "R."), ours, "")


def quadruped_in_capitals(to: Path, rng: Rng) -> Made:
    """One cell in each foot of a quadruped whose hind legs are called rear."""
    legs = ("FL", "FR", "RL", "RR")
    ours = [f"{leg.lower()}_foot" for leg in legs]
    return _robot(to, rng, legs, [f"{leg}_foot_" for leg in legs], ours, "")


TWENTY_FIRST = (two_days_of_one_cell, degrees_fahrenheit, german_feet, quadruped_in_capitals)
