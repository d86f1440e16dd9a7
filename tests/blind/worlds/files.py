"""Writing what a logger would have written: tables, and the recipe that goes with them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from tests.blind.world import Rng, World


def write_log(frame: pd.DataFrame, folder: Path, name: str, rng: Rng) -> str:
    """Write a table as Parquet or CSV, drawn; returns the file's name."""
    if rng.random() < 0.5:
        frame.to_parquet(folder / f"{name}.parquet", index=False)
        return f"{name}.parquet"
    frame.to_csv(folder / f"{name}.csv", index=False, float_format="%.9g")
    return f"{name}.csv"


def write_recipe(folder: Path, robot: Mapping[str, Any], data: Mapping[str, str]) -> None:
    """Write ``recipe.toml`` with the robot and where the logs lie."""
    lines = ['name = "robot under test"', ""]
    lines += _table("robot", robot)
    lines += ["[data]", *(f'{role} = "{name}"' for role, name in data.items()), ""]
    (folder / "recipe.toml").write_text("\n".join(lines), encoding="utf-8")


def _table(path: str, content: Mapping[str, Any]) -> list[str]:
    plain = {k: v for k, v in content.items() if not isinstance(v, Mapping)}
    lines = [f"[{path}]", *(f"{k} = {_value(v)}" for k, v in plain.items()), ""]
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += _table(f"{path}.{key}", value)
    return lines


def _value(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)


def write_bench_calibration(world: World, folder: Path, rng: Rng, full_n: float) -> str:
    """Each cell alone under four weights, read long before: the calibration to start from."""
    rows = []
    for i, channel in enumerate(world.channels):
        for load in (0.0, 0.25 * full_n, 0.5 * full_n, full_n):
            for _ in range(4):
                force = load + 0.1 * float(world.noise[:, i].std()) * rng.normal()
                counts = float(round(world.zero[i] + force / world.scale[i]))
                rows.append((channel, round(load, 4), counts))
    return write_log(
        pd.DataFrame(rows, columns=["channel", "load_n", "counts"]), folder, "bench", rng
    )
