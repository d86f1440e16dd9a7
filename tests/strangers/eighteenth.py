"""Shapes of real logs that were found in public repositories, with numbers of our own.

`docs/bring_your_log.md` has the count of the first run of the real ones.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import (
    Cell,
    G,
    Made,
    Rng,
    cell,
    rows,
    tool_truth,
    truth_of,
    wrist,
    write,
)


def plates_along_one_axis(to: Path, rng: Rng) -> Made:
    """A spot check: the same people on two plates of three axes, of which y is vertical."""
    kg = np.array([58.4, 71.2, 66.9, 92.5, 83.1, 75.0])
    cells = {f"plate_{i}_y": Cell(1.0 + 0.01 * i, 4.0 * i, 0.5) for i in (1, 2)}
    columns, names = [kg], ["subject_kg"]
    for i, one in enumerate(cells.values(), 1):
        up = one.read(kg * G, rng, whole=False)
        columns += [rng.normal(0, 5, 6), up, rng.normal(3, 5, 6)]
        names += [f"Plate{i}{axis}" for axis in "xyz"]
    body = rows(*columns, form="%.6g")
    return Made([write(to / "check.csv", [",".join(names), *body])], truth_of(cells, 907))


def pressed_for_a_while(to: Path, rng: Rng) -> Made:
    """A file for each force that a hand held for a part of its seconds."""
    one, paths = cell(rng), []
    for newton in (0, 6, 12):
        shape = np.interp(np.arange(80), [20, 30, 55, 65], [0, 1, 1, 0])
        read = one.read(newton * shape, rng)
        body = rows(1500 + 95 * np.arange(80), read, sep="\t", form="%.8g")
        paths.append(write(to / f"hold_{newton}N.tsv", ["millis\tvalue", *body]))
    return Made(paths, says="offline-fit")


def load_twice_and_a_dial(to: Path, _rng: Rng) -> Made:
    """A stiffness test: the load in two units, and the dial that moved."""
    kg = np.array([0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0])
    lines = ["| Load (kg) | Load (N) | Dial (mm) |", "|:--:|:--:|:--:|"]
    lines += [f"| {k:g} | {k * 9.81:.2f} | {0.7 * k:.2f} |" for k in kg]
    return Made([write(to / "stiffness.md", lines)], says="no reading next to it")


def counts_in_even_steps(to: Path, rng: Rng) -> Made:
    """Counts that rise evenly with the weights are no clock."""
    one = Cell(float(rng.uniform(0.001, 0.004)), 0.0, 0.0)
    kg = np.arange(0.0, 4.5, 0.5)
    body = [f"{k},{k * G:.3f},{round(k * G / one.scale)}" for k in kg.tolist()]
    return Made([write(to / "even.csv", ["load_kg,load_N,counts", *body])], truth_of(one, 5))


def one_message(to: Path, rng: Rng) -> Made:
    """The one message that somebody asked about."""
    x = rng.normal(0, 5, 6)
    lines = ["tool_wrench:", "  header:", "    stamp:", "      sec: 12", "      nanosec: 500000000",
             "    frame_id: ft/tool", "  wrench:", "    force:",
             *(f"      {a}: {v:.9f}" for a, v in zip("xyz", x[:3], strict=True)),
             "    torque:",
             *(f"      {a}: {v:.9f}" for a, v in zip("xyz", x[3:], strict=True))]  # fmt: skip
    return Made([write(to / "echo.yaml", lines)], says="one message")


def messages_without_lines(to: Path, rng: Rng) -> Made:
    """Messages that were pasted without the lines between them."""
    lines = []
    for _ in range(4):
        x = rng.normal(0, 5, 6)
        lines += ["wrench: ", "  force: ",
                  *(f"    {a}: {v:.9f}" for a, v in zip("xyz", x[:3], strict=True)),
                  "  torque: ",
                  *(f"    {a}: {v:.9f}" for a, v in zip("xyz", x[3:], strict=True))]  # fmt: skip
    return Made([write(to / "wrench.txt", lines)], says="attitude")


def cop_alone(to: Path, rng: Rng) -> Made:
    """What a laboratory kept of quiet standing: the CoP."""
    t = 0.01 * np.arange(200)
    body = rows(t, *np.cumsum(rng.normal(0, 1e-4, (2, 200)), axis=1), form="%.6f")
    return Made([write(to / "eyes_closed.csv", ["Time,CoPx,CoPy", *body])], says="centre of")


def matrix_of_a_transducer(to: Path, rng: Rng) -> Made:
    """What came with the transducer: its matrix."""
    body = rows(*rng.normal(0, 10, (6, 6)).T, sep=" ", form="%.5f")
    return Made([write(to / "matrix.txt", body)], says="matrix")


def poses_in_another_file(to: Path, rng: Rng) -> Made:
    """Places and quaternions in one file, wrenches in another, nothing named, nothing stamped."""
    made, wrench, rot = wrist(rng)
    some = slice(None, None, 60)
    place = rng.normal(0, 0.3, (len(wrench), 3))
    posed = np.column_stack([place, rot.as_quat()])[some]
    return Made(
        [write(to / "felt.txt", rows(*wrench[some].T, sep=", ", form="%.12f")),
         write(to / "poses.txt", rows(*posed.T, sep=", ", form="%.12f"))],
        tool_truth(made),
    )  # fmt: skip


def pressures_of_a_rig(to: Path, rng: Rng) -> Made:
    """Two pressures of a cold flow, of which one has few values."""
    n = 40
    low = rng.choice([0.4, 1.1, 1.5, 2.2], n)
    high = low + rng.normal(0, 0.3, n)
    body = [
        f"{100 * i},FILL,{a:.2f},{b:.2f}" for i, (a, b) in enumerate(zip(low, high, strict=True))
    ]
    return Made([write(to / "flow.csv", ["t [ms],Mode,P_a [Bar],P_b [Bar]", *body])],
                says="fit no experiment")  # fmt: skip


EIGHTEENTH = (
    plates_along_one_axis, pressed_for_a_while, load_twice_and_a_dial, counts_in_even_steps,
    one_message, messages_without_lines, cop_alone, matrix_of_a_transducer, poses_in_another_file,
    pressures_of_a_rig,
)  # fmt: skip
