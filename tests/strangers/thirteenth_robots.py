"""Logs as laboratories keep them, IX: arms with other angles, jump plates, a dog's four feet.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    G,
    Made,
    Rng,
    on_two_plates,
    rows,
    tool_truth,
    wrist,
    write,
)


def staubli_intrinsic(to: Path, rng: Rng) -> Made:
    """Stäubli: rx, ry, rz in degrees about x, the new y and the newest z."""
    return _poses(to / "val3.csv", rng, "XYZ", "x,y,z,rx,ry,rz,Fx,Fy,Fz,Mx,My,Mz")


def doosan_abc(to: Path, rng: Rng) -> Made:
    """Doosan: A, B, C in degrees are about z, y and the new z."""
    return _poses(to / "drl_log.csv", rng, "ZYZ", "X,Y,Z,A,B,C,Fx,Fy,Fz,Mx,My,Mz")


def _poses(path: Path, rng: Rng, turns: Literal["XYZ", "ZYZ"], head: str) -> Made:
    made, wrench, rot = wrist(rng)
    place = np.tile([[400.0], [10.0], [500.0]], len(wrench))
    body = rows(*place, *rot.as_euler(turns, degrees=True).T, *wrench.T, form="%.5f")
    return Made([write(path, [head, *body])], tool_truth(made))


def mecademic_greek(to: Path, rng: Rng) -> Made:
    """Mecademic: alpha, beta, gamma in degrees about x, the new y and the newest z."""
    made, wrench, rot = wrist(rng)
    angle = rot.as_euler("XYZ", degrees=True)
    head = "timestamp_us,alpha,beta,gamma,Fx,Fy,Fz,Tx,Ty,Tz"
    body = rows(1e3 * np.arange(len(wrench)), *angle.T, *wrench.T, form="%.6f")
    return Made([write(to / "meca500.csv", [head, *body])], tool_truth(made))


def axis_and_angle(to: Path, rng: Rng) -> Made:
    """An attitude as an axis of length one and an angle."""
    made, wrench, rot = wrist(rng)
    vector = rot.as_rotvec()
    angle = np.linalg.norm(vector, axis=1)
    axis = vector / angle[:, None]
    head = "t,axis_x,axis_y,axis_z,angle,Fx,Fy,Fz,Tx,Ty,Tz"
    body = rows(0.01 * np.arange(len(wrench)), *axis.T, angle, *wrench.T, form="%.6f")
    return Made([write(to / "vrml.csv", [head, *body])], tool_truth(made))


def kilogram_force(to: Path, rng: Rng) -> Made:
    """A sensor in kgf and kgf·cm, the quaternion scalar first."""
    made, wrench, rot = wrist(rng)
    old = wrench / np.array([G] * 3 + [G / 100] * 3)
    head = ["time,q0,q1,q2,q3,Fx,Fy,Fz,Mx,My,Mz", "s,,,,,kgf,kgf,kgf,kgf-cm,kgf-cm,kgf-cm"]
    q = np.roll(rot.as_quat(), 1, axis=1)
    body = rows(0.01 * np.arange(len(old)), *q.T, *old.T, form="%.7f")
    return Made([write(to / "wacoh.csv", [*head, *body])], tool_truth(made))


def three_axes_alone(to: Path, rng: Rng) -> Made:
    """A sensor of three forces without torques on a wrist: what six axes need is not there."""
    _, wrench, rot = wrist(rng)
    body = rows(0.01 * np.arange(len(wrench)), *wrench[:, :3].T, *rot.as_quat().T, form="%.5f")
    return Made([write(to / "omd.csv", ["t,Fx,Fy,Fz,qx,qy,qz,qw", *body])], says="torque")


def tait_bryan_with_hpr(to: Path, rng: Rng) -> Made:
    """Heading, pitch and roll of an INS in north-east-down, the sensor turned with it."""
    made, _, rot = wrist(rng)
    down = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    ned = down * rot  # of a world whose z points down
    wrench = made.read(-rot.as_matrix()[:, 2, :], rng)
    yaw, pitch, roll = ned.as_euler("ZYX", degrees=True).T
    body = rows(0.02 * np.arange(len(wrench)), np.mod(yaw, 360), pitch, roll, *wrench.T,
                form="%.5f")  # fmt: skip
    head = ["GPS Time (s)", *(f"{a} (deg)" for a in ("Heading", "Pitch", "Roll")),
            *(f"F{a} (N)" for a in "XYZ"), *(f"M{a} (Nm)" for a in "XYZ")]  # fmt: skip
    return Made([write(to / "ins_ned.csv", [",".join(head), *body])], tool_truth(made))


def swing_catalyst(to: Path, rng: Rng) -> Made:
    """A golfer's plates: hh:mm:ss with seven decimals, force and CoP of each side, tabs."""
    fz = on_two_plates(80.0, (1.05, 0.96), rng)
    lines = ["Time\tLeft Fz (N)\tLeft CoPx (m)\tLeft CoPy (m)\tRight Fz (N)\tRight CoPx (m)\t"
             "Right CoPy (m)"]  # fmt: skip
    for i in range(fz.shape[1]):
        cop = rng.normal(0, 0.004, 4)
        lines.append(f"00:00:{i / 50:010.7f}\t{fz[0, i]:.3f}\t{cop[0]:.5f}\t{cop[1]:.5f}\t"
                     f"{fz[1, i]:.3f}\t{cop[2]:.5f}\t{cop[3]:.5f}")  # fmt: skip
    return Made([write(to / "ForcePlates.tsv", lines)], says="weigh")


def hawkin_dynamics(to: Path, rng: Rng) -> Made:
    """A jump laboratory: left, right and both together, no CoP."""
    fz = on_two_plates(80.0, (1.05, 0.96), rng)
    t = np.arange(fz.shape[1]) / 50
    lines = ["Time (s),LeftForce (N),RightForce (N),Combined (N)",
             *rows(t, *fz, fz.sum(axis=0), form="%.4f")]  # fmt: skip
    return Made([write(to / "quiet_stand.csv", lines)], says="weigh")


def vald_forcedecks(to: Path, rng: Rng) -> Made:
    """ForceDecks: name and weight of the athlete above, `Z Left`, `Z Right`."""
    fz = on_two_plates(80.0, (1.05, 0.96), rng)
    head = [
        "Athlete,NN",
        "Date,12/03/2024",
        "BW [KG],80.1",
        "",
        "Time,Z Left,Z Right",
        "(s),(N),(N)",
    ]
    body = rows(np.arange(fz.shape[1]) / 50, *fz, form="%.3f")
    return Made([write(to / "ForceDecks.csv", [*head, *body])], says="weigh")


def dog_with_its_mass_above(to: Path, rng: Rng) -> Made:
    """Four feet of a dog-sized robot; the mass in a remark above is no mass of their 120 N."""
    n = 300
    feet = rng.normal(30, 1, (4, n))
    head = ["# robot: pupper, mass: 2.1 kg", "t,FL_force_N,FR_force_N,RL_force_N,RR_force_N"]
    body = rows(np.arange(n) / 100, *feet, form="%.4f")
    return Made([write(to / "stance.csv", [*head, *body])], says="no mass of 2.1 kg")


def op3_serial(to: Path, rng: Rng) -> Made:
    """A biped's boards: `L:512,498,530,505 R:…`, eight pressure cells a line, no weights."""
    n, lines = 200, []
    for i in range(n):
        left, right = (np.round(rng.normal(512, 6, 4)).astype(int) for _ in "lr")
        lines.append(f"{i * 8} L:{','.join(map(str, left))} R:{','.join(map(str, right))}")
    return Made([write(to / "cm730.log", lines)], says="weigh")


THIRTEENTH_ROBOTS = (
    staubli_intrinsic, doosan_abc, mecademic_greek, axis_and_angle, kilogram_force,
    three_axes_alone, tait_bryan_with_hpr, swing_catalyst, hawkin_dynamics, vald_forcedecks,
    dog_with_its_mass_above, op3_serial,
)  # fmt: skip
