"""Makes this folder: a simulated bench calibration of one foot, with what is true of it.

Run from the repository: ``python sample_data/bench_foot/make.py``.
"""

from __future__ import annotations

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent))

from tests.core.bench_data import (  # noqa: E402 - found only with the repository on the path
    CELL_POS,
    CELLS,
    Staircase,
    make_foot,
    placements,
)

SEED = 4
SESSIONS = 3
HYSTERESIS_N = {"left_rr": 0.18}
LIGHTEST_N = 4.0
REPEATS = 6


def main() -> None:
    """Write weights.csv, placements.csv and truth.json."""
    rng = np.random.default_rng(SEED)
    foot = make_foot(rng, crosstalk=0.03, position_m=0.004)
    with (HERE / "weights.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["channel", "session", "time_s", "load_n", "counts"])
        for i, cell in enumerate(CELLS):
            stairs = Staircase(
                scale=float(foot.scale[i]),
                bias=float(foot.bias[i]),
                sessions=SESSIONS,
                session_sd_n=0.02,
                noise_n=foot.noise_n,
            )
            rows = replace(stairs, hysteresis_width=HYSTERESIS_N.get(cell, 0.0)).record(rng)
            for session, time, load, counts in zip(
                rows["session"], rows["time_s"], rows["load_n"], rows["counts"], strict=True
            ):
                writer.writerow([cell, f"day {session + 1:.0f}", f"{time:.0f}", f"{load:.4f}",
                                 f"{counts:.0f}"])  # fmt: skip
    load, hole, counts = placements(foot, rng, repeats=REPEATS)
    names = {tuple(h): f"H{i + 1:02d}" for i, h in enumerate(np.unique(hole, axis=0))}
    with (HERE / "placements.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        columns = [f"{cell.removeprefix('left_')}_counts" for cell in CELLS]
        writer.writerow(["foot", "placement", "hole_x_m", "hole_y_m", "load_n", *columns])
        for n, place, codes in zip(load, hole, counts, strict=True):
            if n >= LIGHTEST_N:
                writer.writerow(["left", names[tuple(place)], f"{place[0]:.3f}", f"{place[1]:.3f}",
                                 f"{n:.4f}", *(f"{c:.0f}" for c in codes)])  # fmt: skip
    shift = foot.pos - CELL_POS
    parameters = {}
    for i, cell in enumerate(CELLS):
        parameters |= {
            f"{cell}.scale": foot.scale[i],
            f"{cell}.bias": foot.bias[i],
            f"{cell}.crosstalk": foot.crosstalk[i],
            f"{cell}.cell_correction_x": shift[i, 0],
            f"{cell}.cell_correction_y": shift[i, 1],
            f"{cell}.hysteresis_width": HYSTERESIS_N.get(cell, 0.0),
            f"{cell}.hysteresis_reach": Staircase.hysteresis_reach,
        }
    owners = {cell: [cell] for cell in CELLS}
    truth = {
        "schema": "footcal.truth",
        "schema_version": 1,
        "footcal_version": "0.1.0",
        "experiment": "weights and placements",
        "seed": SEED,
        "robot": {"cell_pos_believed_m": CELL_POS.tolist()},
        "parameters": {name: float(value) for name, value in parameters.items()},
        "effects": [
            {"effect": "cell_position", "owners": owners},
            {"effect": "crosstalk", "owners": owners},
            {"effect": "hysteresis", "owners": {cell: [cell] for cell in HYSTERESIS_N}},
        ],
        "noise": {"cell_n": foot.noise_n, "session_n": 0.02, "hole_m": 1e-4},
        "details": {"hysteresis": "acts on single cells under weights, not in the placements"},
    }
    (HERE / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")


if __name__ == "__main__":
    main()
