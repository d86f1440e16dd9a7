"""Command lines outside the blocks that `test_documents` follows: each is run on a log that fits.

A line printed without its log, `footcal diagnose --plan` in a sentence, is run with what it lacks.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import REPOSITORY
from tests.docs.test_documents import PAGES, blocks, commands, printed_commands, shell
from tests.docs.test_readme_recipes import SAVED_AS

BIPED = "sample_data/biped"
NAO = "--recipe recipes/nao_walk.toml"


def _weights(place: Path) -> None:
    load = np.tile([0.0, 10.0, 20.0, 40.0, 20.0, 10.0], 3)
    counts = 8_347_000 - 29_400.0 * load + np.random.default_rng(3).normal(0.0, 60.0, load.size)
    table = pd.DataFrame({"load_n": load, "counts": counts.round()})
    table.insert(0, "channel", "left_fl")
    for name in ("my_log.csv", "logs_1.csv", "logs_2.csv"):
        table.to_csv(place / name, index=False)


def _described(place: Path) -> None:
    _weights(place)
    assert shell("footcal init my_log.csv -o my.toml") == 0


def _scale(place: Path) -> None:
    """The scale of the README, calibrated, and a log of it."""
    readme = REPOSITORY / "README.md"
    for block in blocks(readme):
        if block.title == "scale.csv":
            (place / "scale.csv").write_text(block.text, encoding="utf-8")
    for line in printed_commands(readme):
        if "scale" in line and "apply" not in line:
            assert shell(line) == 0
    time_s = np.arange(0.0, 2.0, 0.0125)
    counts = 900_000 + 50_000 * np.sin(time_s)
    pd.DataFrame({"time_s": time_s, "cell_counts": counts.round()}).to_csv(
        place / "walk.csv", index=False
    )


def _fleet(place: Path) -> None:
    _weights(place)
    (place / "sessions.csv").write_text("logs\nlogs_1.csv\nlogs_2.csv\n", encoding="utf-8")
    (place / "robot.toml").write_text('[robot]\nname = "one cell"\n', encoding="utf-8")


def _walks(place: Path) -> None:
    (place / "logs" / "one").mkdir(parents=True)
    for stream in ("cells", "body"):
        name = f"walk_004_{stream}.parquet"
        (place / "logs" / "one" / name).symlink_to(REPOSITORY / BIPED / name)
    recipe = (REPOSITORY / "recipes" / "nao_walk.toml").read_text(encoding="utf-8")
    (place / "robot.toml").write_text(recipe.split("[data]")[0], encoding="utf-8")


def _bag(place: Path) -> None:
    from tests.cli.foreign_logs import write_ros1

    start, step = 1_790_000_000_000_000_000, 10_000_000
    frames = {
        topic: pd.DataFrame({
            "time_ns": start + late + step * np.arange(20), name: np.linspace(0.0, 1.0, 20),
        })
        for topic, name, late in (("ft", "fz_n", 0), ("imu", "acc_z_mps2", 2_000_000))
    }  # fmt: skip
    write_ros1(place / "walk.bag", frames)


def _joints(place: Path) -> None:
    pytest.importorskip("mujoco")
    pytest.importorskip("pinocchio")
    from tests.cli.test_kinematics import TIME_S, joint_log, write

    write(place, joint_log(TIME_S[:400])).clear()
    pd.read_parquet(place / "joints.parquet").to_csv(place / "joints.csv", index=False)
    (place / "r.toml").rename(place / "robot.toml")


def _calibrated(place: Path) -> None:
    _weights(place)
    assert shell("footcal offline-fit my_log.csv --out out/cells") == 0


def _hung(place: Path) -> None:
    assert shell("footcal hang-calib --recipe recipes/hexapod.toml --out out/hang") == 0
    del place


def _public(place: Path) -> None:
    folder = os.environ.get("FOOTCAL_DATA")
    if not folder:
        pytest.skip("FOOTCAL_DATA is not set: no measured data at hand")
    for file in Path(folder).glob("*/*"):
        if not (place / file.name).exists():
            (place / file.name).symlink_to(file)


def _folders(place: Path) -> None:
    """The measured data in their folders, and the plates of the C3D file."""
    folder = os.environ.get("FOOTCAL_DATA")
    if not folder:
        pytest.skip("FOOTCAL_DATA is not set: no measured data at hand")
    for own in Path(folder).iterdir():
        (place / own.name).symlink_to(own)


def _plates(place: Path) -> None:
    _folders(place)
    assert shell("footcal convert loadsol-insoles/test_poids.c3d --out c3d") == 0


def _nothing(place: Path) -> None:
    del place


@dataclass(frozen=True)
class Case:
    """How a printed line is run: what is made before, what it lacks, and how it may end."""

    prepare: Callable[[Path], None] = _nothing
    more: str = ""
    instead: str = ""
    ends: tuple[int, ...] = (0,)
    slow: bool = field(default=True)


CASES: dict[str, Case] = {
    "footcal schema answer": Case(slow=False),
    "footcal init --help": Case(slow=False),
    "footcal init my_log.csv -o my.toml": Case(_weights, slow=False),
    "footcal offline-fit --recipe my.toml": Case(
        _described, slow=False
    ),
    "footcal apply walk.csv --parameters out/scale/parameters.json": Case(_scale, slow=False),
    "footcal convert walk.bag --list": Case(_bag, slow=False),
    "footcal convert walk.bag --out logs": Case(_bag, slow=False),
    "footcal convert walk.bag --topic /ft --topic /imu --join nearest --clock /ft "
    "--tolerance-s 0.01 --out logs/walk.parquet": Case(_bag, slow=False),
    "footcal convert SRC … --out FILE.parquet|DIR": Case(
        _weights, instead="footcal convert my_log.csv logs_1.csv --out converted", slow=False
    ),
    "footcal export PARAMETERS.json --to CONSUMER --out FILE": Case(
        _calibrated, instead="footcal export out/cells/parameters.json --to c-header --out cells.h",
        slow=False,
    ),
    "footcal batch sessions.csv --command offline-fit --recipe robot.toml --out out/fleet": Case(
        _fleet, slow=False
    ),
    "footcal batch sessions.csv --recipe robot.toml --command offline-fit --out out/fleet": Case(
        _fleet
    ),
    "footcal batch sessions.csv --command offline-fit --recipe robot.toml --out out/fleet "
    "--scheduler tcp://HOST:8786": Case(_fleet),
    "footcal batch 'logs/*' --recipe robot.toml --command online-replay --out out/fleet": Case(
        _walks
    ),
    "footcal kinematics joints.csv --urdf robot.urdf --recipe robot.toml --out out/kinematics": (
        Case(_joints)
    ),
    "footcal diagnose --plan": Case(
        more=f"--between imu_tilt --between accel_bias {NAO} --out out/plan"
    ),
    "footcal online-replay --causal": Case(
        more=f"{BIPED}/walk_004_cells.parquet {BIPED}/walk_004_body.parquet {NAO} --out out/causal"
    ),
    "footcal diagnose … → --parameters parameters_extended.json": Case(
        instead=f"footcal diagnose {BIPED}/walk_004_faulty_cells.parquet "
        f"{BIPED}/walk_004_faulty_body.parquet --experiment walk {NAO} --out out/extended"
    ),
    "footcal diagnose --experiment pose": Case(
        _hung,
        more="sample_data/hexapod/poses.parquet --recipe recipes/hexapod.toml "
        "--parameters out/hang/parameters.json --out out/pose",
    ),
    "footcal online-replay 14_1.csv --recipe recipes/reemc_walking.toml --out out/14_1": Case(
        _public
    ),
    "footcal diagnose 14_2.csv --recipe recipes/reemc_walking.toml --out out/why": Case(_public),
    "footcal static-init 14_1.csv --recipe recipes/reemc_walking.toml --until-s 1.0 "
    "--out out/second": Case(_public),
    "footcal static-init test_poids_loadsol.csv --recipe recipes/loadsol_insoles.toml "
    "--out out/insole": Case(_public),
    "footcal pose-calib trial3_four_ft.csv --recipe recipes/icub_four_ft.toml --out out/icub": (
        Case(_public, ends=(0, 3))
    ),
    "footcal offline-fit test2.csv --recipe recipes/loadcell_creep.toml --out out/creep": Case(
        _public, ends=(0, 1)
    ),
    "footcal offline-fit calibration_dataset.parquet --recipe recipes/insole_plenum.toml "
    "--out out/taxel": Case(_public, ends=(0, 1)),
    "footcal offline-fit points_frames.csv --recipe recipes/forceplate_cop_points.toml "
    "--out out/plate": Case(_public, ends=(0, 1, 3)),
    "footcal init loadcell-creep/test2.csv -o my.toml": Case(_folders),
    "footcal init insole-plenum/calibration_dataset.parquet -o my.toml": Case(_folders),
    "footcal init loadsol-insoles/test_poids_loadsol.csv -o my.toml": Case(_folders),
    "footcal init forceplate-cop-points/points_frames.csv -o my.toml": Case(_folders),
    "footcal convert loadsol-insoles/test_poids.c3d --out c3d": Case(_folders),
    # with blanks filled in: tests/real/test_from_raw_files.py
    "footcal static-init --recipe my.toml": Case(
        instead=f"footcal static-init {BIPED}/stand_cells.parquet {BIPED}/stand_body.parquet {NAO}",
        ends=(0, 3),
    ),
    "footcal init c3d/plate_*.parquet -o my.toml": Case(
        _plates, instead="footcal init c3d/plate_?.parquet -o my.toml"
    ),
}  # fmt: skip
"""Printed line, blanks made one -> how it is run."""


def _lines() -> set[str]:
    """Every printed line that neither a followed block nor a recipe of the README holds."""
    pages = [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").rglob("*.md"))]
    followed = {
        " ".join(line.split())
        for page in PAGES
        for block in blocks(page)
        if block.language == "sh"
        for line in commands(block)
    }
    printed = {" ".join(line.split()) for page in pages for line in printed_commands(page)}
    on_recipes = {line for line in printed if set(line.split()) & set(SAVED_AS.values())}
    return printed - followed - on_recipes


def test_every_printed_command_is_followed_or_has_a_case() -> None:
    lines = _lines()
    assert lines <= set(CASES), sorted(lines - set(CASES))
    assert set(CASES) <= lines, sorted(set(CASES) - lines)


def follow_line(line: str, case: Case, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("recipes", "sample_data"):
        (place / name).symlink_to(REPOSITORY / name)
    monkeypatch.chdir(place)
    case.prepare(place)
    words = shlex.split(f"{case.instead or line} {case.more}")
    shown = [str(p) for w in words for p in (sorted(Path().glob(w)) if "?" in w else [w])]
    if "tcp://HOST:8786" in words:
        distributed = pytest.importorskip("distributed")
        with distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster:
            shown[shown.index("tcp://HOST:8786")] = cluster.scheduler_address
            assert shell(shlex.join(shown)) in case.ends
        return
    assert shell(shlex.join(shown)) in case.ends


@pytest.mark.parametrize("line", [line for line, case in CASES.items() if not case.slow])
def test_a_printed_line_runs(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    follow_line(line, CASES[line], tmp_path, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("line", [line for line, case in CASES.items() if case.slow])
def test_a_longer_printed_line_runs(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    follow_line(line, CASES[line], tmp_path, monkeypatch)
