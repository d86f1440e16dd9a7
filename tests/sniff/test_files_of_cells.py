"""A file for each of several cells that bend alike, named by a letter and numbers; or runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.several import parts_of

LOADS_KG = (0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 7.0, 10.0, 7.0, 4.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.0)
SCALES = {"03": 0.2138, "04": 0.2125, "07": 0.2151, "09": 0.2110}


def write(folder: Path, name: str, scale: float, rng: np.random.Generator) -> Path:
    """Four series of a sensor behind a dead zone of 0.15 kg, each after it was mounted again."""
    lines = ["serie,massa_kg,uitgang_mV"]
    zero = rng.uniform(-0.05, 0.07)
    for run in range(1, 5):
        again = zero + rng.normal(0, 0.004)
        for kg in LOADS_KG:
            shown = scale * max(kg - 0.15, 0.1 * kg) + again + rng.normal(0, 0.002)
            lines.append(f"{run},{kg:g},{shown:.4f}")
    path = folder / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def channels(paths: Sequence[Path]) -> list[str]:
    [part] = parts_of([guess_file(path) for path in paths])[0]
    return [name.lower() for name in part.plan.channels]


@pytest.mark.parametrize("name", ["sensor_S{}.csv", "weights_S{}.csv", "S{}.csv", "cel {} mV.csv"])
def test_a_file_for_each_sensor(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    paths = [write(tmp_path, name.format(at), scale, rng) for at, scale in SCALES.items()]
    found = channels(paths)
    assert [one[-2:] for one in found] == list(SCALES), found


def test_runs_of_one_sensor(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    paths = [write(tmp_path, f"druk_R{at}.csv", 0.2138, rng) for at in SCALES]
    assert len(channels(paths)) == 1
