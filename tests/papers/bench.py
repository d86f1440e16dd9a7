"""The foot paper's bench: Table 2 as printed, Table 3 and Figs. 7 and 8 on a simulated foot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from footcal_cli.core.bench.regression import fit_affine
from tests.papers.commands import run

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
TABLE_2 = ROOT / "sample_data" / "nao_table2"
GRAVITY_MPS2 = 9.80665


@dataclass(frozen=True)
class Table2Row:
    """One cell of Table 2: printed and fitted, in the printed unit; and in newtons."""

    cell: str
    printed: tuple[float, float]
    fitted: tuple[float, float]
    newtons: tuple[float, float]
    residual_kg: float


def table_2() -> list[Table2Row]:
    """Regress the printed loads on the printed counts, in kilograms as the paper does."""
    weights = pd.read_csv(TABLE_2 / "weights.csv")
    printed = pd.read_csv(TABLE_2 / "printed_coefficients.csv").set_index("channel")
    rows = []
    for cell, own in weights.groupby("channel", sort=False):
        load, counts = (own[name].to_numpy(dtype=float) for name in ("load_kg", "counts"))
        in_kg = fit_affine(str(cell), load, counts)
        c, d = (float(value) for value in in_kg.estimates.values)
        left = load - (c * counts + d)
        rows.append(
            Table2Row(
                str(cell),
                (float(printed["scale_kg_per_count"][cell]), float(printed["bias_kg"][cell])),
                (c, d),
                (c * GRAVITY_MPS2, d * GRAVITY_MPS2),
                float(np.sqrt(np.mean(left**2))),
            )
        )
    return rows


@dataclass(frozen=True)
class Table3:
    """RMSE before and after offline calibration, and on placements never used."""

    cop_m: tuple[float, float, float]
    vgrf_n: tuple[float, float, float]
    printed_model_cop_m: float


def table_3(out: Path) -> tuple[Table3, Path]:
    """`offline-fit` on the simulated foot of the samples; its errors and its run folder."""
    folder = run("offline-fit", "--recipe", ROOT / "recipes" / "bench_foot.toml", out=out / "bench")
    rows = pd.read_csv(folder / "rmse.csv")

    def rmse(quantity: str, stage: str, reference: str) -> float:
        at = (rows.quantity == quantity) & (rows.stage == stage)
        return float(rows.rmse[at & rows.reference.str.contains(reference, regex=False)].iloc[0])

    never = "placement never used"
    return Table3(
        (rmse("cop left", "before", "hole"), rmse("cop left", "after", "hole"),
         rmse("cop left", "after", never)),
        (rmse("vgrf left", "before", "known load"), rmse("vgrf left", "after", "known load"),
         rmse("vgrf left", "after", never)),
        rmse("cop left", "full", never),
    ), folder  # fmt: skip
