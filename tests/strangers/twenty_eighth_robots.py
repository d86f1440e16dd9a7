"""Wrists, plates, insoles and legs as their tools and countries write them, each with its truth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.strangers.legged import _hung
from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Truth,
    filled,
    on_two_plates,
    rows,
    settling,
    tool_truth,
    wrist,
    write,
)

_FT = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
_NS = 1_710_237_600_000_000_000
_LBF = 4.4482216152605


def _plates(gain: tuple[float, float], names: tuple[str, str] = ("left", "right")) -> Truth:
    cells = {f"{n}_p{i}.scale": g for n, g in zip(names, gain, strict=True) for i in (1, 2, 3)}
    return Truth(cells, dict.fromkeys(cells, 0.1))


def _comma(lines: list[str]) -> list[str]:
    return [x.replace(".", ",") for x in lines]


def abb_egm(to: Path, rng: Rng) -> Made:
    """ABB's EGM feedback, flattened: `orient.u0 … u3` (scalar first), position in mm, a wrench."""
    made, wrench, rot = wrist(rng)
    quat = np.roll(rot.as_quat(), 1, axis=1)
    base = "feedBack.cartesian.pose"
    names = [
        "header.seqno",
        "header.tm",
        *(f"{base}.pos.{a}" for a in "xyz"),
        *(f"{base}.orient.u{i}" for i in range(4)),
        *(f"measuredForce.{n.lower()}" for n in _FT),
    ]
    n = np.arange(len(wrench))
    body = rows(n, 4012 + 20 * n, *rng.normal(400, 5, (3, n.size)), *quat.T, *wrench.T, form="%.6f")
    return Made([write(to / "egm.csv", [",".join(names), *body])], tool_truth(made))  # fmt: skip


def two_echoes_without_names(to: Path, rng: Rng) -> Made:
    """`ros2 topic echo --csv` twice: a WrenchStamped and a PoseStamped, no header in either."""
    made, wrench, rot = wrist(rng)
    w, p = [], []
    for i, (x, q) in enumerate(zip(wrench, rot.as_quat(), strict=True)):
        at = 20_000_000 * i
        stamp = f"{1710237600 + at // 10**9},{at % 10**9}"
        w.append(f"{stamp},ft_sensor,{','.join(f'{v:.6f}' for v in x)}")
        later = at + 2_000_000
        p.append(f"{1710237600 + later // 10**9},{later % 10**9},base,0.41,0.02,0.53,"
                 f"{','.join(f'{v:.6f}' for v in q)}")  # fmt: skip
    return Made([write(to / "wrench.csv", w), write(to / "pose.csv", p)], tool_truth(made))


def list_cells_of_rtde(to: Path, rng: Rng) -> Made:
    """UR: the wrench and the pose (rotation vector) are lists, each in one cell."""
    made, wrench, rot = wrist(rng)
    lines = ["timestamp;actual_TCP_pose;actual_TCP_force"]
    for i, (w, v) in enumerate(zip(wrench, rot.as_rotvec(), strict=True)):
        pose = [0.4, -0.1, 0.3, *v.round(6).tolist()]
        lines.append(f"{812.1 + 0.02 * i:.2f};{pose};{w.round(5).tolist()}")
    return Made([write(to / "rtde.csv", lines)], tool_truth(made))


def russian_wrist(to: Path, rng: Rng) -> Made:
    """Russian Excel: forces, moments, roll, pitch and yaw in cp1251."""
    made, wrench, rot = wrist(rng)
    names = ["Время, с", *(f"Сила {a}, Н" for a in "XYZ"), *(f"Момент {a}, Н·м" for a in "XYZ"),
             "Крен, °", "Тангаж, °", "Рыскание, °"]  # fmt: skip
    body = rows(np.arange(300) / 50, *wrench.T, *rot.as_euler("xyz", degrees=True).T, sep=";",
                form="%.5f")  # fmt: skip
    return Made([write(to / "датчик.csv", [";".join(names), *_comma(body)], "cp1251")],
                tool_truth(made))  # fmt: skip


def chinese_wrist(to: Path, rng: Rng) -> Made:
    """Chinese: forces, moments, roll, pitch and yaw, GBK."""
    made, wrench, rot = wrist(rng)
    names = ["时间(s)", *(f"力{a}(N)" for a in "XYZ"), *(f"力矩{a}(N·m)" for a in "XYZ"),
             "横滚角(°)", "俯仰角(°)", "偏航角(°)"]  # fmt: skip
    body = rows(np.arange(300) / 50, *wrench.T, *rot.as_euler("xyz", degrees=True).T, form="%.5f")
    return Made([write(to / "力传感器.csv", [",".join(names), *body], "gbk")], tool_truth(made))


def french_decanewtons(to: Path, rng: Rng) -> Made:
    """French: efforts in daN, moments in N·cm, roulis, tangage and lacet."""
    made, wrench, rot = wrist(rng)
    names = [
        "Temps (s)",
        *(f"Effort {a} (daN)" for a in "XYZ"),
        *(f"Moment {a} (N.cm)" for a in "XYZ"),
        "Roulis (°)",
        "Tangage (°)",
        "Lacet (°)",
    ]
    scaled = wrench * np.repeat([0.1, 100.0], 3)
    body = rows(np.arange(300) / 50, *scaled.T, *rot.as_euler("xyz", degrees=True).T, sep=";",
                form="%.6f")  # fmt: skip
    return Made([write(to / "poignet.csv", [";".join(names), *_comma(body)], "latin-1")],
                tool_truth(made))  # fmt: skip


def pounds_and_inch_pounds(to: Path, rng: Rng) -> Made:
    """ATI in imperial units: lbf and in-lbf, roll, pitch and yaw in degrees."""
    made, wrench, rot = wrist(rng)
    names = ["Time (s)", *(f"{n} (lbf)" for n in _FT[:3]), *(f"{n} (in-lbf)" for n in _FT[3:]),
             "Roll (deg)", "Pitch (deg)", "Yaw (deg)"]  # fmt: skip
    scaled = wrench / np.repeat([_LBF, _LBF * 0.0254], 3)
    body = rows(np.arange(300) / 50, *scaled.T, *rot.as_euler("xyz", degrees=True).T, form="%.6f")
    return Made([write(to / "gamma.csv", [",".join(names), *body])], tool_truth(made))


def days_in_both_files(to: Path, rng: Rng) -> Made:
    """Two Excel exports whose clocks are fractions of a day: wrench and arm, not the same rows."""
    made, wrench, rot = wrist(rng, 12, 40)
    t = np.arange(480) / 20
    day = 45363.41806
    w = [f"{day + s / 86400:.10f};{x}" for s, x in zip(t, rows(*wrench.T, sep=";", form="%.5f"),
                                                       strict=True)]  # fmt: skip
    angles = rot.as_euler("xyz", degrees=True)[::2]
    p = [f"{day + (s + 0.013) / 86400:.10f};{x}"
         for s, x in zip(t[::2], rows(*angles.T, sep=";", form="%.4f"), strict=True)]  # fmt: skip
    return Made([write(to / "kraft.csv", [";".join(["Zeitpunkt", *_FT]), *_comma(w)]),
                 write(to / "arm.csv", ["Zeitpunkt;Roll [°];Pitch [°];Yaw [°]", *_comma(p)])],
                tool_truth(made))  # fmt: skip


def onrobot_with_pose_mm(to: Path, rng: Rng) -> Made:
    """An OnRobot log: `F3D`, `T3D` (the lengths), status, pose in mm and rotation vector."""
    made, wrench, rot = wrist(rng)
    n = np.arange(300)
    names = "Sample,Status,Fx[N],Fy[N],Fz[N],Tx[Nm],Ty[Nm],Tz[Nm],F3D[N],T3D[Nm]," \
            "X[mm],Y[mm],Z[mm],RX[rad],RY[rad],RZ[rad]"  # fmt: skip
    body = rows(n, 0 * n, *wrench.T, np.linalg.norm(wrench[:, :3], axis=1),
                np.linalg.norm(wrench[:, 3:], axis=1), *np.repeat(rng.uniform(-400, 400, (3, 12)),
                25, axis=1), *rot.as_rotvec().T, form="%.5f")  # fmt: skip
    return Made([write(to / "onrobot.csv", [names, *body])], tool_truth(made))


def gravity_of_the_driver(to: Path, rng: Rng) -> Made:
    """A vector of gravity in the sensor's frame (m/s², down) instead of an attitude."""
    made, wrench, rot = wrist(rng)
    down = -9.80665 * rot.as_matrix()[:, 2, :] + rng.normal(0, 0.02, (300, 3))
    names = ["t", *_FT, "gravity_x", "gravity_y", "gravity_z"]
    return Made([write(to / "ft_gravity.csv", [",".join(names),
                       *rows(np.arange(300) / 50, *wrench.T, *down.T, form="%.5f")])],
                tool_truth(made))  # fmt: skip


def drake_q(to: Path, rng: Rng) -> Made:
    """Drake: `body_q[0] … [6]`, the quaternion first, and a wrench with the torque first."""
    made, wrench, rot = wrist(rng)
    quat = np.roll(rot.as_quat(), 1, axis=1)
    names = ["time", *(f"body_q[{i}]" for i in range(7)), *(f"wrench_tau_f[{i}]" for i in range(6))]
    place = rng.normal(0.4, 0.001, (3, 300))
    body = rows(np.arange(300) / 50, *quat.T, *place, *wrench[:, [3, 4, 5, 0, 1, 2]].T, form="%.6f")
    return Made([write(to / "drake.csv", [",".join(names), *body])], tool_truth(made))


def legs_in_a_list_of_objects(to: Path, rng: Rng) -> Made:
    """JSON lines of a hexapod: a list of legs with their wrenches, the base's quaternion."""
    wrenches, t, body, truth = _hung(rng, ("LF", "LM", "LR", "RR", "RM", "RF"))
    lines = []
    for i, (stamp, q) in enumerate(zip(t, body.as_quat(), strict=True)):
        legs = [{"name": n, "force": w[i, :3].round(5).tolist(),
                 "torque": w[i, 3:].round(5).tolist()} for n, w in wrenches.items()]  # fmt: skip
        base = dict(zip("xyzw", q.round(6).tolist(), strict=True))
        lines.append(json.dumps({"t": round(float(stamp), 3), "base": {"orientation": base},
                                 "legs": legs}))  # fmt: skip
    called = ("fl", "ml", "rl", "rr", "mr", "fr")
    return Made(
        [write(to / "hexapod.jsonl", lines)],
        _renamed(truth, dict(zip(wrenches, called, strict=True))),
    )


def hips_in_german(to: Path, rng: Rng) -> Made:
    """A hexapod in German: `vorn links`, `Mitte rechts` …, hip wrenches, Rollen, Nicken, Gieren."""
    legs = {"VL": "fl", "ML": "ml", "HL": "hl", "HR": "hr", "MR": "mr", "VR": "fr"}
    wrenches, t, body, truth = _hung(rng, tuple(legs.values()))
    names = ["Zeit_s", "Rollen_Grad", "Nicken_Grad", "Gieren_Grad"]
    names += [f"Hüfte_{leg}_{axis}" for leg in legs for axis in _FT]
    data = rows(t, *body.as_euler("xyz", degrees=True).T,
                *np.hstack([wrenches[n] for n in legs.values()]).T, sep=";",
                form="%.5f")  # fmt: skip
    return Made([write(to / "aufgehaengt.csv", [";".join(names), *_comma(data)], "latin-1")],
                _renamed(truth, {v: k for k, v in legs.items()}))  # fmt: skip


def _renamed(truth: Truth, names: dict[str, str]) -> Truth:
    """The truth of legs that the log calls otherwise: their own names in small letters."""

    def new(key: str) -> str:
        leg, end = key.split(".")
        return f"{names[leg].lower()}.{end}"

    return Truth({new(k): v for k, v in truth.values.items()},
                 {new(k): v for k, v in truth.within.items()})  # fmt: skip


def kinvent_two_plates(to: Path, rng: Rng) -> Made:
    """K-Deltas: two plates in kg, the person's weight in the head of the file."""
    mass, gain = 71.4, (1.05, 0.96)
    fz = on_two_plates(mass, gain, rng) / G
    head = ["Name;Jane Doe", "Body weight (kg);71.4", "Protocol;Static balance", "",
            "Time (s);Left (kg);Right (kg)"]  # fmt: skip
    body = rows(np.arange(fz.shape[1]) / 50, *fz, sep=";", form="%.3f")
    cells = {f"{n}.scale": g for n, g in zip(("left", "right"), gain, strict=True)}
    return Made([write(to / "kinvent.csv", [*head, *body])],
                Truth(cells, dict.fromkeys(cells, 0.1)), says="where")  # fmt: skip


def cortex_forces(to: Path, rng: Rng) -> Made:
    """Motion Analysis: `[Force Data]`, number of plates and rate, FX1 … MZ1 FX2 … MZ2."""
    mass, gain = 68.0, (1.04, 0.97)
    fz = on_two_plates(mass, gain, rng)
    n = fz.shape[1]
    head = ["[Force Data]", "NumberOfForcePlates=2", "SampleRate=50.000000",
            f"NumberOfSamples={n}", "#Sample\tFX1\tFY1\tFZ1\tX1\tY1\tZ1\tMZ1"
            "\tFX2\tFY2\tFZ2\tX2\tY2\tZ2\tMZ2"]  # fmt: skip
    data = [np.arange(1.0, n + 1)]
    for k in (0, 1):
        data += [*rng.normal(0, 1, (2, n)), fz[k], *rng.normal(0, 4, (2, n)), np.zeros(n),
                 *rng.normal(0, 100, (1, n))]  # fmt: skip

    def fill(recipe: str) -> str:
        return filled(mass_kg=f"{mass}")(recipe).replace('unit = "?"', 'unit = "mm"')

    return Made([write(to / "stand1.forces", [*head, *rows(*data, sep="\t", form="%.4f")])],
                _plates(gain, ("plate_1", "plate_2")), says="weigh", fill=fill)  # fmt: skip


def medilogic_sohlen(to: Path, rng: Rng) -> Made:
    """German insoles: force and centre of each sole, `Körpergewicht: 71,5 kg` above."""
    mass, gain = 71.5, (1.06, 0.95)
    fz = on_two_plates(mass, gain, rng)
    n = fz.shape[1]
    head = ["Patient: M. Muster", "Körpergewicht: 71,5 kg", "Messfrequenz: 50 Hz", "",
            "Zeit [s];Kraft links [N];CoP x links [mm];CoP y links [mm];Kraft rechts [N];"
            "CoP x rechts [mm];CoP y rechts [mm]"]  # fmt: skip
    cop = rng.normal(0, 4, (n, 4))
    body = rows(np.arange(n) / 50, fz[0], *cop[:, :2].T, fz[1], *cop[:, 2:].T, sep=";", form="%.2f")
    return Made([write(to / "sohlen.csv", [*head, *_comma(body)], "latin-1")], _plates(gain))


def noraxon_mass_in_head(to: Path, rng: Rng) -> Made:
    """Noraxon: quoted pairs above, the subject's weight among them; activity and marker."""
    mass, gain = 66.0, (1.05, 0.96)
    fz = on_two_plates(mass, gain, rng)
    n = fz.shape[1]
    head = ['"Subject","S07"', '"Weight [kg]","66.0"', '"Record","Standing"', ""]
    names = ["time", "Activity", "Marker", "LT Force (N)", "LT CoP X (mm)", "LT CoP Y (mm)",
             "RT Force (N)", "RT CoP X (mm)", "RT CoP Y (mm)"]  # fmt: skip
    cop = rng.normal(0, 4, (n, 4))
    body = [f"{i / 50:.3f},Quiet,," + x for i, x in enumerate(
        rows(fz[0], *cop[:, :2].T, fz[1], *cop[:, 2:].T, form="%.3f"))]  # fmt: skip
    return Made([write(to / "noraxon.csv", [*head, ",".join(f'"{x}"' for x in names), *body])],
                _plates(gain))  # fmt: skip


def plates_in_kilonewtons_unsaid(to: Path, rng: Rng) -> Made:
    """Two plates called N whose numbers are kN; the mass above contradicts them."""
    fz = on_two_plates(72.0, (1.04, 0.97), rng) / 1e3
    n = fz.shape[1]
    cop = rng.normal(0, 0.004, (n, 4))
    names = "t,left_fz_N,left_cop_x_m,left_cop_y_m,right_fz_N,right_cop_x_m,right_cop_y_m"
    body = rows(np.arange(n) / 50, fz[0], *cop[:, :2].T, fz[1], *cop[:, 2:].T, form="%.6f")
    return Made([write(to / "plates.csv", ["# subject mass: 72 kg", names, *body])], says="kN")


def _four_feet(rng: Rng, mass: float, gain: Array) -> Array:
    """One cell under each of four feet while the body leans to and fro: what they read (4, n)."""
    side = settling([0.35, 0.6, 0.45, 0.7, 0.5, 0.3], 4, 50)
    fore = settling([0.5, 0.3, 0.65, 0.4, 0.55, 0.6], 4, 50)
    load = np.array([side * fore, (1 - side) * fore, side * (1 - fore), (1 - side) * (1 - fore)])
    return load * mass * G / gain[:, None] + rng.normal(0, 0.1, load.shape)


def lcm_of_a_dog(to: Path, rng: Rng) -> Made:
    """An LCM log as CSV: `utime`, `contact_force[0] … [3]`, `rpy[0] … [2]`; no places."""
    read = _four_feet(rng, 9.2, np.array([1.03, 0.98, 1.05, 0.94]))
    n = read.shape[1]
    names = ["utime", *(f"contact_force[{i}]" for i in range(4)), *(f"rpy[{i}]" for i in range(3))]
    body = rows(1_710_237_600_000_000 + 20_000.0 * np.arange(n), *read,
                *rng.normal(0, 0.003, (3, n)), form="%.6f")  # fmt: skip
    return Made([write(to / "lcm.csv", ["% log of robot_state, mini cheetah, 9.2 kg",
                                        ",".join(names), *body])], says="sit")  # fmt: skip


def plotjuggler_two_stamps(to: Path, rng: Rng) -> Made:
    """PlotJuggler: `__time`, the header's own stamp, wrench and tf in turns (cells left empty)."""
    made, wrench, rot = wrist(rng)
    names = ["__time", "/ft/header/stamp", *(f"/ft/wrench/{k}/{a}" for k in ("force", "torque")
                                             for a in "xyz"),
             *(f"/tf/base/tool0/rotation/{a}" for a in "xyzw")]  # fmt: skip
    lines = [",".join(names)]
    body = zip(rows(*wrench.T, form="%.6f"), rows(*rot.as_quat().T, form="%.6f"), strict=True)
    for i, (w, q) in enumerate(body):  # fmt: skip
        t = 1710237600 + 0.02 * i
        lines += [f"{t:.4f},{t - 0.003:.4f},{w},,,,", f"{t + 0.004:.4f},,,,,,,,{q}"]
    return Made([write(to / "pj.csv", lines)], tool_truth(made))


def franka_in_one_cell(to: Path, rng: Rng) -> Made:
    """Franka with an ATI: `O_T_EE` as 16 numbers by columns in one cell, the wrench in six."""
    made, wrench, rot = wrist(rng)
    lines = ["time_ms,O_T_EE," + ",".join(f"ati_{n}" for n in _FT)]
    for i, (w, r) in enumerate(zip(rows(*wrench.T, form="%.5f"), rot.as_matrix(), strict=True)):
        full = np.eye(4)
        full[:3, :3], full[:3, 3] = r, [0.4, 0.1, 0.5]
        lines.append(f'{20 * i},"[{", ".join(f"{v:.6f}" for v in full.T.ravel())}]",{w}')
    return Made([write(to / "franka.csv", lines)], tool_truth(made))


def statistics_below_a_wrist(to: Path, rng: Rng) -> Made:
    """Means and standard deviations below a wrist's log, and its header repeated at each pose."""
    made, wrench, rot = wrist(rng)
    names = ",".join(["Time (s)", *_FT, "Roll (°)", "Pitch (°)", "Yaw (°)"])
    data = np.column_stack([np.arange(300) / 50, wrench, rot.as_euler("xyz", degrees=True)])
    lines = []
    for k in range(12):
        lines += [f"# pose {k + 1}", names, *rows(*data[25 * k : 25 * (k + 1)].T, form="%.5f")]
    lines += ["", "Mean," + rows(*data.mean(axis=0)[1:, None])[0],
              "StdDev," + rows(*data.std(axis=0)[1:, None])[0]]  # fmt: skip
    return Made([write(to / "poses.csv", lines)], tool_truth(made))


def matrices_without_stamps(to: Path, rng: Rng) -> Made:
    """Twelve rotation matrices, and twelve means of the wrench in the same order, in two files."""
    made, wrench, rot = wrist(rng, 14, 25)
    mean = wrench.reshape(14, 25, 6).mean(axis=1)
    turns = rot[::25].as_matrix().reshape(-1, 9)
    return Made([write(to / "wrenches.csv", [",".join(_FT), *rows(*mean.T, form="%.5f")]),
                 write(to / "rotations.csv", [",".join(f"r{i}{j}" for i in "123" for j in "123"),
                                              *rows(*turns.T, form="%.6f")])],
                tool_truth(made))  # fmt: skip


def force_plate_percent_of_stance(to: Path, rng: Rng) -> Made:
    """A mean step in percent of stance and of body weight: nothing that could be calibrated."""
    p = np.arange(101.0)
    fz = 100 * np.sin(np.pi * p / 100) * (1 + 0.2 * np.cos(4 * np.pi * p / 100))
    body = rows(p, fz, fz + 5, fz - 5, form="%.2f")
    return Made([write(to / "mean_step.csv", ["% stance,Fz mean (%BW),Fz +SD,Fz -SD", *body])],
                says="no")  # fmt: skip


TWENTY_EIGHTH_ROBOTS = (
    abb_egm, two_echoes_without_names, list_cells_of_rtde, russian_wrist, chinese_wrist,
    french_decanewtons, pounds_and_inch_pounds, days_in_both_files, onrobot_with_pose_mm,
    gravity_of_the_driver, drake_q, legs_in_a_list_of_objects, hips_in_german, kinvent_two_plates,
    cortex_forces, medilogic_sohlen, noraxon_mass_in_head, plates_in_kilonewtons_unsaid,
    lcm_of_a_dog, plotjuggler_two_stamps, franka_in_one_cell, statistics_below_a_wrist,
    matrices_without_stamps, force_plate_percent_of_stance,
)  # fmt: skip
