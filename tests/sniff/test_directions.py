"""Directions in words, cycles, and readings in the unit of the loads."""

from __future__ import annotations

from pathlib import Path

import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.plan import LogPlan


def planned(path: Path, header: str, up: str, down: str) -> LogPlan:
    rows = [header]
    for cell in ("C1", "C2"):
        for run in (1, 2, 3):
            for word, masses in ((up, (0, 2, 4, 8)), (down, (4, 2, 0))):
                rows += [f"{cell},{run},{word},{m},{0.31 + 1.002 * m + 0.01 * run:.4f}"
                         for m in masses]  # fmt: skip
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    plan = plan_of(guess_file(path))
    assert plan is not None
    return plan


@pytest.mark.parametrize(
    ("up", "down"),
    [("up", "down"), ("loading", "unloading"), ("auf", "ab"), ("subida", "bajada"),
     ("Belastung", "Entlastung"), ("montée", "descente"), ("UP", "DOWN"), ("加载", "卸载")],
)  # fmt: skip
@pytest.mark.parametrize("name", ["dir", "phase"])
def test_directions_in_words(tmp_path: Path, up: str, down: str, name: str) -> None:
    plan = planned(tmp_path / "a.csv", f"cell,run,{name},mass_kg,volts", up, down)
    assert dict(plan.entries["direction"].names) == {up: "1", down: "-1"}
    channel = plan.entries["channel"].column
    assert channel is not None
    assert channel.column == "cell"


@pytest.mark.parametrize(
    ("cycle", "put", "read"),
    [("ciclo", "pesa_kg", "lectura_kg"), ("Zyklus", "Last_kg", "Anzeige_kg"),
     ("round", "mass_kg", "reading_kg"), ("giro", "carico_kg", "lettura_kg")],
)  # fmt: skip
def test_a_cycle_is_no_reading(tmp_path: Path, cycle: str, put: str, read: str) -> None:
    plan = planned(tmp_path / "a.csv", f"cell,{cycle},dir,{put},{read}", "up", "down")
    found = {name: e.column.column for name, e in plan.entries.items() if e.column is not None}
    assert (found["repeat"], found["load_n"], found["counts"]) == (cycle, put, read)
