"""Logs of six-axis transducers whose shapes were misread or refused, with numbers of our own."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Made, Rng, Truth, rows, tool, tool_truth, wrist, write

_KGF = 9.80665


def kilogram_force_centimetres(to: Path, rng: Rng) -> Made:
    """Units of torque without a sign between force and length, at the end of the names."""
    made, wrench, rot = wrist(rng, 14, 20)
    names = [f"R{i}{j}" for i in "123" for j in "123"]
    names += [f"f{a}_kgf" for a in "xyz"] + [f"t{a}_kgfcm" for a in "xyz"]
    scaled = wrench / _KGF * np.repeat([1.0, 100.0], 3)
    data = np.hstack([rot.as_matrix().reshape(-1, 9), scaled])
    stamps = 1_732_600_000_123_456_789 + 20_000_000 * np.arange(len(data))
    body = [f"{t},{line}" for t, line in zip(stamps, rows(*data.T, form="%.6f"), strict=True)]
    return Made(
        [write(to / "ft_rot.csv", [",".join(["stamp_ns", *names]), *body])], tool_truth(made)
    )


def directions_in_lists(to: Path, rng: Rng) -> Made:
    """JSON lines: a unit vector along gravity, a force and a torque, each a list; no stamps."""
    made, wrench, rot = wrist(rng, 24, 1)
    down = rot.inv().apply([0.0, 0.0, -1.0])
    lines = [
        json.dumps({"gravity_dir": [*d.round(5)], "force": [*w[:3]], "torque": [*w[3:]]})
        for d, w in zip(down, wrench, strict=True)
    ]
    return Made([write(to / "tool.jsonl", lines)], tool_truth(made))


def sensor_number_nought(to: Path, rng: Rng) -> Made:
    """The one transducer is called 0: a name, and no number."""
    made, wrench, rot = wrist(rng)
    names = [f"sensor_0.wrench.{what}.{a}" for what in ("force", "torque") for a in "xyz"]
    body = rows(0.02 * np.arange(len(wrench)), *wrench.T, *rot.as_quat().T, form="%.6f")
    return Made(
        [write(to / "ft.csv", [",".join(["time", *names, "qx", "qy", "qz", "qw"]), *body])],
        tool_truth(made),
    )


def matrix_above_each_wrench(to: Path, rng: Rng) -> Made:
    """Three lines of a rotation matrix, then the wrench, for each pose."""
    made, wrench, rot = wrist(rng, 16, 1)
    lines = ["# rotation matrix, then fx fy fz tx ty tz"]
    for turn, w in zip(rot.as_matrix(), wrench, strict=True):
        lines += [*rows(*turn.T, sep=" ", form="%.6f"), " ".join(f"{v:.4f}" for v in w)]
    return Made([write(to / "poses.txt", lines)], tool_truth(made))


def matrices_in_a_second_file(to: Path, rng: Rng) -> Made:
    """Flange poses as matrices of four lines; the wrenches in a table of their own."""
    made, wrench, rot = wrist(rng, 16, 1)
    lines = []
    for turn in rot.as_matrix():
        whole = np.hstack([turn, rng.uniform(0.2, 0.6, (3, 1))])
        lines += [*rows(*whole.T, sep=" ", form="%.6f"), "0 0 0 1", ""]
    table = ["Fx,Fy,Fz,Mx,My,Mz", *rows(*wrench.T, form="%.4f")]
    return Made([write(to / "flange.txt", lines), write(to / "wrench.csv", table)],
                tool_truth(made))  # fmt: skip


def angle_of_the_shaft(to: Path, rng: Rng) -> Made:
    """Two legs that turn in four orientations, a file for each; the shaft angle in degrees."""
    paths: list[Path] = []
    values: dict[str, float] = {}
    for leg in ("fl", "fr"):
        made, lines = tool(rng), ["orientation,t_ms,angle_deg,Fx,Fy,Fz,Tx,Ty,Tz"]
        for k, (name, axis) in enumerate((("+x", 0), ("-x", 0), ("+z", 2), ("-z", 2))):
            turn = np.linspace(0, 6 * np.pi, 120) % (2 * np.pi)
            down = np.zeros((120, 3))
            down[:, axis] = -1.0 if name[0] == "-" else 1.0
            force = made.weight_n * down
            arm = made.com_m + 0.06 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
            read = np.hstack([force, np.cross(arm, force)]) + made.offset
            read += rng.normal(0, [0.02] * 3 + [0.001] * 3, read.shape)
            body = rows(2e5 * k + 1000.0 * np.arange(120), np.degrees(turn), *read.T, form="%.4f")
            lines += [f"{name},{line}" for line in body]
        paths.append(write(to / f"hang_{leg}.csv", lines))
        values |= {f"{leg}.offset_f{a}": made.offset[i] for i, a in enumerate("xyz")}
    return Made(paths, Truth(values, dict.fromkeys(values, 0.03)))


def results_of_a_calibration(to: Path, rng: Rng) -> Made:
    """Offsets, mass and CoM of four sensors, a row for each: a result, and no wrench."""
    lines = ["sensor,mass_kg,cx_m,cy_m,cz_m,fx0_N,fy0_N,fz0_N,tx0_Nm,ty0_Nm,tz0_Nm"]
    for leg in ("LF", "RF", "LH", "RH"):
        made = tool(rng)
        numbers = [made.weight_n / _KGF, *made.com_m, *made.offset]
        lines.append(",".join([leg, *(f"{v:.4f}" for v in numbers)]))
    return Made([write(to / "result.csv", lines)], says="results of a calibration")


def one_axis_is_dead(to: Path, rng: Rng) -> Made:
    """A wrist whose force along y was not wired: it scatters, and follows nothing."""
    _, wrench, rot = wrist(rng)
    wrench[:, 1] = rng.normal(0, 0.05, len(wrench))
    body = rows(0.02 * np.arange(len(wrench)), *wrench.T, *rot.as_quat().T, form="%.6f")
    names = "t,Fx,Fy,Fz,Tx,Ty,Tz,qx,qy,qz,qw"
    return Made([write(to / "arm.csv", [names, *body])], says="Fy hardly moves")


TWENTY_SECOND = (
    kilogram_force_centimetres, directions_in_lists, sensor_number_nought,
    matrix_above_each_wrench, matrices_in_a_second_file, angle_of_the_shaft,
    results_of_a_calibration, one_axis_is_dead,
)  # fmt: skip
