"""A stranger's log goes in, a calibration or the next step comes out."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Run
from tests.strangers import seen
from tests.strangers.rigs import Write
from tests.strangers.trial import trial

SAMPLE = (
    seen.semicolons_commas_units, seen.serial_with_typed_weights, seen.one_file_per_channel,
    seen.wrist_rpy_degrees, seen.bare_readings,
)  # fmt: skip


@pytest.mark.parametrize("shape", SAMPLE, ids=lambda s: s.__name__)
def test_a_sample_of_the_corpus(shape: Write, run: Run, tmp_path: Path) -> None:
    found = trial(shape, tmp_path, run)
    assert found.outcome == ("next step" if found.made.says else "calibration")
