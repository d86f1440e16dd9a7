"""Write the weights of ten months: `python sample_data/fleet/make.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
LOADS_N = np.array([0, 2, 5, 10, 20, 30, 20, 10, 5, 2, 0.0])


def main() -> None:
    """Weights on one cell in ten months; in June its zero moves by 0.6 N."""
    random = np.random.default_rng(3)
    table = ["session,robot,date,logs"]
    for month in range(1, 11):
        zero = 8_312_000 + (17_600 if month >= 6 else 0) + 1_500 * random.standard_normal()
        scale = -33.4e-6 * (1 + 1e-4 * random.standard_normal())
        rows = ["channel,load_n,counts,repeat"]
        for repeat in range(1, 4):
            counts = zero + LOADS_N / scale + 400 * random.standard_normal(LOADS_N.size)
            rows += [
                f"left_fl,{load:g},{count:.0f},{repeat}"
                for load, count in zip(LOADS_N, counts, strict=True)
            ]
        log = HERE / f"2026-{month:02d}.csv"
        log.write_text("\n".join(rows) + "\n", encoding="utf-8")
        table.append(f"{log.stem},robot 1,{log.stem}-02,{log.name}")
    (HERE / "sessions.csv").write_text("\n".join(table) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
