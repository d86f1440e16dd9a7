"""What stood on the bench of a stranger: cells and transducers with known truth, as numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Rng = np.random.Generator
Write = Callable[[Path, Rng], "Made"]
G = 9.80665


@dataclass(frozen=True)
class Truth:
    """Name of a parameter, or its end (``.scale``), -> value, and -> largest error."""

    values: Mapping[str, float] = field(default_factory=dict)
    within: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Made:
    """Files of a log and the truth they were made from.

    Parameters
    ----------
    paths
        In the order of the command line.
    truth
        What a calibration must find.
    says
        Words that the next step must contain, where the log cannot give a calibration by itself.
    fill
        What a person does to the recipe then; the command must find the truth after it.
    cop_within_m
        Largest error of a corrected CoP at points left out of the fit.
    """

    paths: Sequence[Path]
    truth: Truth = Truth()
    says: str = ""
    cop_within_m: float = 0.0
    fill: Callable[[str], str] | None = None


@dataclass(frozen=True)
class Cell:
    """A load cell: ``F = scale · S + bias``."""

    scale: float
    bias: float
    noise: float

    def read(self, load_n: Array, rng: Rng, whole: bool = True) -> Array:
        """Readings under loads."""
        values = (load_n - self.bias) / self.scale + rng.normal(0, self.noise, np.shape(load_n))
        return np.round(values) if whole else values


def cell(rng: Rng, kind: str = "hx711") -> Cell:
    """A cell behind a 24-bit converter, a 10-bit one, or an amplifier that gives volts."""
    scale, zero, noise = {
        "hx711": (-3.4e-5, 8.3e6, 40.0), "adc10": (0.11, 12.0, 0.4), "adc12": (0.02, 300.0, 1.0),
        "volt": (21.0, 0.35, 1e-3), "newton": (1.04, -1.3, 0.02),
        "hx_small": (4.6e-4, -8.2e4, 12.0),
    }[kind]  # fmt: skip
    scale *= float(rng.uniform(0.9, 1.1))
    zero *= float(rng.uniform(0.98, 1.02))
    return Cell(scale, -scale * zero, noise)


def truth_of(cells: Mapping[str, Cell] | Cell, span_n: float = 20.0) -> Truth:
    """Truth and tolerances: scale to 1 %, bias to 1 % of the span."""
    named = {"": cells} if isinstance(cells, Cell) else cells
    truth: dict[str, float] = {}
    within: dict[str, float] = {}
    for name, one in named.items():
        truth |= {f"{name}.scale": one.scale, f"{name}.bias": one.bias}
        slack = abs(0.01 * one.scale)
        # the bias is a lever of zero counts: its error beside the scale's own
        within |= {
            f"{name}.scale": slack,
            f"{name}.bias": 0.01 * span_n + slack * abs(one.bias / one.scale),
        }
    return Truth(truth, within)


def steps(loads: Sequence[float], hold: int) -> Array:
    """Loads one after the other, `hold` samples each."""
    return np.repeat(np.asarray(loads, dtype=float), hold)


def settling(loads_n: Sequence[float], hold_s: float, rate_hz: float, move_s: float = 0.8) -> Array:
    """A load that is put on and taken off with a hand: smooth between holds, shape (n,)."""
    parts = [np.full(round(hold_s * rate_hz), loads_n[0])]
    for before, after in pairwise(loads_n):
        x = np.linspace(0, 1, round(move_s * rate_hz))
        parts.append(before + (after - before) * (3 * x**2 - 2 * x**3))
        parts.append(np.full(round(hold_s * rate_hz), after))
    return np.concatenate(parts)


@dataclass(frozen=True)
class Tool:
    """What hangs on a six-axis transducer, and the transducer's offsets."""

    weight_n: float
    com_m: Array
    offset: Array

    def read(self, gravity: Array, rng: Rng) -> Array:
        """Wrenches [fx fy fz tx ty tz] under directions of gravity (n, 3)."""
        force = self.weight_n * gravity
        torque = np.cross(self.com_m[None, :], force)
        noise = rng.normal(0, 1, (len(gravity), 6)) * np.array([0.03] * 3 + [0.002] * 3)
        return np.asarray(np.hstack([force, torque]) + self.offset + noise)


def tool(rng: Rng) -> Tool:
    """A gripper of some newtons, a hand's breadth in front of the flange."""
    return Tool(
        float(rng.uniform(6, 14)),
        rng.uniform([-0.01, -0.01, 0.04], [0.01, 0.01, 0.09]),
        rng.normal(0, 1, 6) * np.array([5, 5, 5, 0.3, 0.3, 0.3]),
    )


def tool_truth(made: Tool, leg: str = "") -> Truth:
    """Truth and tolerances of a tool: offsets to 0.1 N and 0.01 Nm, weight to 0.1 N."""
    names = ("offset_fx", "offset_fy", "offset_fz", "offset_tx", "offset_ty", "offset_tz")
    truth = {f"{leg}.{n}": float(v) for n, v in zip(names, made.offset, strict=True)}
    truth[f"{leg}.weight"] = made.weight_n
    within = {n: 0.1 if n[-2] == "f" or n.endswith("weight") else 0.01 for n in truth}
    return Truth(truth, within)


def attitudes(rng: Rng, poses: int, hold: int) -> tuple[Array, Array]:
    """Random attitudes of a wrist held still: rotations body to world (n, 3, 3), rpy (n, 3)."""
    from scipy.spatial.transform import Rotation

    rpy = np.repeat(rng.uniform([-3.1, -1.4, -3.1], [3.1, 1.4, 3.1], (poses, 3)), hold, axis=0)
    return Rotation.from_euler("xyz", rpy).as_matrix(), rpy


def wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Rotation]:
    """A wrist that holds a tool: the tool, its wrenches in attitudes held one by one, these."""
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), Rotation.from_matrix(rot)


def filled(**values: str) -> Callable[[str], str]:
    """What fills in the lines ``# key = …`` of a recipe, the tables above them included."""

    def fill(recipe: str) -> str:
        lines = recipe.splitlines()
        for key, value in values.items():
            at = next(i for i, x in enumerate(lines) if re.match(rf"# {key} = ", x))
            lines[at] = f"{key} = {value}"
            above = at - 1
            while above > 0 and lines[above].startswith("# ") and "TO FILL IN" not in lines[above]:
                if lines[above].startswith("# ["):
                    lines[above] = lines[above].removeprefix("# ")
                    break
                above -= 1
        return "\n".join(lines) + "\n"

    return fill


def write(path: Path, lines: Sequence[str], encoding: str = "utf-8", end: str = "\n") -> Path:
    """A text file."""
    path.write_bytes((end.join(lines) + end).encode(encoding))
    return path


def rows(*columns: NDArray[Any], sep: str = ",", form: str = "%.10g") -> list[str]:
    """Lines of a table."""
    return [sep.join(form % v for v in row) for row in zip(*columns, strict=True)]


def sheet_under(to: Path, rng: Rng, head: str, encoding: str = "utf-8") -> Made:
    """Kilograms and counts, semicolons, decimal commas."""
    one, kg = cell(rng), steps((0, 0.5, 1, 2), 4)
    body = [x.replace(".", ",") for x in rows(kg, one.read(kg * G, rng), sep=";")]
    return Made([write(to / "cal.csv", [head, *body], encoding)], truth_of(one))


def on_two_plates(mass: float, gain: tuple[float, float], rng: Rng) -> Array:
    """Somebody on two plates who shifts from one to the other: what both read, (2, n)."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    parts = np.array([share, 1 - share])
    fz: Array = parts * mass * G / np.array(gain)[:, None] + rng.normal(0, 1, parts.shape)
    return fz
