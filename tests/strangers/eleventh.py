"""Logs as laboratories keep them, VII: monitors, spreadsheets, plates, insoles and sensor makers.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.io import savemat

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    filled,
    rows,
    settling,
    steps,
    tool_truth,
    truth_of,
    wrist,
    write,
)


def serial_monitor_stamps(to: Path, rng: Rng) -> Made:
    """Arduino IDE's monitor with time stamps in front of each line."""
    one, lines = cell(rng), ["10:02:30.001 -> HX711 calibration sketch"]
    for i, g in enumerate(steps((0, 250, 500, 1000), 12)):
        raw = float(one.read(np.asarray(g * 1e-3 * G), rng))
        lines.append(f"10:02:{31 + i // 10:02d}.{100 * (i % 10):03d} -> load: {g:.0f} g\traw: "
                     f"{raw:.0f}")  # fmt: skip
    return Made([write(to / "monitor.txt", lines)], truth_of(one, 10))


def excel_quoted_thousands(to: Path, rng: Rng) -> Made:
    """Excel: `"1,000"` grams and `"8,223,570"` in quotes, US dates."""
    one, grams = cell(rng), steps((0, 500, 1000, 2000), 5)
    body = ["Date,Mass (g),ADC Count"]
    for i, (g, c) in enumerate(zip(grams, one.read(grams * 1e-3 * G, rng), strict=True)):
        body.append(f'3/12/2024 10:{i:02d},"{g:,.0f}","{c:,.0f}"')
    return Made([write(to / "Calibration.csv", body, end="\r\n")], truth_of(one))


def german_thousands(to: Path, rng: Rng) -> Made:
    """`1.234,56`: points between thousands and decimal commas, newtons and counts."""
    one, newton = Cell(0.5, -120.0, 0.5), steps((0, 250, 1250.5, 2500.25), 6)
    body = ["Kraft [N];Messwert"]
    for f, c in zip(newton, one.read(newton, rng, whole=False), strict=True):
        text = [f"{v:,.2f}".translate(str.maketrans(",.", ".,")) for v in (f, c)]
        body.append(";".join(text))
    return Made([write(to / "presse.csv", body, "cp1252")], truth_of(one, 2500))


def futek_sensit(to: Path, rng: Rng) -> Made:
    """FUTEK's SENSIT: a file for each weight, the unit in a column, a head of settings."""
    one, paths = Cell(1.03, -0.8, 0.01), []
    for lb in (0, 5, 10, 20):
        head = ["Device,USB220", "Serial,402311", "Sampling Rate,10", "",
                "Sample Number,Elapsed Time (s),Tracking Value,Units"]  # fmt: skip
        read = one.read(np.full(30, lb * 4.4482216152605), rng, whole=False)
        body = [f"{i + 1},{i / 10:.1f},{v:.4f},N" for i, v in enumerate(read)]
        paths.append(write(to / f"FUTEK_{lb}lb.csv", [*head, *body]))
    return Made(paths, truth_of(one, 90))


def mark10_gauge(to: Path, rng: Rng) -> Made:
    """Mark-10 IntelliMESUR: load in lbF and travel in inches beside a bridge in mV/V."""
    one, load = Cell(90.0, -4.0, 4e-4), settling([0, 40, 80, 160, 80, 0], 3, 20)
    head = ["MESURgauge Plus", "Test,Cell 4", "", "Time [sec],Load [lbF],Travel [in],Bridge [mV/V]"]
    body = rows(np.arange(load.size) / 20, (load + rng.normal(0, 0.03, load.size)) / 4.4482216,
                load / 5e3, one.read(load, rng, whole=False), form="%.5f")  # fmt: skip
    return Made([write(to / "run1.csv", [*head, *body])], truth_of(one, 160))


def matlab_displayed(to: Path, rng: Rng) -> Made:
    """A table as MATLAB displays it: a rule under the names, blanks between."""
    one, kg = cell(rng), steps((0, 1, 2, 5), 4)
    lines = ["calib =", "", "  16×2 table", "", "    mass_kg        raw    ",
             "    _______    __________", ""]  # fmt: skip
    lines += [f"      {k:<10g}{c:.0f}" for k, c in zip(kg, one.read(kg * G, rng), strict=True)]
    return Made([write(to / "diary.txt", lines)], truth_of(one))


def excel_serial_dates(to: Path, rng: Rng) -> Made:
    """Dates as the numbers of Excel, dense in time."""
    one, newton = cell(rng, "adc12"), settling([0, 10, 20, 50, 0], 4, 10)
    days = 45363.4187 + np.arange(newton.size) / 864_000
    body = rows(days, newton, one.read(newton, rng), form="%.10f")
    return Made([write(to / "log.csv", ["Timestamp,Reference (N),ADC", *body])], truth_of(one, 50))


def sentences(to: Path, rng: Rng) -> Made:
    """A notebook in sentences: `now 2.5 kg on the cell`, then readings alone."""
    one, lines = cell(rng), ["# bench notes, cell 7"]
    for k in (0, 1, 2.5, 5):
        lines.append(f"now {k:g} kg on the cell")
        lines += [f"{c:.0f}" for c in one.read(np.full(15, k * G), rng)]
    return Made([write(to / "notes.txt", lines)], truth_of(one, 50))


def simulink_structure(to: Path, rng: Rng) -> Made:
    """Simulink's To Workspace, structure with time: values without names; the unit is asked for."""
    one, newton = cell(rng, "adc12"), settling([0, 5, 10, 20, 0], 4, 20)
    values = np.column_stack([newton, one.read(newton, rng)])
    signals = {
        "values": values,
        "dimensions": 2.0,
        "label": "load, raw",
        "blockName": "bench/Scope",
    }
    path = to / "simout.mat"
    savemat(path, {"simout": {"time": np.arange(newton.size)[:, None] / 20, "signals": signals}})
    return Made([path], truth_of(one, 20), says="unit of the load",
                fill=lambda text: text.replace('unit = "?"', 'unit = "N"'))  # fmt: skip


def echo_csv_of_two_topics(to: Path, rng: Rng) -> Made:
    """`ros2 topic echo --csv` of a wrench and of a pose, neither with names."""
    made, wrench, rot = wrist(rng)
    stamps = [f"{1700000000 + i // 100},{10_000_000 * (i % 100)}" for i in range(len(wrench))]
    ft = [f"{s},ft_frame," + ",".join(f"{v:.6f}" for v in w)
          for s, w in zip(stamps, wrench, strict=True)]  # fmt: skip
    pose = [f"{s},base_link,0.4,0.1,0.5," + ",".join(f"{v:.6f}" for v in q)
            for s, q in zip(stamps, rot.as_quat(), strict=True)]  # fmt: skip
    return Made([write(to / "wrench.csv", ft), write(to / "pose.csv", pose)], tool_truth(made))


def plotjuggler_tf(to: Path, rng: Rng) -> Made:
    """PlotJuggler: a wrench and the rotation of tf in one table, all rows filled."""
    made, wrench, rot = wrist(rng)
    names = ["__time", *(f"/ft_sensor/wrench/{k}/{a}" for k in ("force", "torque") for a in "xyz"),
             *(f"/tf/base_link/tool0/translation/{a}" for a in "xyz"),
             *(f"/tf/base_link/tool0/rotation/{a}" for a in "xyzw")]  # fmt: skip
    place = np.tile([0.4, 0.1, 0.5], (len(wrench), 1)).T
    body = rows(1.7e9 + np.arange(len(wrench)) / 100, *wrench.T, *place, *rot.as_quat().T,
                form="%.6f")  # fmt: skip
    return Made([write(to / "pj.csv", [",".join(names), *body])], tool_truth(made))


def bota_rokubi(to: Path, rng: Rng) -> Made:
    """Bota's console: microseconds, status, wrench, its own accelerometer in g, temperature."""
    made, wrench, rot = wrist(rng)
    felt = rot.as_matrix()[:, 2, :] + rng.normal(0, 0.002, (len(wrench), 3))
    head = ("timestamp[us],status,Fx[N],Fy[N],Fz[N],Mx[Nm],My[Nm],Mz[Nm],"
            "acc_x[g],acc_y[g],acc_z[g],temperature[°C]")  # fmt: skip
    body = rows(1e6 + 10_000 * np.arange(len(wrench)), np.zeros(len(wrench)), *wrench.T, *felt.T,
                np.full(len(wrench), 31.5), form="%.6g")  # fmt: skip
    return Made([write(to / "bota.csv", [head, *body])], tool_truth(made))


def poses_in_a_sheet(to: Path, rng: Rng) -> Made:
    """An ATI sensor's log with the number of the pose, and a sheet of poses with quaternions."""
    made, wrench, rot = wrist(rng)
    names = "pose,Fx,Fy,Fz,Tx,Ty,Tz"
    log = rows(np.repeat(np.arange(1, 13), 25), *wrench.T, form="%.6g")
    sheet = rows(np.arange(1, 13), *rot.as_quat()[::25].T, form="%.6g")
    paths = [write(to / "ati.csv", [names, *log]),
             write(to / "poses.csv", ["pose,qx,qy,qz,qw", *sheet])]  # fmt: skip
    return Made(paths, tool_truth(made))


def _plates(gain: tuple[float, float], names: tuple[str, str]) -> Truth:
    cells = {f"{n}_p{i}.scale": g for n, g in zip(names, gain, strict=True) for i in (1, 2, 3)}
    return Truth(cells, dict.fromkeys(cells, 0.1))


def kistler_bioware(to: Path, rng: Rng) -> Made:
    """BioWare's text: settings, names and units; one plate, force, moments, Ax and Ay in m."""
    n, mass, gain = 600, 74.0, 1.05
    fz = mass * G / gain + rng.normal(0, 1, n)
    cop = rng.normal(0.02, 0.004, (2, n))
    head = ["BioWare Version:\t5.3.2.9", "Sampling rate\t100 Hz", "Plate\t9286B", "",
            "abs time (s)\tFx\tFy\tFz\tMx\tMy\tMz\tAx\tAy",
            "s\tN\tN\tN\tN·m\tN·m\tN·m\tm\tm"]  # fmt: skip
    body = rows(np.arange(n) / 100, *rng.normal(0, 1, (2, n)), fz, cop[1] * fz, -cop[0] * fz,
                rng.normal(0, 0.1, n), *cop, sep="\t", form="%.6f")  # fmt: skip
    found = {f"plate_1_p{i}.scale": gain for i in (1, 2, 3)}
    return Made([write(to / "stand.txt", [*head, *body], "latin-1")],
                Truth(found, dict.fromkeys(found, 0.1)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def amti_netforce(to: Path, rng: Rng) -> Made:
    """AMTI: two plates side by side, six axes each, named by number; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 70.0, (1.05, 0.96)
    names, data = ["Frame"], [np.arange(1.0, n + 1)]
    for k, (part, g) in enumerate(zip((share, 1 - share), gain, strict=True), 1):
        names += [f"{a}{k}" for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
        data += [*rng.normal(0, 1, (2, n)), part * mass * G / g + rng.normal(0, 1, n),
                 *rng.normal(0, 2, (3, n))]  # fmt: skip
    found = {f"{k}_plate.scale": g for k, g in zip("12", gain, strict=True)}
    return Made([write(to / "amti.csv", [",".join(names), *rows(*data, form="%.4f")])],
                Truth(found, dict.fromkeys(found, 0.02)), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def bertec_treadmill(to: Path, rng: Rng) -> Made:
    """Bertec: left and right halves, force, moment and CoP, units in brackets; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 77.0, (1.04, 0.96)
    names, data = ["Time (s)"], [np.arange(n) / 50]
    for side, part, g in zip("LR", (share, 1 - share), gain, strict=True):
        names += [f"{side} Fx (N)", f"{side} Fy (N)", f"{side} Fz (N)", f"{side} Mx (N.m)",
                  f"{side} My (N.m)", f"{side} Mz (N.m)", f"{side} COPx (m)",
                  f"{side} COPy (m)"]  # fmt: skip
        fz, cop = part * mass * G / g + rng.normal(0, 1, n), rng.normal(0, 0.004, (2, n))
        data += [*rng.normal(0, 1, (2, n)), fz, cop[1] * fz, -cop[0] * fz, np.zeros(n), *cop]
    return Made([write(to / "bertec.csv", [",".join(names), *rows(*data, form="%.6f")])],
                _plates(gain, ("left", "right")), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def moticon_opengo(to: Path, rng: Rng) -> Made:
    """Moticon: comments above, total force per foot, CoP as a share of the sole; mass asked."""
    n = 400
    names = ["time[ms]"]
    data = [10.0 * np.arange(n)]
    for side in ("left", "right"):
        names += [*(f"{side} pressure {i}[N/cm²]" for i in range(1, 4)), f"{side} total force[N]",
                  f"{side} center of pressure X[-0.5...+0.5]",
                  f"{side} center of pressure Y[-0.5...+0.5]"]  # fmt: skip
        data += [*rng.normal(4, 0.1, (3, n)), rng.normal(340, 2, n), *rng.normal(0, 0.05, (2, n))]
    head = ["# Generated by OpenGo 3.10", "# Name: Walk 3", "# Duration: 4 s"]
    return Made([write(to / "moticon.txt", [*head, "# " + "\t".join(names),
                                            *rows(*data, sep="\t", form="%.4f")])],
                says="weigh")  # fmt: skip


def tekscan_fscan(to: Path, rng: Rng) -> Made:
    """F-Scan: force in kg and the centre of force in cm for both feet; mass to fill in."""
    share = settling([0.3, 0.5, 0.7, 0.4, 0.6, 0.5], 5, 50)
    n, mass, gain = share.size, 82.0, (1.05, 0.95)
    head = ["F-SCAN 7.00", "FILENAME,walk1.fsx", "SECONDS_PER_FRAME,0.02", "UNITS,kg", "",
            "Frame,Time (s),Left Force (kg),Left COF X (cm),Left COF Y (cm),Right Force (kg),"
            "Right COF X (cm),Right COF Y (cm)"]  # fmt: skip
    data = [np.arange(1, n + 1), np.arange(n) / 50]
    for part, g in zip((share, 1 - share), gain, strict=True):
        data += [part * mass / g + rng.normal(0, 0.1, n), rng.normal(4.5, 0.2, n),
                 rng.normal(12, 0.3, n)]  # fmt: skip
    return Made([write(to / "walk1.csv", [*head, *rows(*data, form="%.3f")])],
                _plates(gain, ("left", "right")), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def unitree_printed(to: Path, rng: Rng) -> Made:
    """A loop that prints: `t=12.345 foot_force=[31, 33, 29, 35]`; mass to fill in."""
    lines = [f"t={i / 50:.3f} foot_force=[{', '.join(f'{v:.0f}' for v in rng.normal(32, 2, 4))}]"
             for i in range(300)]  # fmt: skip
    return Made([write(to / "go1.log", lines)], says="weigh")


def row_per_cell_with_places(to: Path, rng: Rng) -> Made:
    """A row for each cell of an insole with its place and its force; mass to fill in."""
    lines = ["sample,foot,cell,x_mm,y_mm,force_N"]
    cells = {"heel": (-80, 0), "medial": (60, 25), "lateral": (50, -25)}
    for i in range(200):
        for foot in ("L", "R"):
            for name, (x, y) in cells.items():
                lines.append(f"{i},{foot},{name},{x},{y},{rng.normal(110, 2):.2f}")
    return Made([write(to / "insole.csv", lines)], says="weigh")


def feet_one_after_the_other(to: Path, rng: Rng) -> Made:
    """A bus that reads the left foot and 4 ms later the right, a row each; mass to fill in."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    mass, gain, lines = 69.0, (1.05, 0.95), ["t_us;side;Fz;copx_mm;copy_mm"]
    for i, s in enumerate(share):
        for k, (side, part, g) in enumerate(zip("LR", (s, 1 - s), gain, strict=True)):
            x, y = rng.normal(20, 2, 2)
            fz = part * mass * G / g + rng.normal(0, 1)
            lines.append(f"{20_000 * i + 4_000 * k};{side};{fz:.3f};{x:.2f};{y:.2f}")
    return Made([write(to / "bus.csv", lines)], _plates(gain, ("left", "right")), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


ELEVENTH = (
    serial_monitor_stamps, excel_quoted_thousands, german_thousands, futek_sensit, mark10_gauge,
    matlab_displayed, excel_serial_dates, sentences, simulink_structure, echo_csv_of_two_topics,
    plotjuggler_tf, bota_rokubi, poses_in_a_sheet, kistler_bioware, amti_netforce,
    bertec_treadmill, moticon_opengo, tekscan_fscan, unitree_printed, row_per_cell_with_places,
    feet_one_after_the_other,
)  # fmt: skip
