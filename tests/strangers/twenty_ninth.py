"""Logs whose loads, attitudes or names stand elsewhere: protocols, registers, series, events.

Written before the mends that they led to, here with other numbers; `docs/bring_your_log.md` has
their first count.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from tests.strangers.legged import _hung
from tests.strangers.rigs import (
    Array,
    Cell,
    G,
    Made,
    Rng,
    Truth,
    cell,
    filled,
    on_two_plates,
    rows,
    tool_truth,
    truth_of,
    wrist,
    write,
)

_BEGIN = datetime(2026, 3, 4, 10, 2, 11)
_CELLS = ("FL", "FR", "RL", "RR")


def _clock(seconds: float, form: str = "%H:%M:%S.%f") -> str:
    text = (_BEGIN + timedelta(seconds=float(seconds))).strftime(form)
    return text[:-3] if form.endswith("%f") else text


def _four(rng: Rng) -> dict[str, Cell]:
    return {name: cell(rng) for name in _CELLS}


def _on_one(cells: dict[str, Cell], on: str, kg: float, rng: Rng) -> list[float]:
    """What all cells read while a weight lies on one of them."""
    return [float(c.read(np.array(kg * G * (n == on)), rng)) for n, c in cells.items()]


def monitor_and_protocol(to: Path, rng: Rng) -> Made:
    """A serial monitor without names, and who put what where when, noted a second too early."""
    cells, lines, noted, t = _four(rng), [], ["time,cell,weight_g"], 0.0
    for name in cells:
        for kg in (0.0, 0.5, 1.0, 2.0, 0.0):
            noted.append(f"{_clock(t + 1, '%H:%M:%S')},{name},{1000 * kg:g}")
            for i in range(60):
                read = _on_one(cells, name, 0.0 if i < 13 else kg, rng)
                lines.append(f"{_clock(t)} -> " + ",".join(f"{v:.0f}" for v in read))
                t += 0.1
    paths = [write(to / "serial.txt", lines), write(to / "protocol.csv", noted)]
    return Made(paths, truth_of(cells))


def numbered_scans(to: Path, rng: Rng) -> Made:
    """A logger's scans, and a sheet that says from which scan to which a weight lay on a cell."""
    cells, lines, noted = _four(rng), [",".join(["Scan", *_CELLS])], ["from_no,to_no,cell,load_kg"]
    for name in cells:
        for kg in (0, 1, 2, 5):
            first = len(lines)
            for i in range(20):
                read = _on_one(cells, name, kg if i > 3 else 0, rng)
                lines.append(",".join(f"{v:.0f}" for v in [float(len(lines)), *read]))
            noted.append(f"{first + 5},{first + 18},{name},{kg}")
    paths = [write(to / "scans.csv", lines), write(to / "loads.csv", noted)]
    return Made(paths, truth_of(cells, 50))


def smart_home(to: Path, rng: Rng) -> Made:
    """Home Assistant: a row when something changed; the load far rarer than the cell."""
    one, said, read, t = cell(rng), [], [], 0.0
    for g in (0, 500, 1000, 2000, 1000, 0):
        said.append(f"input_number.test_weight_g,{g:.1f},{_clock(t, '%Y-%m-%dT%H:%M:%S')}.137Z")
        for i in range(11):
            t += 5
            value = one.read(np.array(g / 1000 * G), rng)
            state = "unavailable" if g == 2000 and i == 4 else f"{value:.0f}"
            read.append(f"sensor.hx711_raw,{state},{_clock(t, '%Y-%m-%dT%H:%M:%S')}.418Z")
        t += 5
    lines = ["entity_id,state,last_changed", *said, *read]
    return Made([write(to / "history.csv", lines)], truth_of(one))


def flux_tables(to: Path, rng: Rng) -> Made:
    """Flux's annotated CSV: a table for each series, its annotations and its header above it."""
    cells, lines = {"fl": cell(rng), "fr": cell(rng)}, []
    for i, (name, one) in enumerate(cells.items()):
        lines += ["#group,false,false,true,false,false,false,true",
                  "#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,double,long,string",
                  "#default,mean,,,,,,", ",result,table,_start,_time,load_kg,raw,cell"]  # fmt: skip
        for k, kg in enumerate(np.repeat([0.0, 1, 2, 5, 1], 8)):
            stamp = _clock(2 * k + 200 * i, "%Y-%m-%dT%H:%M:%SZ")
            read = one.read(np.array(kg * G), rng)
            lines.append(f",,{i},2026-03-04T09:00:00Z,{stamp},{kg:g},{read:.0f},{name}")
        lines.append("")
    return Made([write(to / "query.csv", lines, end="\r\n")], truth_of(cells, 50))


def legs_and_imu(to: Path, rng: Rng) -> Made:
    """`rostopic echo -p`: a wrench for each hip in a file of its own, an IMU in another."""
    wrenches, t, body, truth = _hung(rng, ("fl", "ml", "hl", "fr", "mr", "hr"))
    head = "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
    axes = [f"field.wrench.{k}.{a}" for k in ("force", "torque") for a in "xyz"]
    paths = []
    for name, wrench in wrenches.items():
        lines = [head + ",".join(axes)]
        for i, (s, row) in enumerate(zip(t + rng.uniform(0, 0.004), wrench, strict=True)):
            ns = round(1e9 * s) + 1_772_600_000_000_000_000
            lines.append(f"{ns},{i},{ns},{name}_ft," + ",".join(f"{v:.6f}" for v in row))
        paths.append(write(to / f"{name}_hip_wrench.csv", lines))
    named = [f"field.orientation.{a}" for a in "xyzw"]
    lines = [head + ",".join([*named, *(f"field.orientation_covariance{i}" for i in range(9))])]
    for i, (s, q) in enumerate(zip(t, body.as_quat(), strict=True)):
        ns = round(1e9 * s) + 1_772_600_000_000_000_000
        lines.append(f"{ns},{i},{ns},imu," + ",".join(f"{v:.6f}" for v in [*q, *[0.0] * 9]))
    return Made([*paths, write(to / "imu_data.csv", lines)], truth)


def registers_of_a_master(to: Path, rng: Rng) -> Made:
    """modpoll: `[101]: value` for each cell and poll; a file for each cell and weight."""
    cells, paths = _four(rng), []
    for name in cells:
        for g in (0, 500, 1000, 2000):
            lines = ["modpoll 3.10 - FieldTalk(tm) Modbus(R) Master Simulator", ""]
            for _ in range(8):
                read = _on_one(cells, name, g / 1000, rng)
                lines += ["-- Polling slave 1... (Ctrl-C to stop)",
                          *(f"[{101 + 2 * i}]: {v:.0f}" for i, v in enumerate(read))]  # fmt: skip
            paths.append(write(to / f"{name.lower()}_{g}g.txt", lines))
    return Made(paths, truth_of({n.lower(): c for n, c in cells.items()}))


def folders_of_channels(to: Path, rng: Rng) -> Made:
    """A logic analyser: all channels in each file, the loaded one and the weight in its folder."""
    cells, paths = {str(i): cell(rng, "volt") for i in range(4)}, []
    for name in cells:
        for kg in (0, 1, 2, 5):
            load = np.full(40, kg * G)
            read = [c.read(load * (n == name), rng, whole=False) for n, c in cells.items()]
            folder = to / f"ch{name}_{kg}kg"
            folder.mkdir()
            head = "Time [s]," + ",".join(f"Channel {n}" for n in cells)
            lines = [head, *rows(np.arange(40) / 500, *read)]
            paths.append(write(folder / "analog.csv", lines))
    return Made(paths, truth_of(cells, 50))


def kuka_degrees(to: Path, rng: Rng) -> Made:
    """A, B and C with a sign of degrees: about z, y and x."""
    made, wrenches, body = wrist(rng)
    head = "Zeit [ms];A [°];B [°];C [°];" + ";".join(
        f"{k} {a} [{u}]" for k, u in (("Kraft", "N"), ("Moment", "Nm")) for a in "XYZ"
    )
    angles = body.as_euler("ZYX", degrees=True)
    lines = rows(12.0 * np.arange(len(angles)), *angles.T, *wrenches.T, sep=";", form="%.4f")
    lines = [head, *(x.replace(".", ",") for x in lines)]
    return Made([write(to / "trace.csv", lines, "cp1252")], tool_truth(made))


def plates_that_point_down(to: Path, rng: Rng) -> Made:
    """Two plates that report what stands on them: negative, above a second section."""
    mass, gain = 64.0, (1.04, 0.97)
    fz: Array = -on_two_plates(mass, gain, rng)
    other = rng.normal(0, 0.5, (4, fz.shape[1]))
    names = [f"{a}{i}" for i in (1, 2) for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    each = [np.vstack([other[:2], z[None], other[2:], other[:1]]) for z in fz]
    lines = [",".join(["Frame", *names]), ",".join(["", *["N", "N", "N", "Nm", "Nm", "Nm"] * 2])]
    lines += rows(np.arange(1.0, fz.shape[1] + 1), *np.vstack(each), form="%.5g")
    lines += ["", "Trajectories", "100", "Frame,X,Y,Z", *rows(np.arange(1.0, 50), *other[:3, :49])]
    values = {f"{i}_plate.scale": g for i, g in zip("12", gain, strict=True)}
    truth = Truth(values, dict.fromkeys(values, 0.1))
    return Made([write(to / "trial.csv", lines)], truth, "weighs", fill=filled(mass_kg=f"{mass}"))


TWENTY_NINTH = (
    monitor_and_protocol, numbered_scans, smart_home, flux_tables, legs_and_imu,
    registers_of_a_master, folders_of_channels, kuka_degrees, plates_that_point_down,
)  # fmt: skip
