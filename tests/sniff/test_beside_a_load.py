"""Columns beside a load that are no load: minutes since it changed, runs of a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.several import parts_of


@pytest.mark.parametrize(
    ("name", "unit"),
    [("Minutes after load change", "min"), ("Minuten nach Lastwechsel", "min"),
     ("hours since mass was put on", "h"), ("seconds under load", "s")],
)  # fmt: skip
def test_minutes_since_a_load_changed_are_a_time(tmp_path: Path, name: str, unit: str) -> None:
    assert (name_guess(name).quantity, name_guess(name).unit) == ("time", unit)
    rows = [f"{cell},{load},{at},{0.2 * k + (0.2 + 0.01 * k) * load + 0.001 * at:.4f}"
            for k, cell in enumerate((20417, 20418, 20422))
            for load in (100, 0) for at in (0.5, 1, 2, 5, 10)]  # fmt: skip
    path = tmp_path / "hold.csv"
    head = f"Serial No,Applied lbf,{name},Output mV"
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    (part,), _ = parts_of([guess_file(path)])
    load = part.plan.entries["load_n"].column
    assert load is not None
    assert load.column == "Applied lbf"
    assert part.plan.channels == ("20417", "20418", "20422")
    assert not part.plan.warnings


@pytest.mark.parametrize("cells", [("toe_in", "toe_out"), ("heel",)])
def test_runs_of_a_recording_are_kept(tmp_path: Path, cells: tuple[str, ...]) -> None:
    paths = []
    for k, cell in enumerate(cells, 1):
        rng, lines, t = np.random.default_rng(k), ["millis,adc_raw,weight_kg,rep"], 0
        for rep in (1, 2, 3):
            for kg in (0, 2, 5, 10, 5, 2, 0):
                for i in range(60):
                    t += 12
                    load = f"{kg}" if i > 15 else ""
                    read = 1000 * k + 40 * rep + 300 * k * kg + rng.normal(0, 3)
                    lines.append(f"{t},{read:.0f},{load},{rep}")
        paths.append(tmp_path / f"test_{cell}.csv")
        paths[-1].write_text("\n".join(lines) + "\n", encoding="utf-8")
    (part,), _ = parts_of([guess_file(path) for path in paths])
    run = part.plan.entries["repeat" if len(cells) > 1 else "session"].column
    assert run is not None
    assert run.column == "rep"
