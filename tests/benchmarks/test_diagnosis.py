"""How long diagnoses take, whatever they say: a ten-minute walk, and every shipped sample."""

from __future__ import annotations

from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from tests.core.test_diagnosis_bridge import ROBOT, walk_case
from tests.golden.runs import RUNS, Cabinet

TEN_MINUTES_S = 600.0
SAMPLES = [run for run in RUNS.values() if run.words[0] == "diagnose" and not run.measured]


@pytest.fixture(scope="module")
def cabinet(tmp_path_factory: pytest.TempPathFactory) -> Cabinet:
    return Cabinet(tmp_path_factory.mktemp("runs"))


@pytest.mark.slow
@pytest.mark.parametrize("name", [run.name for run in SAMPLES])
def test_a_shipped_sample(benchmark: BenchmarkFixture, cabinet: Cabinet, name: str) -> None:
    for earlier in RUNS[name].starts_from:
        cabinet.kept(earlier)
    once: Any = benchmark  # its `pedantic` has no types
    once.pedantic(cabinet.kept, (name,), rounds=1, iterations=1)


@pytest.mark.slow
def test_ten_minutes_of_walking(benchmark: BenchmarkFixture) -> None:
    hysteresis = ("hysteresis", {"all": ROBOT.channels}, {"all.hysteresis_width": 0.4})
    long = walk_case(1, hysteresis, duration_s=TEN_MINUTES_S)
    # a calibration that drifts hides these; the command leaves them out of a walk
    hidden = ("mass", "creep", "creep_slow", "bias_drift", "bias_jump", "slip")
    table = {name: row for name, row in TABLE.items() if name not in hidden}
    once: Any = benchmark  # its `pedantic` has no types
    once.pedantic(investigate, (long, table, describe), rounds=1, iterations=1)
