"""The runs whose results are kept, and what is kept of each."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from footcal_cli.app import main
from tests.conftest import REPOSITORY

Kept = dict[str, Any]


@dataclass(frozen=True)
class Run:
    """A command line; ``@name`` stands for the calibration that the run of that name left.

    Parameters
    ----------
    name, words
        The run, and its command line without ``--out``.
    measured
        Whether its log is one of the measurements by others, in the folder FOOTCAL_DATA.
    quick
        Whether every test run compares it.
    """

    name: str
    words: tuple[str, ...]
    measured: bool = False
    quick: bool = False

    @property
    def starts_from(self) -> tuple[str, ...]:
        """Runs whose calibration it reads."""
        return tuple(word[1:] for word in self.words if word.startswith("@"))


def _run(name: str, words: str, **more: bool) -> Run:
    return Run(name, tuple(words.split()), **more)


BIPED, HEXAPOD = "sample_data/biped", "sample_data/hexapod"
NAO, SIX = "--recipe recipes/nao_walk.toml", "--recipe recipes/hexapod.toml"
RUNS = {
    run.name: run
    for run in (
        _run("table2", "offline-fit --recipe recipes/nao_table2.toml", quick=True),
        _run("table2_check", "check --recipe recipes/nao_table2.toml", quick=True),
        _run("bench", "offline-fit --recipe recipes/bench_foot.toml"),
        _run("bench_diagnosis", "diagnose --recipe recipes/bench_foot.toml "
             "sample_data/bench_foot/weights.csv --experiment weights"),
        _run("holes_diagnosis", "diagnose --recipe recipes/bench_foot.toml "
             "sample_data/bench_foot/placements.csv --experiment placements --parameters @bench"),
        _run("cells", f"offline-fit {NAO}"),
        _run("stand", f"static-init {BIPED}/stand_cells.parquet {BIPED}/stand_body.parquet {NAO} "
             "--parameters @cells"),
        _run("stand_diagnosis", f"diagnose {BIPED}/stand_cells.parquet "
             f"{BIPED}/stand_body.parquet --experiment stand {NAO} --parameters @cells"),
        _run("walk", f"online-replay {NAO} --parameters @cells"),
        *(_run(f"walk_{n}", f"online-replay {BIPED}/walk_{n}_cells.parquet "
               f"{BIPED}/walk_{n}_body.parquet {NAO} --parameters @cells")
          for n in ("002", "010", "004_faulty")),
        _run("walk_diagnosis", f"diagnose {BIPED}/walk_004_faulty_cells.parquet "
             f"{BIPED}/walk_004_faulty_body.parquet --experiment walk {NAO} --parameters @cells"),
        _run("walk_apply", f"apply {BIPED}/walk_002_cells.parquet {NAO} --parameters @cells"),
        _run("hang", f"hang-calib {SIX}"),
        _run("hang_stepwise", f"hang-calib {SIX} --method stepwise"),
        _run("hang_diagnosis", f"diagnose {HEXAPOD}/hang.parquet --experiment hang {SIX}"),
        _run("pose", f"pose-calib {SIX} --parameters @hang"),
        _run("pose_offsets", f"pose-calib {HEXAPOD}/tripod.parquet {SIX} --fit offsets "
             "--parameters @pose"),
        _run("pose_diagnosis", f"diagnose {HEXAPOD}/poses.parquet --experiment pose {SIX} "
             "--parameters @pose"),
        _run("legs_apply", f"apply {HEXAPOD}/walk.parquet {SIX} --parameters @pose"),
        _run("nao_simulated", "simulate --recipe recipes/nao_simulated.toml"),
        _run("hexapod_simulated", "simulate --recipe recipes/hexapod_simulated.toml"),
        _run("force_plate", "offline-fit $DATA/forceplate-cop-points/points_frames.csv "
             "--recipe recipes/forceplate_cop_points.toml", measured=True),
        _run("creep", "offline-fit $DATA/loadcell-creep/test2.csv "
             "--recipe recipes/loadcell_creep.toml", measured=True),
        _run("creep_diagnosis", "diagnose $DATA/loadcell-creep/test2.csv --experiment weights "
             "--recipe recipes/loadcell_creep.toml", measured=True),
        _run("loadsol", "static-init $DATA/loadsol-insoles/test_poids_loadsol.csv "
             "--recipe recipes/loadsol_insoles.toml", measured=True),
        _run("icub", "pose-calib $DATA/icub-four-ft/trial3_four_ft.csv "
             "--recipe recipes/icub_four_ft.toml", measured=True),
        _run("reemc", "online-replay $DATA/reemc-walking/14_1.csv "
             "--recipe recipes/reemc_walking.toml", measured=True),
        _run("reemc_diagnosis", "diagnose $DATA/reemc-walking/14_1.csv "
             "--recipe recipes/reemc_walking.toml", measured=True),
    )
}  # fmt: skip


class Cabinet:
    """Run folders made on demand, each once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._done: dict[str, int] = {}

    def kept(self, name: str) -> Kept:
        """What is kept of a run, which is done first where it was not yet."""
        code = self._run(name)
        return kept_of(self.folder / name, code)

    def _run(self, name: str) -> int:
        if name not in self._done:
            run, out = RUNS[name], self.folder / name
            for earlier in run.starts_from:
                self._run(earlier)
            words = [self._word(word) for word in run.words]
            self._done[name] = _exit_code([*words, "--out", str(out), "--quiet", "--no-pictures"])
        return self._done[name]

    def _word(self, word: str) -> str:
        if word.startswith("@"):
            return str(next((self.folder / word[1:]).glob("parameters*.json")))
        if word.startswith("$DATA"):
            return word.replace("$DATA", os.environ["FOOTCAL_DATA"])
        here = REPOSITORY / word
        return str(here) if "/" in word and here.exists() else word


def _exit_code(words: Sequence[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(list(words))
    return int(end.value.code or 0)


def kept_of(folder: Path, exit_code: int) -> Kept:
    """What is kept of a run folder: numbers with sd, names exactly, no wording and no timings."""
    run = _read(folder / "run.json")
    kept: Kept = {
        "exit_code": exit_code,
        "level": run["verdict"]["level"],
        "findings": sorted({f"{f['code']} {f['where']}" for f in run["findings"]}),
        "gates_missed": len(run["gates_missed"]),
    }
    for path in sorted(folder.glob("parameters*.json")):
        found = _read(path)["parameters"]
        kept[path.stem] = {k: [p["value"], p["sd"], p["status"]] for k, p in found.items()}
    if (folder / "rmse.json").exists():
        found = _read(folder / "rmse.json")
        kept["rmse"] = {
            " | ".join(str(row[k]) for k in ("quantity", "stage", "reference", "split")): row[
                "rmse"
            ]
            for row in found["rows"]
        }
        kept["rejected"] = found["rejected"]
    if (folder / "diagnosis.json").exists():
        found = _read(folder / "diagnosis.json")
        kept["verdict"] = found["verdict"]
        kept["causes"] = {f"{c['effect']} of {c['where']}": [c["size"], c["sd"], "-"]
                          for c in found["causes"]}  # fmt: skip
        kept["credible_sets"] = [sorted(rivals) for rivals in found["rivals"]]
        kept["effects"] = {row["effect"]: row["status"] for row in found["effects"]}
    if (folder / "truth.json").exists():
        true = _read(folder / "truth.json")["parameters"]
        kept["truth"] = {name: [value, None, "true"] for name, value in true.items()}
    return kept


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
