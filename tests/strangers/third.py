"""Twenty-five more shapes, written down before the guessing was looked at again."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
    G,
    Made,
    Rng,
    Tool,
    attitudes,
    cell,
    filled,
    rows,
    settling,
    steps,
    tool,
    tool_truth,
    truth_of,
    write,
)

KG = (0.0, 0.5, 1.0, 1.5, 2.0)
DOWN = {"plus_x": (1, 0, 0), "minus_x": (-1, 0, 0), "plus_y": (0, 1, 0), "minus_y": (0, -1, 0),
        "plus_z": (0, 0, 1), "minus_z": (0, 0, -1)}  # fmt: skip


def _wrist(rng: Rng, poses: int = 12, hold: int = 25) -> tuple[Tool, Array, Array, Array]:
    """Tool, wrenches, attitudes of the sensor (body to world), roll-pitch-yaw."""
    made = tool(rng)
    rot, rpy = attitudes(rng, poses, hold)
    return made, made.read(-rot[:, 2, :], rng), rot, rpy


def _quoted(table: Sequence[Sequence[object]], sep: str = ",") -> list[str]:
    out = io.StringIO()
    csv.writer(out, delimiter=sep, lineterminator="\n").writerows(table)
    return out.getvalue().splitlines()


def opencr_serial(to: Path, rng: Rng) -> Made:
    """OpenCR board, one line per reading, the load typed into the sketch."""
    one, g = cell(rng, "adc12"), steps((0, 200, 500, 1000), 6)
    lines = ["[OpenCR] load cell test v1.2", "[OpenCR] ready"]
    lines += [
        f"t:{1000 + 50 * i} load:{k:.0f}g adc:{c:.0f}"
        for i, (k, c) in enumerate(zip(g, one.read(g * G / 1e3, rng), strict=True))
    ]
    return Made([write(to / "opencr.log", lines)], truth_of(one, 10))


def choregraphe_fsr(to: Path, rng: Rng) -> Made:
    """NAO's memory keys by another recorder: semicolons, decimal commas."""
    keys = [
        f"Device/SubDeviceList/{f}Foot/FSR/{p}/Sensor/Value"
        for f in "LR"
        for p in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
    ]
    t = np.arange(300) * 0.02
    body = rows(t, *(np.abs(rng.normal(0.62, 0.01, 300)) for _ in keys), sep=";", form="%.5f")
    lines = [";".join(["Time (s)", *keys]), *(line.replace(".", ",") for line in body)]
    return Made([write(to / "fsr_log.csv", lines)], says="where the cells sit")


def spotmicro_hx711(to: Path, rng: Rng) -> Made:
    """Arduino: millis and raw reading, messages of the sketch, weights typed in between."""
    one = cell(rng)
    lines = ["HX711 init...", "Tare done"]
    now = 1532
    for g in (0, 100, 200, 500):
        lines.append(f">> put {g} g on the foot")
        for c in one.read(np.full(10, g * G / 1e3), rng):
            lines.append(f"{now}: {c:.0f}")
            now += 100
        lines.append("ok")
    return Made([write(to / "spotmicro.txt", lines)], truth_of(one, 5))


def netft_orientations(to: Path, rng: Rng) -> Made:
    """ATI Net F/T: counts below a header that says how many make a newton; a file per side."""
    made, paths = tool(rng), []
    for name, g in DOWN.items():
        wrench = made.read(np.tile(np.array(g, float), (120, 1)), rng) * 1e6
        head = [
            '"Start Time: 6/3/2021 10:11:12 AM"', "RDT Sample Rate: 1000", "Force Units: N",
            "Counts per Unit Force: 1000000", "Torque Units: Nm",
            "Counts per Unit Torque: 1000000",
            "Status (hex),RDT Sequence,F/T Sequence,Fx,Fy,Fz,Tx,Ty,Tz",
        ]  # fmt: skip
        body = [
            f"0x00000000,{i + 1},{7 * i + 4000},{','.join(f'{v:.0f}' for v in w)}"
            for i, w in enumerate(wrench)
        ]
        paths.append(write(to / f"hang_{name}.csv", [*head, *body]))
    return Made(paths, tool_truth(made))


def optoforce_hangs(to: Path, rng: Rng) -> Made:
    """OptoForce export, one file per side that hangs down."""
    made, paths = tool(rng), []
    for name, g in DOWN.items():
        wrench = made.read(np.tile(np.array(g, float), (100, 1)), rng)
        t = np.arange(100) / 100
        head = "Time [s];Fx [N];Fy [N];Fz [N];Tx [Nm];Ty [Nm];Tz [Nm]"
        paths.append(write(to / f"{name}.csv", [head, *rows(t, *wrench.T, sep=";")]))
    return Made(paths, tool_truth(made))


def amti_plate_weights(to: Path, rng: Rng) -> Made:
    """A plate under known masses: rows of six numbers without names, the mass in the file name."""
    paths, gain = [], 1.06
    for kg in (0, 5, 10, 20):
        wrench = rng.normal(0, 0.2, (200, 6)) + np.array([0.4, -0.2, 3.0, 0.1, 0.2, 0.05])
        wrench[:, 2] -= kg * G / gain
        head = ["AMTI NetForce", "Subject,,,", "Plate,OR6-7-1000", "Rate,1000",
                "Fx,Fy,Fz,Mx,My,Mz", "N,N,N,N-m,N-m,N-m"]  # fmt: skip
        paths.append(write(to / f"plate_{kg}kg.csv", [*head, *rows(*wrench.T, form="%.4f")]))
    return Made(
        paths,
        truth_of(type(cell(rng))(-gain, 3.0 * gain, 0.2), 200),
    )


def bertec_two_plates(to: Path, rng: Rng) -> Made:
    """Two plates, force and CoP of each foot."""
    t = np.arange(800) / 1000
    names = ["Time (s)"]
    data = [t]
    for i in (1, 2):
        names += [f"Fz{i} (N)", f"COPx{i} (mm)", f"COPy{i} (mm)"]
        data += [rng.normal(350, 2, 800), rng.normal(20, 2, 800), rng.normal(-5, 2, 800)]
    head = ["Bertec Digital Acquire", "Date\t2025-11-03", "Device\tFP4060", "Samples\t800", ""]
    lines = [*head, "\t".join(names), *rows(*data, sep="\t")]
    return Made([write(to / "quiet_stance.txt", lines)], says="weigh")


def vicon_two_sections(to: Path, rng: Rng) -> Made:
    """Nexus export: devices first, trajectories below."""
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (200, 1)), rng)
    frame, sub = np.repeat(np.arange(1, 21), 10), np.tile(np.arange(10), 20)
    head = ["Devices", "1000", ",,Kistler - Force,,,Kistler - Moment,,",
            "Frame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz", ",,N,N,N,N.mm,N.mm,N.mm"]  # fmt: skip
    tail = ["", "Trajectories", "100", ",,S01:LTOE,,,S01:RTOE,,",
            "Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,mm,mm,mm,mm,mm,mm"]  # fmt: skip
    marks = rows(np.arange(1, 21), np.zeros(20), *rng.normal(100, 1, (6, 20)))
    lines = [*head, *rows(frame, sub, *wrench.T), *tail, *marks]
    return Made([write(to / "walk03.csv", lines)], says="attitude")


def moticon(to: Path, rng: Rng) -> Made:
    """Moticon OpenGo export: comment lines, then tabs, one comment line of names."""
    names = ["time", *(f"{s} total force[N]" for s in ("left", "right"))]
    names += [f"{s} center of pressure {a}[-0.5...+0.5]" for s in ("left", "right") for a in "XY"]
    n = 500
    data = [np.arange(n) / 50, rng.normal(380, 3, n), rng.normal(360, 3, n)]
    data += [rng.normal(0.05, 0.01, n) for _ in range(4)]
    head = ["# Name: Measurement 3", "# Insole size: 6", "#", "# " + "\t".join(names)]
    return Made([write(to / "opengo.txt", [*head, *rows(*data, sep="\t")])], says="weigh")


def loadsol_ascii(to: Path, rng: Rng) -> Made:
    """loadsol's own ASCII: a file name, insole numbers, two time columns."""
    n = 400
    t = np.arange(n) / 100
    head = [
        "C:/loadsol/S01_stand.pdo", "Insole: left: LS-R-1234  right: LS-R-1235", "",
        "Time[secs]\tLeft heel[N]\tLeft medial[N]\tLeft lateral[N]\tTime[secs]\tRight heel[N]"
        "\tRight medial[N]\tRight lateral[N]",
    ]  # fmt: skip
    left, right = (rng.normal(120, 2, (3, n)) for _ in range(2))
    body = rows(t, *left, t, *right, sep="\t", form="%.3f")
    return Made([write(to / "stand.txt", [*head, *body])], says="weigh")


def mc_rtc_log(to: Path, rng: Rng) -> Made:
    """mc_rtc by mc_bin_to_log: semicolons, couples first, two ankles and a base."""
    n = 400
    names, data = ["t"], [np.arange(n) * 0.005]
    for side in ("Right", "Left"):
        names += [f"{side}FootForceSensor_{a}" for a in ("cx", "cy", "cz", "fx", "fy", "fz")]
        data += [*rng.normal(0, 0.2, (5, n)), rng.normal(190, 1, n)]
    names += [f"FloatingBase_orientation_{a}" for a in "wxyz"]
    data += [np.ones(n), *np.zeros((3, n))]
    return Made(
        [write(to / "mc-control-latest.csv", [";".join(names), *rows(*data, sep=";")])],
        says="weigh",
    )


def rostopic_two_files(to: Path, rng: Rng) -> Made:
    """`rostopic echo -p` of the wrench and of the IMU, each with its header time."""
    made, wrench, rot, _ = _wrist(rng)
    quat = Rotation.from_matrix(rot).as_quat()
    ns = 1_700_000_000_000_000_000 + np.arange(len(rot)) * 10_000_000
    common = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    head = [*common, *(f"field.wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz")]
    one = [
        f"{t + 400_000},{i},{t},ft," + ",".join(f"{v:.8g}" for v in w)
        for i, (t, w) in enumerate(zip(ns, wrench, strict=True))
    ]
    imu = [*common, *(f"field.orientation.{a}" for a in "xyzw")]
    imu += [f"field.angular_velocity.{a}" for a in "xyz"]
    imu += [f"field.linear_acceleration.{a}" for a in "xyz"]
    acc = 9.81 * rot[:, 2, :]
    two = [
        f"{t + 1_900_000},{i},{t + 1_000_000},imu,"
        + ",".join(f"{v:.8g}" for v in (*q, 0.0, 0.0, 0.0, *a))
        for i, (t, q, a) in enumerate(zip(ns, quat, acc, strict=True))
    ]
    paths = [
        write(to / "wrench.csv", [",".join(head), *one]),
        write(to / "imu.csv", [",".join(imu), *two]),
    ]
    return Made(paths, tool_truth(made))


def ros2_echo_csv(to: Path, rng: Rng) -> Made:
    """`ros2 topic echo --csv`: no names; seconds and nanoseconds apart."""
    wrench = tool(rng).read(np.tile([0.0, 0.0, -1.0], (200, 1)), rng)
    lines = [
        f"{1_700_000_000 + i // 100},{(i % 100) * 10_000_000},ft_frame,"
        + ",".join(repr(float(v)) for v in w)
        for i, w in enumerate(wrench)
    ]
    return Made([write(to / "ft.csv", lines)], says="attitude")


def pandas_index(to: Path, rng: Rng) -> Made:
    """`DataFrame.to_csv` with its index and whole numbers as floats."""
    cells, kg = {"cell_a": cell(rng), "cell_b": cell(rng)}, steps(KG, 4)
    body = rows(np.arange(kg.size), kg, *(c.read(kg * G, rng) for c in cells.values()), form="%.1f")
    body = [line.replace(".0,", ",", 1) for line in body]
    return Made([write(to / "df.csv", [",load_kg,cell_a,cell_b", *body])], truth_of(cells))


def excel_thousands(to: Path, rng: Rng) -> Made:
    """German Excel: mark of UTF-8, semicolons, points between thousands."""
    one, kg = cell(rng), steps(KG, 3)
    body = [
        f"{k:.1f};".replace(".", ",") + f"{c:,.0f}".replace(",", ".")
        for k, c in zip(kg, one.read(kg * G, rng), strict=True)
    ]
    lines = ["\ufeffMasse (kg);Rohwert", *body]
    return Made([write(to / "Mappe1.csv", lines, end="\r\n")], truth_of(one))


def python_logging(to: Path, rng: Rng) -> Made:
    """Python's logging module."""
    one, g = cell(rng, "hx_small"), steps((0, 200, 500, 1000), 8)
    lines = [
        f"2026-03-01 10:{i // 60:02d}:{i % 60:02d},345 INFO loadcell: weight={k:.0f} g raw={c:.0f}"
        for i, (k, c) in enumerate(zip(g, one.read(g * G / 1e3, rng), strict=True))
    ]
    return Made([write(to / "calib.log", lines)], truth_of(one, 10))


def unix_us_kgf(to: Path, rng: Rng) -> Made:
    """Microseconds since 1970, loads in kgf, comments of C."""
    one, kgf = cell(rng, "adc12"), steps((0, 1, 2, 4), 5)
    t = 1_770_000_000_000_000 + np.arange(kgf.size) * 250_000
    body = rows(t, kgf, one.read(kgf * G, rng), form="%.16g")
    return Made(
        [write(to / "scale.csv", ["// bridge 2, 10 V", "stamp,force_kgf,adc_value", *body])],
        truth_of(one, 40),
    )


def mixed_unit_texts(to: Path, rng: Rng) -> Made:
    """Weights as people write them: 500g, 1kg, 1.5 kg."""
    one = cell(rng)
    lines = ["what,reading"]
    for text, kg in (("0", 0.0), ("500g", 0.5), ("1kg", 1.0), ("1.5 kg", 1.5), ("2kg", 2.0)):
        lines += [f"{text},{c:.0f}" for c in one.read(np.full(4, kg * G), rng)]
    return Made([write(to / "notes.csv", lines)], truth_of(one))


def english_thousands(to: Path, rng: Rng) -> Made:
    """A spreadsheet's number format: quoted, commas between thousands."""
    one, g = cell(rng), steps((0, 500, 1000, 2000), 4)
    table = [["Weight (g)", "Raw count"]]
    table += [
        [f"{k:,.0f}", f"{c:,.0f}"] for k, c in zip(g, one.read(g * G / 1e3, rng), strict=True)
    ]
    return Made([write(to / "sheet.csv", _quoted(table))], truth_of(one))


def hex_counts(to: Path, rng: Rng) -> Made:
    """A converter's registers as they were read."""
    one, g = cell(rng), steps((0, 500, 1000, 2000), 4)
    body = [f"{k:.0f},0x{int(c):06X}" for k, c in zip(g, one.read(g * G / 1e3, rng), strict=True)]
    return Made([write(to / "registers.csv", ["load_g,raw_hex", *body])], truth_of(one))


def scalar_first(to: Path, rng: Rng) -> Made:
    """Quaternion q0 … q3, the scalar first, world to body."""
    made, wrench, rot, _ = _wrist(rng)
    quat = np.roll(Rotation.from_matrix(rot).inv().as_quat(), 1, axis=1)
    t = np.arange(len(rot)) * 0.01
    head = "time,q0,q1,q2,q3,Fx,Fy,Fz,Mx,My,Mz"
    return Made([write(to / "arm.csv", [head, *rows(t, *quat.T, *wrench.T)])], tool_truth(made))


def torque_first_nmm(to: Path, rng: Rng) -> Made:
    """Moments first and in Nmm, degrees, yaw before pitch before roll."""
    made, wrench, _, rpy = _wrist(rng)
    names = ["Mx(Nmm)", "My(Nmm)", "Mz(Nmm)", "Fx(N)", "Fy(N)", "Fz(N)"]
    names += ["Yaw(deg)", "Pitch(deg)", "Roll(deg)"]
    data = [*(1e3 * wrench[:, 3:].T), *wrench[:, :3].T, *np.degrees(rpy[:, ::-1]).T]
    return Made([write(to / "flange.txt", ["\t".join(names), *rows(*data, sep="\t")])],
                tool_truth(made))  # fmt: skip


def python_dicts(to: Path, rng: Rng) -> Made:
    """`print(row)` of a dictionary."""
    one, kg = cell(rng), steps(KG, 4)
    lines = [
        str({"t": round(0.1 * i, 1), "weight_kg": float(k), "raw": int(c)})
        for i, (k, c) in enumerate(zip(kg, one.read(kg * G, rng), strict=True))
    ]
    return Made([write(to / "printed.txt", lines)], truth_of(one))


def gravity_by_accelerometer(to: Path, rng: Rng) -> Made:
    """A wrist with an accelerometer beside it, in g: what it reads at rest points upward."""
    made, wrench, rot, _ = _wrist(rng)
    acc = rot[:, 2, :] + rng.normal(0, 0.002, (len(rot), 3))
    t = np.arange(len(rot)) * 0.01
    head = "t_s,fx,fy,fz,tx,ty,tz,acc_x_g,acc_y_g,acc_z_g"
    return Made([write(to / "imu_ft.csv", [head, *rows(t, *wrench.T, *acc.T)])], tool_truth(made))


def loads_across(to: Path, rng: Rng) -> Made:
    """A sheet of cells by weights: the loads stand in the header."""
    cells = {name: cell(rng) for name in ("FL", "FR", "RL", "RR")}
    lines = ["cell;0 kg;0.5 kg;1 kg;2 kg"]
    for name, one in cells.items():
        counts = one.read(np.array([0, 0.5, 1, 2]) * G, rng)
        lines.append(";".join([name, *(f"{c:.0f}" for c in counts)]))
    return Made([write(to / "Tabelle1.csv", lines)], truth_of(cells))


def matlab_workspace(to: Path, rng: Rng) -> Made:
    """A .mat file."""
    one, kg = cell(rng), steps(KG, 4)
    savemat(to / "bench.mat", {"load_kg": kg, "counts": one.read(kg * G, rng)})
    return Made([to / "bench.mat"], truth_of(one))


def silent_weights(to: Path, rng: Rng) -> Made:
    """A recording without loads; the next step, followed, gives the calibration."""
    one = cell(rng)
    load = settling([0, 5, 10, 20, 0], 5, 20)
    t = np.arange(load.size) / 20
    lines = ["time_ms,raw", *rows(1000 * t, one.read(load, rng), form="%d")]
    return Made(
        [write(to / "recorded.csv", lines)], truth_of(one), says="loads",
        fill=filled(loads='"0, 5, 10, 20, 0 N"'),
    )  # fmt: skip


THIRD = (
    opencr_serial, choregraphe_fsr, spotmicro_hx711, netft_orientations, optoforce_hangs,
    amti_plate_weights, bertec_two_plates, vicon_two_sections, moticon, loadsol_ascii, mc_rtc_log,
    rostopic_two_files, ros2_echo_csv, pandas_index, excel_thousands, python_logging, unix_us_kgf,
    mixed_unit_texts, english_thousands, hex_counts, scalar_first, torque_first_nmm, python_dicts,
    gravity_by_accelerometer, loads_across, matlab_workspace, silent_weights,
)  # fmt: skip
