"""Temperatures by a letter of degrees and numbers of a room, under names that no table knows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file

KG = np.tile([0.0, 1, 2, 5, 10, 5, 2, 1, 0], 4)


def quantities(path: Path, names: list[str], *columns: np.ndarray) -> dict[str, tuple[str, object]]:
    rows = [",".join(f"{v:.6g}" for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([",".join(names), *rows]) + "\n", encoding="utf-8")
    return {c.column: (c.quantity, c.unit) for c in guess_file(path).columns}


@pytest.mark.parametrize(
    ("name", "unit", "degrees"),
    [("shitsuon_C", "degC", 23.0), ("lampotila C", "degC", 18.0), ("huone_K", "K", 294.0)],
)
def test_a_letter_of_degrees_and_numbers_of_a_room(
    tmp_path: Path, name: str, unit: str, degrees: float
) -> None:
    rng = np.random.default_rng(1)
    room = degrees + 0.02 * np.arange(KG.size) + rng.normal(0, 0.05, KG.size)
    counts = np.round([9e3 + 4e4 * KG, 2e3 + 4.1e4 * KG])
    found = quantities(tmp_path / "a.csv", ["load_kg", "ad_ch1", "ad_ch2", name], KG, *counts, room)
    assert found[name] == ("temperature", unit)
    assert found["ad_ch1"][0] == "reading"


def test_cells_by_their_letters_are_no_temperatures(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    read = [10 + 2 * k + 0.9 * KG + rng.normal(0, 0.02, KG.size) for k in range(3)]
    found = quantities(tmp_path / "a.csv", ["load_kg", "kumi_A", "kumi_B", "kumi_C"], KG, *read)
    assert "temperature" not in {quantity for quantity, _ in found.values()}
    alone = quantities(tmp_path / "b.csv", ["load_kg", "kumi_C"], KG, read[0])
    assert alone["kumi_C"][0] != "temperature"
    beside = quantities(tmp_path / "c.csv", ["load_kg", "adc", "kumi_C"], KG, 900 * KG, read[0])
    assert beside["kumi_C"][0] != "temperature"
