"""Wrists, plates and feet with what their users add to them, each with its truth.

Written before it was run; `docs/bring_your_log.md` has its first count.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import (
    Array,
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

_FT = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
_NS = 1_710_237_600_000_000_000


def _once(rot: Rotation, hold: int) -> Rotation:
    """One attitude for each hold."""
    return rot[np.arange(0, len(rot), hold)]


def _spots() -> tuple[Array, Array]:
    """Marks on a plate in mm, three presses on each: what was meant (n, 2)."""
    x, y = (v.ravel() for v in np.meshgrid((-150.0, 0.0, 150.0), (-200.0, 0.0, 200.0)))
    marks = np.repeat(np.column_stack([x, y]), 3, axis=0)
    return marks, marks * [1.02, 0.99] + [2.0, -3.0]


def netft_counts_unsaid(to: Path, rng: Rng) -> Made:
    """Net F/T's RDT records in counts; how many make a newton stands nowhere."""
    _, wrench, rot = wrist(rng)
    counts = np.round(wrench * 1e6)
    lines = ["rdt_sequence,ft_sequence,status,Fx,Fy,Fz,Tx,Ty,Tz,qx,qy,qz,qw"]
    lines += [f"{i + 1},{70000 + 7 * i},0,{body}"
              for i, body in enumerate(rows(*counts.T, *rot.as_quat().T))]  # fmt: skip
    return Made([write(to / "rdt.csv", lines)], says="counts")


def one_matrix_per_hold(to: Path, rng: Rng) -> Made:
    """A stream of wrenches, and nine numbers for each hold in the order of the holds."""
    _, wrench, rot = wrist(rng, 12, 40)
    lines = [",".join(["t", *_FT]), *rows(np.arange(480) / 20, *wrench.T, form="%.5f")]
    turns = [",".join(f"R{i}{j}" for i in "123" for j in "123"),
             *rows(*_once(rot, 40).as_matrix().reshape(-1, 9).T, form="%.6f")]  # fmt: skip
    return Made([write(to / "ft.csv", lines), write(to / "R.csv", turns)], says="numbers of holds")


def angles_per_hold(to: Path, rng: Rng) -> Made:
    """Holds by number in the log, roll, pitch and yaw in degrees of each in a table."""
    made, wrench, rot = wrist(rng, 12, 30)
    lines = [",".join(["hold", *_FT])]
    lines += [f"{1 + i // 30},{x}" for i, x in enumerate(rows(*wrench.T, form="%.5f"))]
    turns = ["hold;roll [°];pitch [°];yaw [°]"]
    turns += [f"{i + 1};{x}" for i, x in enumerate(
        rows(*_once(rot, 30).as_euler("xyz", degrees=True).T, sep=";", form="%.3f"))]  # fmt: skip
    return Made([write(to / "hang.csv", lines), write(to / "poses.csv", turns)], tool_truth(made))


def file_per_hold_and_angles(to: Path, rng: Rng) -> Made:
    """A file for each hold, the number in its name; the angles in a table of its own."""
    made, wrench, rot = wrist(rng, 10, 30)
    paths = []
    for i in range(10):
        body = rows(np.arange(30) / 100, *wrench[30 * i : 30 * (i + 1)].T, form="%.5f")
        paths.append(write(to / f"hold_{i + 1:02d}.csv", [",".join(["t", *_FT]), *body]))
    turns = ["hold,roll_deg,pitch_deg,yaw_deg"]
    turns += [f"{i + 1},{x}" for i, x in enumerate(
        rows(*_once(rot, 30).as_euler("xyz", degrees=True).T, form="%.3f"))]  # fmt: skip
    return Made([*paths, write(to / "angles.csv", turns)], tool_truth(made))


def matrix_in_one_cell(to: Path, rng: Rng) -> Made:
    """A rotation matrix as one text, `[[…], […], […]]`, beside the wrench."""
    made, wrench, rot = wrist(rng)
    lines = [",".join(["stamp", *_FT, "R"])]
    for i, (body, r) in enumerate(zip(rows(*wrench.T, form="%.5f"), rot.as_matrix(), strict=True)):
        lines.append(f'{0.02 * i:.2f},{body},"{r.round(6).tolist()}"')
    return Made([write(to / "log.csv", lines)], tool_truth(made))


def mangled_by_pandas(to: Path, rng: Rng) -> Made:
    """Force, torque and quaternion all called x, y, z; pandas numbered them."""
    made, wrench, rot = wrist(rng)
    lines = ["time,x,y,z,x.1,y.1,z.1,x.2,y.2,z.2,w"]
    lines += rows(np.arange(len(wrench)) / 50, *wrench.T, *rot.as_quat().T, form="%.6f")
    return Made([write(to / "merged.csv", lines)], tool_truth(made))


def scalar_in_front_unsaid(to: Path, rng: Rng) -> Made:
    """A quaternion called q0 … q3 in one file, a wrench in another, stamps in nanoseconds."""
    made, wrench, rot = wrist(rng, 14, 25)
    quat = rot.as_quat()[:, [3, 0, 1, 2]]
    wrenches, turns = ["stamp_ns," + ",".join(_FT)], ["stamp_ns,q0,q1,q2,q3"]
    wrenches += [f"{_NS + 20_000_000 * i},{x}" for i, x in enumerate(rows(*wrench.T, form="%.5f"))]
    turns += [f"{_NS + 3_000_000 + 20_000_000 * i},{x}"
              for i, x in enumerate(rows(*quat.T, form="%.6f"))]  # fmt: skip
    return Made([write(to / "wrench.csv", wrenches), write(to / "arm.csv", turns)],
                tool_truth(made))  # fmt: skip


def foxglove_wide(to: Path, rng: Rng) -> Made:
    """Foxglove's table: elapsed, receive time, `/ft.wrench.force.x`, an empty column at the end."""
    made, wrench, rot = wrist(rng)
    names = ["elapsed", "receive_time", *(f"/ft.wrench.{k}.{a}" for k in ("force", "torque")
                                          for a in "xyz"),
             *(f"/tcp.pose.orientation.{a}" for a in "xyzw"), ""]  # fmt: skip
    lines = [",".join(names)]
    lines += [f"{0.02 * i:.2f},{1710237600 + 0.02 * i:.2f},{x}," for i, x in enumerate(
        rows(*wrench.T, *rot.as_quat().T, form="%.6f"))]  # fmt: skip
    return Made([write(to / "foxglove.csv", lines)], tool_truth(made))


def influx_wrench_lines(to: Path, rng: Rng) -> Made:
    """Line protocol with a wrench and angles as fields, a tag with a comma in it escaped."""
    made, wrench, rot = wrist(rng)
    turned = rot.as_euler("xyz", degrees=True)
    lines = []
    for i, (w, e) in enumerate(zip(wrench, turned, strict=True)):
        fields = [f"{n.lower()}={v:.5f}" for n, v in zip(_FT, w, strict=True)]
        fields += [f"{n}_deg={v:.4f}" for n, v in zip(("roll", "pitch", "yaw"), e, strict=True)]
        lines.append(f"ft,arm=left\\,upper {','.join(fields)} {_NS + 20_000_000 * i}")
    return Made([write(to / "ft.lp", lines)], tool_truth(made))


def over_range_in_words(to: Path, rng: Rng) -> Made:
    """A driver that writes ``OVL`` over its range: the arm was bumped between two holds."""
    made, wrench, rot = wrist(rng)
    body = rows(*wrench.T, *rot.as_euler("xyz", degrees=True).T, form="%.4f")
    body[60:63] = ["OVL,OVL,OVL,OVL,OVL,OVL," + x.split(",", 6)[6] for x in body[60:63]]
    lines = [",".join([*_FT, "rx_deg", "ry_deg", "rz_deg"]), *body]
    return Made([write(to / "arm.csv", lines)], tool_truth(made))


def german_wrist(to: Path, rng: Rng) -> Made:
    """A German log of a wrist: Kräfte, Momente in Ncm, Euler angles with a comma."""
    made, wrench, rot = wrist(rng)
    turned = rot.as_euler("xyz", degrees=True)
    lines = ["Zeit [s];Kraft X [N];Kraft Y [N];Kraft Z [N];Moment X [Ncm];Moment Y [Ncm];"
             "Moment Z [Ncm];Rollen [°];Nicken [°];Gieren [°]"]  # fmt: skip
    body = rows(np.arange(len(wrench)) / 50, *(wrench * np.repeat([1.0, 100.0], 3)).T, *turned.T,
                sep=";", form="%.5f")  # fmt: skip
    lines += [x.replace(".", ",") for x in body]
    return Made([write(to / "Handgelenk.csv", lines, "latin-1")], tool_truth(made))


def attitude_frozen(to: Path, rng: Rng) -> Made:
    """A tracker that lost the tool: the last third of the attitudes is one number repeated."""
    _, wrench, rot = wrist(rng, 15, 30)
    quat = rot.as_quat()
    quat[300:] = quat[299]
    lines = [",".join(["t", *_FT, "qx", "qy", "qz", "qw"]),
             *rows(np.arange(450) / 50, *wrench.T, *quat.T, form="%.5f")]  # fmt: skip
    return Made([write(to / "lost.csv", lines)], says="hang-calib")


def joints_alone(to: Path, rng: Rng) -> Made:
    """An arm's joint angles and a wrench: an attitude needs the arm's geometry."""
    _, wrench, _ = wrist(rng)
    joints = np.repeat(rng.uniform(-2, 2, (12, 6)), 25, axis=0)
    names = ["t", *(f"q_actual_{i}" for i in range(6)), *_FT]
    lines = [",".join(names), *rows(np.arange(300) / 50, *joints.T, *wrench.T, form="%.5f")]
    return Made([write(to / "ur.csv", lines)], says="attitude")


def plate_moments_at_points(to: Path, rng: Rng) -> Made:
    """Kistler: a rod on known marks, six columns, forces down the plate's own axis."""
    marks, at = _spots()
    lines = ["# plate 9286, zeroed before", "X_ref [mm]\tY_ref [mm]\tFx\tFy\tFz\tMx\tMy\tMz",
             "mm\tmm\tN\tN\tN\tNm\tNm\tNm"]  # fmt: skip
    for (x, y), (u, v) in zip(marks, at + rng.normal(0, 0.2, at.shape), strict=True):
        fz = rng.normal(400, 5)
        body = [rng.normal(0, 0.2), rng.normal(0, 0.2), fz, fz * v * 1e-3, -fz * u * 1e-3,
                rng.normal(0, 0.05)]  # fmt: skip
        lines.append("\t".join(f"{k:.4f}" for k in (x, y, *body)))
    return Made([write(to / "spots.tsv", lines)], cop_within_m=1.5e-3)


def plate_moments_three_columns(to: Path, rng: Rng) -> Made:
    """A plate that has only Fz, Mx and My, moments in N·mm, at marks in mm."""
    marks, at = _spots()
    lines = ["x_mm,y_mm,Fz [N],Mx [Nmm],My [Nmm]"]
    for (x, y), (u, v) in zip(marks, at + rng.normal(0, 0.2, at.shape), strict=True):
        fz = rng.normal(400, 5)
        lines.append(f"{x:g},{y:g},{fz:.2f},{fz * v:.2f},{-fz * u:.2f}")
    return Made([write(to / "plate.csv", lines)], cop_within_m=1.5e-3)


def _two_plates(rng: Rng, mass: float, gain: tuple[float, float]) -> tuple[Array, Array]:
    """Forces (n, 2) and centres of pressure (n, 2, 2) of a person who shifts weight."""
    share = settling([0.35, 0.55, 0.7, 0.4, 0.6, 0.5], 5, 50)
    parts = np.column_stack([share, 1 - share])
    return (parts * mass * G / np.array(gain) + rng.normal(0, 1, parts.shape),
            rng.normal(0, 0.004, (share.size, 2, 2)))  # fmt: skip


def _plate_truth(gain: tuple[float, float], names: tuple[str, str]) -> Truth:
    cells = {f"{n}_p{i}.scale": g for n, g in zip(names, gain, strict=True) for i in (1, 2, 3)}
    return Truth(cells, dict.fromkeys(cells, 0.1))


def treadmill_three_columns(to: Path, rng: Rng) -> Made:
    """A split belt that writes Fz, Mx and My of each side; the person's mass stands above."""
    mass, gain = 71.5, (1.04, 0.97)
    fz, cop = _two_plates(rng, mass, gain)
    data = [np.arange(len(fz)) / 50]
    for k in (0, 1):
        data += [fz[:, k], cop[:, k, 1] * fz[:, k], -cop[:, k, 0] * fz[:, k]]
    lines = ["Subject\tS01", f"Mass\t{mass} kg", "", "time [s]\tleft Fz [N]\tleft Mx [Nm]\t"
             "left My [Nm]\tright Fz [N]\tright Mx [Nm]\tright My [Nm]",
             *rows(*data, sep="\t", form="%.4f")]  # fmt: skip
    return Made([write(to / "belt.txt", lines)], _plate_truth(gain, ("left", "right")))


def c3d_two_plates(to: Path, rng: Rng) -> Made:
    """A C3D of two plates on which a person shifts; the mass is known to the person alone."""
    import ezc3d

    mass, gain = 68.0, (1.03, 0.98)
    fz, cop = _two_plates(rng, mass, gain)
    n = len(fz)
    made = ezc3d.c3d()
    made["parameters"]["POINT"]["RATE"]["value"] = [50.0]
    made["parameters"]["POINT"]["UNITS"]["value"] = ("mm",)
    made["parameters"]["ANALOG"]["RATE"]["value"] = [50.0]
    labels = [f"{a}{k}" for k in (1, 2) for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    made["parameters"]["ANALOG"]["LABELS"]["value"] = tuple(labels)
    made.add_parameter("ANALOG", "UNITS", ["N", "N", "N", "Nmm", "Nmm", "Nmm"] * 2)
    channels = []
    for k in (0, 1):
        u, v = 1e3 * cop[:, k].T
        channels += [rng.normal(0, 1, n), rng.normal(0, 1, n), fz[:, k], v * fz[:, k],
                     -u * fz[:, k], np.zeros(n)]  # fmt: skip
    made["data"]["analogs"] = -np.array([channels])
    corners = np.zeros((3, 4, 2))
    for k in (0, 1):
        corners[:2, :, k] = np.array([[200, -200, -200, 200], [300, 300, -300, -300]])
        corners[0, :, k] += 420 * k
    for name, value in (
        ("USED", [2]), ("TYPE", [2, 2]), ("ZERO", [1, 0]), ("CORNERS", corners),
        ("ORIGIN", np.zeros((3, 2))), ("CHANNEL", np.arange(1.0, 13.0).reshape(2, 6).T),
    ):  # fmt: skip
        made["parameters"]["FORCE_PLATFORM"][name]["value"] = value
    made["data"]["points"] = np.zeros((4, 0, n))
    path = to / "stand.c3d"
    made.write(str(path))
    return Made([path], _plate_truth(gain, ("plate_1", "plate_2")), says="weigh",
                fill=filled(mass_kg=f"{mass}"))  # fmt: skip


def kistler_corners(to: Path, rng: Rng) -> Made:
    """A Kistler plate's eight outputs: fx12 … fz4, a person stands; where cells sit is unsaid."""
    n = 400
    share = rng.dirichlet(np.full(4, 30.0), n)
    names = ["time", "fx12", "fx34", "fy14", "fy23", "fz1", "fz2", "fz3", "fz4"]
    data = [np.arange(n) / 100, *rng.normal(0, 1, (4, n)), *(700 * share).T]
    lines = [",".join(names), ",".join(["s", *["N"] * 8]), *rows(*data, form="%.4f")]
    return Made([write(to / "kistler8.csv", lines)], says="where the cells sit")


def amti_points_in_file_names(to: Path, rng: Rng) -> Made:
    """AMTI NetForce: a header block, a file for each mark, its place in the name."""
    paths = []
    for x in (-150, 0, 150):
        for y in (-200, 0, 200):
            u, v = 1.02 * x + 2, 0.99 * y - 3
            fz = rng.normal(400, 1, 50)
            data = [np.arange(50) / 50, *rng.normal(0, 0.1, (2, 50)), fz, fz * v * 1e-3,
                    -fz * u * 1e-3, rng.normal(0, 0.05, 50)]  # fmt: skip
            lines = ["AMTI NetForce", "Plate: BP400600", "Rate: 50 Hz", "",
                     "Time (s),Fx (N),Fy (N),Fz (N),Mx (N-m),My (N-m),Mz (N-m)",
                     *rows(*data, form="%.5f")]  # fmt: skip
            paths.append(write(to / f"spot_x{x}_y{y}.csv", lines))
    return Made(paths, cop_within_m=1.5e-3)


def insole_weights_listed(to: Path, rng: Rng) -> Made:
    """Pedar: a person with a known vest stands on one insole; loads as steps in a column."""
    one, kg = Cell(1.06, 4.0, 1.0), steps((0, 20, 40, 60, 80), 20)
    lines = ["file name:\tvest.fgt", "date/time\t12.03.24 10:00", "", "time[secs]\tforce[N]\t"
             "x[mm]\ty[mm]\tvest and plates [kg]"]  # fmt: skip
    read = one.read(kg * G, rng, whole=False)
    lines += rows(np.arange(kg.size) / 50, read, 40 + rng.normal(0, 1, kg.size),
                  120 + rng.normal(0, 1, kg.size), kg, sep="\t", form="%.3f")  # fmt: skip
    return Made([write(to / "vest.txt", lines)], truth_of(one, 800))


def feet_loaded_by_name(to: Path, rng: Rng) -> Made:
    """A hexapod's feet, all logged while weights hang on one; the file says on which."""
    names = ("L1", "L2", "L3", "R1", "R2", "R3")
    feet, paths = {n: cell(rng) for n in names}, []
    for n in names:
        kg = steps((0, 1, 2, 5), 10)
        data = [one.read(kg * G if m == n else np.zeros(kg.size), rng) for m, one in feet.items()]
        lines = [",".join(["load_kg", *names]), *rows(kg, *data)]
        paths.append(write(to / f"weights_on_{n}.csv", lines))
    truth = truth_of({n.lower(): one for n, one in feet.items()}, 50)
    return Made(paths, truth)


def mqtt_legs(to: Path, rng: Rng) -> Made:
    """MQTT: a topic for each leg with a wrench in JSON, one for the trunk's roll and pitch."""
    lines = []
    made, wrench, rot = wrist(rng, 14, 20)
    turned = rot.as_euler("xyz")
    for i, (w, e) in enumerate(zip(wrench, turned, strict=True)):
        at = 1710237600 + 0.05 * i
        felt = json.dumps(dict(zip([n.lower() for n in _FT], w.round(5).tolist(), strict=True)))
        angles = json.dumps(dict(zip(("roll", "pitch", "yaw"), e.round(6).tolist(), strict=True)))
        lines += [f"{at:.3f} dog/fl/wrench {felt}", f"{at + 0.001:.3f} dog/imu/rpy {angles}"]
    return Made([write(to / "mqtt.log", lines)], tool_truth(made))


TWENTY_FOURTH_ROBOTS = (
    netft_counts_unsaid, one_matrix_per_hold, angles_per_hold, file_per_hold_and_angles,
    matrix_in_one_cell, mangled_by_pandas, scalar_in_front_unsaid, foxglove_wide,
    influx_wrench_lines, over_range_in_words, german_wrist, attitude_frozen, joints_alone,
    plate_moments_at_points, plate_moments_three_columns, treadmill_three_columns, c3d_two_plates,
    kistler_corners, amti_points_in_file_names, insole_weights_listed, feet_loaded_by_name,
    mqtt_legs,
)  # fmt: skip
