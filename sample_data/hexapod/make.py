"""Sensors on the physics engine's hexapod: offsets of [Wu], Table II, noise and resolution.

Reads the motion tables of ``sample_data/physics/hexapod.py`` and writes the logs of this folder:

    python sample_data/physics/hexapod.py --out MOTION
    python sample_data/hexapod/make.py MOTION

Every reading is the engine's wrench plus its transducer's offset, white noise, and slow noise with
a memory of 2 s, rounded to a quantum as an analogue-to-digital converter does.
"""

from __future__ import annotations

import argparse
import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

HERE = Path(__file__).parent
WRENCH = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"]
#: [Wu], Table II.
OFFSETS = {
    "hl": (1.47, -1.30, -5.61, 0.2457, 0.002, 0.034),
    "ml": (1.419, -4.884, -0.406, -0.0136, 0.0808, 0.0144),
    "fl": (0.57, 3.71, -2.039, 0.2176, 0.0921, -0.0177),
    "hr": (-8.49, -1.448, -2.43, -0.3159, 0.3449, 0.001),
    "mr": (-0.06, -0.123, -0.07, -0.2392, -0.0982, 0.004),
    "fr": (-0.93, 0.653, -2.183, -0.3611, -0.153, 0.0222),
}
QUANTUM = np.array([0.005] * 3 + [0.0005] * 3)
MEMORY_S = 2.0
#: Log -> every n-th stamp kept, white sd and slow sd of the force (N); torque is a tenth (Nm).
PLAN = {
    "hang": ("hang", 2, 0.05, 0.02),
    "poses": ("poses", 1, 0.02, 0.0),
    "tripod": ("tripod", 1, 0.02, 0.0),
    "still": ("still", 2, 0.03, 0.0),
    "hexwalk": ("walk", 2, 0.03, 0.0),
}


def measured(table: pd.DataFrame, white_n: float, slow_n: float, seed: int) -> pd.DataFrame:
    """Offsets, noise and resolution on the readings of a motion table."""
    rng = np.random.default_rng(seed)
    table = table.copy()
    share = np.array([1.0] * 3 + [0.1] * 3)
    part = table["leg"] + (" " + table["orientation"] if "orientation" in table else "")
    for name, rows in table.groupby(part, sort=False).groups.items():
        reading = table.loc[rows, WRENCH].to_numpy(float) + OFFSETS[str(name).split()[0]]
        reading += white_n * share * rng.normal(size=reading.shape)
        if slow_n:
            step_s = float(np.diff(table.loc[rows, "time_s"]).min())
            keep = np.exp(-step_s / MEMORY_S)
            slow = rng.normal(size=6)
            for row in reading:
                row += slow_n * share * slow
                slow = keep * slow + np.sqrt(1.0 - keep**2) * rng.normal(size=6)
        table.loc[rows, WRENCH] = (np.round(reading / QUANTUM) * QUANTUM).astype("float32")
    return table


def thinned(table: pd.DataFrame, every: int) -> pd.DataFrame:
    """Every n-th stamp with all its legs."""
    return table[np.arange(len(table)) // 6 % every == 0].reset_index(drop=True)


def main() -> None:
    """Write the logs and copy the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("motion", type=Path)
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    for i, (motion, (name, every, white_n, slow_n)) in enumerate(PLAN.items()):
        table = thinned(pd.read_parquet(options.motion / f"motion_{motion}.parquet"), every)
        table = measured(table, white_n, slow_n, options.seed + i)
        if name == "still":
            table = table.drop(columns=["pose", "contact"])
        if "contact" in table:
            table["contact"] = table["contact"].astype("int8")
        # The engine's ground wrench stays in the walk alone: the truth that `apply` is held to.
        if name != "walk":
            table = table.drop(columns=[c for c in table if c.startswith("ground_")])
        arrow = pa.Table.from_pandas(table, preserve_index=False).replace_schema_metadata(None)
        pq.write_table(arrow, HERE / f"{name}.parquet", compression="zstd", compression_level=19)
    shutil.copyfile(options.motion / "truth_hexapod.json", HERE / "truth.json")
    truth = json.loads((HERE / "truth.json").read_text(encoding="utf-8"))
    for leg, offset in OFFSETS.items():
        truth["legs"][leg]["offset"] = list(offset)
    (HERE / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
