"""Conventions turned against the guess: where a wrong calibration would look like a right one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Tool,
    Truth,
    attitudes,
    cell,
    rows,
    steps,
    tool,
    tool_truth,
    truth_of,
    write,
)

HEAD = "time,fx,fy,fz,tx,ty,tz,"


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Array]:
    made = tool(rng)
    rot, _ = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), rot


def _quaternion(to: Path, made: Tool, wrench: Array, rot: Rotation) -> Made:
    body = rows(np.arange(len(wrench)) * 0.01, *wrench.T, *rot.as_quat().T)
    return Made([write(to / "arm.csv", [HEAD + "qx,qy,qz,qw", *body])], tool_truth(made))


def world_to_body(to: Path, rng: Rng) -> Made:
    made, wrench, rot = _wrist(rng)
    return _quaternion(to, made, wrench, Rotation.from_matrix(rot).inv())


def noisy_attitude(to: Path, rng: Rng) -> Made:
    made, wrench, rot = _wrist(rng)
    noise = Rotation.from_rotvec(rng.normal(0, 0.004, (len(rot), 3)))
    return _quaternion(to, made, wrench, Rotation.from_matrix(rot) * noise)


def flange_turned_a_little(to: Path, rng: Rng) -> Made:
    made, wrench, rot = _wrist(rng)
    turn = Rotation.from_euler("z", 12, degrees=True)
    return _quaternion(to, made, wrench, Rotation.from_matrix(rot) * turn)


def what_the_sensor_exerts(to: Path, rng: Rng) -> Made:
    made, wrench, rot = _wrist(rng)
    found = tool_truth(made)
    values = {name: -v if "offset" in name else v for name, v in found.values.items()}
    log = _quaternion(to, made, 2 * made.offset - wrench, Rotation.from_matrix(rot))
    return Made(log.paths, Truth(values, found.within))


def intrinsic_angles(to: Path, rng: Rng) -> Made:
    _, wrench, rot = _wrist(rng)
    angles = Rotation.from_matrix(rot).as_euler("XYZ", degrees=True)
    body = rows(np.arange(len(rot)) * 0.01, *wrench.T, *angles.T)
    return Made([write(to / "arm.csv", [HEAD + "roll,pitch,yaw", *body])], says="attitude")


def torques_in_nmm_unsaid(to: Path, rng: Rng) -> Made:
    made, wrench, rot = _wrist(rng)
    scaled = wrench * np.array([1, 1, 1, 1e3, 1e3, 1e3])
    return _quaternion(to, made, scaled, Rotation.from_matrix(rot))


def plus_means_up(to: Path, rng: Rng) -> Made:
    made, paths = tool(rng), []
    for sign, name in ((-1.0, "plus"), (1.0, "minus")):
        for axis in range(3):
            wrench = made.read(np.tile(sign * np.eye(3)[axis], (80, 1)), rng)
            body = rows(np.arange(80) / 100, *wrench.T)
            path = to / f"{name}_{'xyz'[axis]}.csv"
            paths.append(write(path, ["t,Fx,Fy,Fz,Tx,Ty,Tz", *body]))
    return Made(paths, tool_truth(made))


def loads_with_p_and_tare(to: Path, rng: Rng) -> Made:
    one, paths = cell(rng), []
    for name, kg in (("0p5kg", 0.5), ("1kg", 1.0), ("1p5kg", 1.5), ("tare", 0.0)):
        body = rows(np.arange(40) * 100, one.read(np.full(40, kg * G), rng), form="%d")
        paths.append(write(to / f"cell_{name}.csv", ["ms,raw", *body]))
    return Made(paths, truth_of(one))


def grams_and_kilograms(to: Path, rng: Rng) -> Made:
    one, paths = cell(rng), []
    for name, kg in (("0g", 0.0), ("500g", 0.5), ("1kg", 1.0), ("2kg", 2.0)):
        body = rows(one.read(np.full(40, kg * G), rng), form="%d")
        paths.append(write(to / f"{name}.txt", body))
    return Made(paths, truth_of(one))


def decimal_comma_before_a_unit(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps((0, 0.5, 1.0, 1.5), 4)
    body = [
        f"A;{k:g} kg;{c:.0f}".replace(".", ",")
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    return Made([write(to / "x.csv", ["Zelle;Gewicht;Wert", *body])], truth_of(one))


def three_decimals_are_no_thousands(to: Path, rng: Rng) -> Made:
    one, kg = cell(rng), steps((0, 1, 2, 3), 4)
    body = [
        f"{k:.3f};{c:.0f}".replace(".", ",") for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    return Made([write(to / "x.csv", ["Gewicht [kg];Wert", *body])], truth_of(one))


TURNED = (
    world_to_body, noisy_attitude, flange_turned_a_little, what_the_sensor_exerts,
    intrinsic_angles, torques_in_nmm_unsaid, plus_means_up, loads_with_p_and_tare,
    grams_and_kilograms, decimal_comma_before_a_unit, three_decimals_are_no_thousands,
)  # fmt: skip
