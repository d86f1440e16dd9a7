"""What `footcal diagnose` says of measured bench data: something is there, and nothing is claimed.

None of these recordings states its cause, so no name is asserted; what is, can be seen in them by
other means.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import signal

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.conftest import Answer, Run

Diagnose = Callable[[str, str, str], Answer]


@pytest.fixture
def diagnose(run: Run, real_data: Path, repository: Path, tmp_path: Path) -> Diagnose:
    """Diagnose a log of the real data by recipe and experiment, into ``tmp_path/out``."""

    def diagnosed(log: str, recipe: str, experiment: str) -> Answer:
        return run(
            "diagnose", real_data / log, "--recipe", repository / "recipes" / recipe,
            "--experiment", experiment, "--out", tmp_path / "out",
        )  # fmt: skip

    return diagnosed


@pytest.mark.slow
def test_load_cell_with_hung_weights(diagnose: Diagnose, real_data: Path, tmp_path: Path) -> None:
    answer = diagnose("loadcell-creep/test2.csv", "loadcell_creep.toml", "weights")
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    # three weights and no repeat: nothing may be named with confidence, and something is there
    assert record.verdict in ("unknown", "named+unknown", "ambiguous")
    assert record.evidence["signals_p"] < 0.01
    assert record.evidence["line_p"] < 1e-6
    # the hung weight swings: a spectrum by another hand has its peak above the noise there too
    data = pd.read_csv(real_data / "loadcell-creep/test2.csv")
    quiet = data[(data.t_s > 400) & (data.t_s < 1100)]
    rate_hz = 1.0 / float(np.median(np.diff(quiet.t_s)))
    frequency, power = signal.welch(quiet.loadcell_mN.to_numpy(), rate_hz, nperseg=512)
    band = (frequency > 2.0) & (frequency < 9.5)
    peak_hz = frequency[band][np.argmax(power[band])]
    said = re.search(r"line at ([\d.]+) Hz", record.sentence)
    assert said is not None
    assert record.sentence.count("joint") == 1  # told where once
    assert float(said[1]) == pytest.approx(peak_hz, abs=0.3)  # it swings a little with the weight


@pytest.mark.slow
def test_insole_under_air_pressure(diagnose: Diagnose, tmp_path: Path) -> None:
    answer = diagnose("insole-plenum/calibration_dataset.parquet", "insole_plenum.toml", "weights")
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    # the source fits a polynomial and a dynamic model because scale and bias do not do
    assert record.verdict in ("unknown", "named+unknown", "ambiguous")
    assert record.evidence["signals_p"] < 0.01


def test_force_plate_without_forces_is_refused(diagnose: Diagnose) -> None:
    answer = diagnose(
        "forceplate-cop-points/points_frames.csv", "forceplate_cop_points.toml", "placements"
    )
    assert answer.exit_code == 2
    assert "no cells of a foot are described" in answer.err


def test_one_stance_on_insoles_is_too_little(diagnose: Diagnose, tmp_path: Path) -> None:
    answer = diagnose("loadsol-insoles/test_poids_loadsol.csv", "loadsol_insoles.toml", "stand")
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "underpowered"
    assert not record.causes
