"""How long whole diagnoses take, whatever they say: every shipped sample, and ten minutes."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from tests.core.test_diagnosis_bridge import ROBOT, walk_case
from tests.golden.runs import RUNS, Cabinet

TEN_MINUTES_S = 600.0
SAMPLES = [run for run in RUNS.values() if run.words[0] == "diagnose" and not run.measured]
HIDDEN = ("mass", "creep", "creep_slow", "bias_drift", "bias_jump", "slip")
"""A calibration that drifts hides these; the command leaves them out of a walk."""


def diagnosed(rounds: int) -> Iterator[tuple[str, list[float]]]:
    """Name and CPU seconds of each round: the shipped samples through the command, and a walk."""
    for run in SAMPLES:
        times = []
        for _ in range(rounds):
            with tempfile.TemporaryDirectory() as folder:
                cabinet = Cabinet(Path(folder))
                for earlier in run.starts_from:
                    cabinet.kept(earlier)
                began = time.process_time()
                cabinet.kept(run.name)
                times.append(time.process_time() - began)
        yield run.name.replace("_", " "), times
    hysteresis = ("hysteresis", {"all": ROBOT.channels}, {"all.hysteresis_width": 0.4})
    long = walk_case(1, hysteresis, duration_s=TEN_MINUTES_S)
    table = {name: row for name, row in TABLE.items() if name not in HIDDEN}
    began = time.process_time()
    investigate(long, table, describe)
    yield "ten minutes of walking, without files", [time.process_time() - began]


def lines_of(results: list[tuple[str, list[float]]]) -> list[str]:
    """The table of the page."""
    rows = ["## Whole diagnoses", "| | CPU s | rounds |", "|---|---|---|"]
    for name, times in results:
        spread = f"{min(times):.1f} to {max(times):.1f}" if len(times) > 1 else f"{times[0]:.1f}"
        rows.append(f"| {name} | {spread} | {len(times)} |")
    return [*rows, ""]
