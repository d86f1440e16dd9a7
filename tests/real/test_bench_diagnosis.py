"""What `footcal diagnose` says of measured bench data: something is there, and nothing is claimed.

None of these recordings states its cause, so no name is asserted; what is, can be seen in them by
other means.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import signal

from footcal_cli.records import DiagnosisRecord, read_record
from tests.conftest import Run


def test_load_cell_with_hung_weights(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    log = real_data / "loadcell-creep/test2.csv"
    answer = run(
        "diagnose", log, "--recipe", repository / "recipes/loadcell_creep.toml",
        "--experiment", "weights", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    # three weights and no repeat: nothing may be named with confidence, and something is there
    assert record.verdict in ("unknown", "named+unknown", "ambiguous")
    assert record.evidence["signals_p"] < 0.01
    assert record.evidence["line_p"] < 1e-6
    # the hung weight swings: a spectrum by another hand has its peak above the noise there too
    data = pd.read_csv(log)
    quiet = data[(data.t_s > 400) & (data.t_s < 1100)]
    rate_hz = 1.0 / float(np.median(np.diff(quiet.t_s)))
    frequency, power = signal.welch(quiet.loadcell_mN.to_numpy(), rate_hz, nperseg=512)
    band = (frequency > 2.0) & (frequency < 9.5)
    peak_hz = frequency[band][np.argmax(power[band])]
    said = re.search(r"line at ([\d.]+) Hz", record.sentence)
    assert said is not None
    assert record.sentence.count("joint") == 1  # told where once
    assert float(said[1]) == pytest.approx(peak_hz, abs=0.3)  # it swings a little with the weight


def test_insole_under_air_pressure(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "diagnose", real_data / "insole-plenum/calibration_dataset.parquet",
        "--recipe", repository / "recipes/insole_plenum.toml",
        "--experiment", "weights", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    # the source fits a polynomial and a dynamic model because scale and bias do not do
    assert record.verdict in ("unknown", "named+unknown", "ambiguous")
    assert record.evidence["signals_p"] < 0.01


def test_force_plate_without_forces_is_refused(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "diagnose", real_data / "forceplate-cop-points/points_frames.csv",
        "--recipe", repository / "recipes/forceplate_cop_points.toml",
        "--experiment", "placements", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 2
    assert "names no cells" in answer.err


def test_one_stance_on_insoles_is_too_little(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "diagnose", real_data / "loadsol-insoles/test_poids_loadsol.csv",
        "--recipe", repository / "recipes/loadsol_insoles.toml",
        "--experiment", "stand", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "underpowered"
    assert not record.causes
