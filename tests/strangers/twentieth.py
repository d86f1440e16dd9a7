"""Shapes of 45 more real logs of public repositories, with numbers of our own, by kind of mistake.

Columns that are worked out of others, clocks, places, and logs that hold no calibration at all.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Made,
    Rng,
    Truth,
    cell,
    filled,
    rows,
    settling,
    tool_truth,
    truth_of,
    wrist,
    write,
)


def samples_and_their_extremes(to: Path, rng: Rng) -> Made:
    """A tester's own calibration: mean, scatter, least and greatest count, and its prediction."""
    one = cell(rng, "adc12")
    newton = np.array([0, 4.8, 101.8, 207.2, 514.4, 1003.8, 1410.8, 1969.8, 2504.8])
    read = np.array([one.read(np.full(120, n), rng, whole=False) for n in newton])
    fit = np.polyfit(read.mean(axis=1), newton, 1)
    guess = np.polyval(fit, read.mean(axis=1))
    names = (
        "index,reference_force_n,raw_adc_mean,raw_adc_stddev,raw_adc_min,raw_adc_max,sample_count,"
        "duration_s,predicted_force_n,residual_force_n"
    )
    body = rows(
        np.arange(1, 10), newton, read.mean(axis=1), read.std(axis=1), read.min(axis=1),
        read.max(axis=1), np.full(9, 120), rng.normal(12.01, 0.01, 9), guess, guess - newton,
    )  # fmt: skip
    below = ["", "", f"constexpr float SlopeNPerCount = {fit[0]:.9f}f;"]
    return Made([write(to / "load-cell.csv", [names, *body, *below])], truth_of(one, 2500))


def scale_worked_out(to: Path, rng: Rng) -> Made:
    """What lay in the kitchen, and in the last column count by gram, to a tenth."""
    one = cell(rng, "hx_small")
    gram = np.array([0.0, 55, 184, 210, 310])
    read = one.read(gram * 9.80665e-3, rng)
    per = ["" if g == 0 else f"{r / g:.1f}" for g, r in zip(gram, read, strict=True)]
    names = ["nothing", "buds", "speaker", "phone", "bottle (300 ml)"]
    body = [f"{n},{g:g},{r:.0f},{p}" for n, g, r, p in zip(names, gram, read, per, strict=True)]
    head = "object,mass_g,raw_count,scale_factor_counts_per_g"
    return Made([write(to / "calibration.csv", [head, *body])], truth_of(one, 3))


def force_and_its_stress(to: Path, rng: Rng) -> Made:
    """A press: force, travel, and both again by area and by length; no reading at all."""
    travel = np.linspace(0, 2, 60) ** 1.2
    force = 3.1 * travel + rng.normal(0, 0.02, 60)
    body = rows(0.02 * np.arange(60), force, travel, force / 2.5, 10 * travel, form="%.8g")
    names = "Time (s),Load (N),Displacement (mm),Stress (MPa),Strain (%)"
    return Made([write(to / "friction.csv", [names, *body])], says="no reading next to it")


def millis_that_jitter(to: Path, rng: Rng) -> Made:
    """A scale's dump: a letter, the display, and milliseconds in steps of about 97."""
    one = cell(rng, "newton")
    newton = settling([0, 4.9, 9.8, 19.6], 5, 10.3)
    at = 43071 + np.cumsum(rng.integers(95, 100, newton.size))
    read = one.read(newton, rng, whole=False)
    body = [f"d,{v:.2f},{t}" for v, t in zip(read, at, strict=True)]
    return Made(
        [write(to / "dump.csv", ["STARTING NEW RUN", *body[:80], "STARTING NEW RUN", *body[80:]])],
        truth_of(one, 20), says="which loads were put on",
        fill=filled(loads='"0, 4.9, 9.8, 19.6 N"'),
    )  # fmt: skip


def one_clock_in_two_files(to: Path, rng: Rng) -> Made:
    """Two runs of one cell, named by numbers that no unit stands behind: not two cells at once."""
    one, paths = cell(rng, "newton"), []
    for start, name, newton in ((43071, "WG233_22_6796", 0.22), (242989, "WG25_907_185", 8.9)):
        at = start + np.cumsum(rng.integers(15, 18, 60))
        body = [f"d,{v:.2f},{t}" for v, t in zip(one.read(np.full(60, newton), rng, whole=False),
                                                 at, strict=True)]  # fmt: skip
        paths.append(write(to / f"Calibration_{name}_Increasing.csv", ["STARTING NEW RUN", *body]))
    return Made(paths, says="which loads were put on")


def epoch_without_a_name(to: Path, rng: Rng) -> Made:
    """Seconds since 1970 as numpy writes them, at uneven steps, then the reading."""
    one = cell(rng, "newton")
    newton = settling([0, 2, 5, 10], 5, 20)
    at = 1.6336311572e9 + np.cumsum(rng.choice([0.003, 0.055, 0.09], newton.size))
    body = rows(at, one.read(newton, rng, whole=False), form="%.18e")
    return Made([write(to / "force_data.csv", body)], truth_of(one, 10),
                says="which loads were put on", fill=filled(loads='"0, 2, 5, 10 N"'))  # fmt: skip


def flags_are_no_loads(to: Path, rng: Rng) -> Made:
    """A probe in salt water: what was used in a fit is 1, the rest 0; nothing weighs anything."""
    ppm = np.array([180, 350, 400, 590, 650, 850, 1100, 1220, 1820, 2330, 3050])
    volt = 2.3 * (1 - np.exp(-ppm / 600)) + rng.normal(0, 0.02, 11)
    names = "concentration_ppm,voltage_compensated_V,in_fit,note"
    body = [f"{p},{v:.3f},{int(p < 1000)},{'' if p < 1000 else 'saturated'}"
            for p, v in zip(ppm, volt, strict=True)]  # fmt: skip
    return Made([write(to / "probe.csv", [names, *body])], says="which loads were put on")


def acceleration_is_no_clock(to: Path, rng: Rng) -> Made:
    """A school's second law of motion: acceleration in nearly even steps."""
    acc = 1.2 + 0.5 * np.arange(25) + rng.normal(0, 0.02, 25)
    body = rows(5.0 * acc + rng.normal(0, 0.3, 25), acc, form="%.1f")
    return Made([write(to / "law.csv", ["Force,Acceleration", *body])],
                says="which loads were put on")  # fmt: skip


def vertical_axis_is_dead(to: Path, rng: Rng) -> Made:
    """A hand's three axes, of which the vertical one was not wired."""
    at = 0.2 + np.cumsum(rng.normal(0.012, 0.001, 80))
    x, y = 331 + rng.normal(0, 0.3, (2, 80)).cumsum(axis=1)
    body = rows(at, x, y, np.zeros(80), form="%.6g")
    return Made([write(to / "arm.csv", ["Time(sec),Force_X,Force_Y,Force_Z", *body])],
                says="is 0 in every row")  # fmt: skip


def axes_of_a_body(to: Path, rng: Rng) -> Made:
    """Insoles and plates in one table: V is vertical beside ML and AP, and no volt."""
    share = settling([0.35, 0.6, 0.7, 0.4, 0.55, 0.5], 5, 50)
    n, mass, gain = share.size, 71.0, (1.04, 0.97)
    names, data = ["knee_angle_r"], [rng.normal(-20, 1, n)]
    for side, part, g in zip(("Left", "Right"), (share, 1 - share), gain, strict=True):
        up = part * mass * 9.80665 / g + rng.normal(0, 1, n)
        names += [f"{side}_GRF_{axis}" for axis in ("ML", "V", "AP")]
        names += [f"{side}_cop_x", f"{side}_cop_y"]
        data += [rng.normal(0, 3, n), up, rng.normal(0, 5, n), *rng.normal(0, 0.02, (2, n))]
    found = {f"{side}_p{i}.scale": g for side, g in zip(("left", "right"), gain, strict=True)
             for i in (1, 2, 3)}  # fmt: skip
    return Made(
        [write(to / "trial.csv", [",".join([*names, "time"]),
                                  *rows(*data, 0.02 * np.arange(n), form="%.6f")])],
        Truth(found, dict.fromkeys(found, 0.05)), says="weigh", fill=filled(mass_kg=f"{mass}"),
    )  # fmt: skip


def steps_of_two_insoles(to: Path, rng: Rng) -> Made:
    """A row for each step, one insole below the other under the same header, at other times."""
    head = "App_time;Step_number;Contact_time;S0_force;S0_end_time;S1_force;S1_end_time;Side;Id;"
    lines = ["App Software", "", head]
    for side, count, start in (("L", 9, 44.5), ("R", 7, 42.4)):
        lines += [head] if side == "R" else []
        for i in range(count):
            force, until = rng.integers(40, 180, 2), rng.integers(400, 900, 3)
            lines.append(f"13:07:{start + 1.3 * i:06.3f};{i + 1};{until[0]};{force[0]};{until[1]};"
                         f"{force[1]};{until[2]};{side};8815;")  # fmt: skip
    return Made([write(to / "insole.csv", lines)], says="rows of two feet")


def markers_alone(to: Path, rng: Rng) -> Made:
    """Two markers under the same names, two empty columns between them."""
    at = 0.3 + 1e-4 * rng.normal(0, 1, (6, 30)).cumsum(axis=1)
    one = "field.frameNumber,field.x_m,field.y_m,field.z_m"
    body = [
        f"{660367 + i},{a:.9f},{b:.9f},{c:.9f},,,{660367 + i},{d:.9f},{e:.9f},{f:.9f}"
        for i, (a, b, c, d, e, f) in enumerate(at.T)
    ]
    return Made([write(to / "markers.csv", [f"{one},,,{one}", *body])], says="no force")


def poses_alone(to: Path, rng: Rng) -> Made:
    """Where an arm stood: places and rotation matrices, and nothing that was felt."""
    _, _, rot = wrist(rng, 8, 1)
    data = np.hstack([rng.uniform(0.1, 0.6, (8, 3)), rot.as_matrix().reshape(8, 9)])
    names = ",".join(["px", "py", "pz", *(f"o{i}{j}" for i in range(3) for j in range(3))])
    return Made([write(to / "poses.csv", [names, *rows(*data.T, form="%.18e")])], says="no force")


def one_row(to: Path, rng: Rng) -> Made:
    """What a program printed of one measurement: readings, mean and scatter in one line."""
    read = np.round(rng.normal(21_500, 40, 10))
    line = "\t".join(f"{v:.3f}".replace(".", ",") for v in (*read, read.mean(), read.std()))
    return Made([write(to / "read_100g.txt", [line])], says="one row")


def pose_beside_wrench_by_rows(to: Path, rng: Rng) -> Made:
    """Two files without names or stamps: wrenches, and as many places with a quaternion."""
    made, wrench, rot = wrist(rng, 14, 1)
    form = ", ".join(["%.17g"] * 6)
    first = write(to / "recorded_messages_wrench.txt", [form % tuple(row) for row in wrench])
    pose = np.hstack([rng.uniform(-0.8, 0.6, (14, 3)), rot.as_quat()])
    form = ", ".join(["%.17g"] * 7)
    second = write(to / "recorded_messages_pose.txt", [form % tuple(row) for row in pose])
    return Made([first, second], tool_truth(made))


def stamps_out_of_order(to: Path, rng: Rng) -> Made:
    """A thrust curve read off a picture: three points were clicked in the wrong order."""
    at = np.sort(rng.uniform(0.001, 0.49, 60))
    at[[3, 4]], at[[20, 21]] = at[[4, 3]], at[[21, 20]]
    at = np.array([0.0, *at, 0.5])
    thrust = 30 * np.sqrt(at) * np.exp(-6 * at)
    return Made([write(to / "thrust.csv", rows(at, thrust, form="%.9f"))],
                says="which loads were put on")  # fmt: skip


def cells_of_no_foot(to: Path, rng: Rng) -> Made:
    """Four cells of a bench, numbered, in time: whether weights lay on them nobody says."""
    at = 48 + np.cumsum(rng.integers(95, 100, 60))
    body = rows(at, *rng.normal(0, 20, (4, 60)), form="%.6g")
    return Made([write(to / "LC1532021.csv", ["time,lc1,lc2,lc3,lc4", *body])],
                says="known weights that lay on the cells")  # fmt: skip


TWENTIETH = (
    samples_and_their_extremes, scale_worked_out, force_and_its_stress, millis_that_jitter,
    one_clock_in_two_files, epoch_without_a_name, flags_are_no_loads, acceleration_is_no_clock,
    vertical_axis_is_dead, axes_of_a_body, steps_of_two_insoles, markers_alone, poses_alone,
    one_row, pose_beside_wrench_by_rows, stamps_out_of_order, cells_of_no_foot,
)  # fmt: skip
