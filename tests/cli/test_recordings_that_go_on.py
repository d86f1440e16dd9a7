"""Recordings of known weights that go on, with pauses, after the last reading of a cell."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.conftest import Run

STEPS_KG = (0.0, 2.0, 5.0, 10.0, 12.0, 10.0, 5.0, 2.0, 0.0)
RECIPE = """
[robot]
channels = ["toe", "heel"]
[[files]]
match = "log.csv"
wide_into = "channel"
[files.wide.toe]
counts = { column = "toe_V", only_where = { under = "toe" } }
[files.wide.heel]
counts = { column = "heel_V", only_where = { under = "heel" } }
[columns]
load_n = { column = "mass_g", unit = "g", missing = ["-1"] }
time_s = "time"
[data]
weights = ["log.csv"]
"""


def write_log(to: Path) -> None:
    """Two cells with a hysteresis (V = 0.02 F + 0.5), one after the other, with a pause."""
    rng = np.random.default_rng(3)
    ways = np.r_[np.ones(5), -np.ones(4)]
    loop_g = [20.0 * w * kg * (12 - kg) / 36 for kg, w in zip(STEPS_KG, ways, strict=True)]
    lines, clock = ["time,under,mass_g,toe_V,heel_V"], 0.0
    for name in ("toe", "heel"):
        for kg, loop in zip([*STEPS_KG, *STEPS_KG], [*loop_g, *loop_g], strict=True):
            for i in range(140):
                put = 0.02 * 9.80665 * (kg + 1e-3 * loop)
                read = 0.5 + np.array([put * (name == "toe"), put * (name == "heel")])
                toe, heel = read + rng.normal(0, 2e-4, 2)
                mass = -1 if i < 40 else 1e3 * kg
                lines.append(f"{clock:.3f},{name},{mass:.0f},{toe:.6f},{heel:.6f}")
                clock += 0.1
            clock += 5.0
    (to / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_a_recording_with_pauses_after_the_last_reading(run: Run, tmp_path: Path) -> None:
    write_log(tmp_path)
    recipe = tmp_path / "my.toml"
    recipe.write_text(RECIPE, encoding="utf-8")
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out", "--no-pictures")
    assert answer.exit_code == 3, answer.err  # 0 is written for what the condition leaves out
    assert "are of the unloaded cell" in answer.out
