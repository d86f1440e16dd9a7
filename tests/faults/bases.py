"""Small valid inputs, one folder per base case; every case of the corpus is one of them, bent."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Collection
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.app import main
from tests.conftest import REPOSITORY

SAMPLES = REPOSITORY / "sample_data"
RECIPES = REPOSITORY / "recipes"
CELLS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))


@dataclass(frozen=True)
class Base:
    """A command line that works, and the files that it reads.

    Parameters
    ----------
    name
        Also the name of its folder.
    words
        Command line without ``--out``; a word that is a file's name becomes its path.
    logs, recipe, parameters, model
        Names of the files that the mutations bend; empty where there is none.
    calibrates
        Whether a ``parameters.json`` comes out that mutations may not move in silence.
    out
        Name of what comes out.
    folder
        Whether that is a run folder.
    values_only
        A slow one: only values of its logs are bent.
    grows
        A stopped run leaves the sessions it has finished, and the next one goes on with them.
    """

    name: str
    words: tuple[str, ...]
    logs: tuple[str, ...] = ()
    recipe: str = ""
    parameters: str = ""
    model: str = ""
    calibrates: bool = False
    out: str = "out"
    folder: bool = True
    values_only: bool = False
    grows: bool = False

    @property
    def command(self) -> str:
        """The command's name."""
        return self.words[0]

    @property
    def files(self) -> tuple[str, ...]:
        """All inputs."""
        return tuple(
            name for name in (*self.logs, self.recipe, self.parameters, self.model) if name
        )


_BIPED = ("--recipe", "biped.toml", "--parameters", "cells.json", "--quiet")
_HEXAPOD = ("--recipe", "hexapod.toml", "--quiet")

BASES = {
    base.name: base
    for base in (
        Base(
            "weights", ("offline-fit", "weights.csv", "--recipe", "weights.toml", "--quiet"),
            ("weights.csv",), "weights.toml", calibrates=True,
        ),
        Base(
            "placements",
            ("offline-fit", "weights.csv", "placements.csv", "--recipe", "foot.toml", "--models",
             "affine", "--quiet"),
            ("weights.csv", "placements.csv"), "foot.toml", calibrates=True,
        ),
        Base(
            "placements_ladder",
            ("offline-fit", "weights.csv", "placements.csv", "--recipe", "foot.toml", "--quiet"),
            ("weights.csv", "placements.csv"), "foot.toml", calibrates=True, values_only=True,
        ),
        Base(
            "stream",
            ("offline-fit", "stream.csv", "--recipe", "biped.toml", "--models", "affine",
             "--quiet"),
            ("stream.csv",), "biped.toml", calibrates=True,
        ),
        Base(
            "stream_ladder", ("offline-fit", "stream.csv", "--recipe", "biped.toml", "--quiet"),
            ("stream.csv",), "biped.toml", calibrates=True, values_only=True,
        ),
        Base(
            "together", ("offline-fit", "together.csv", "--recipe", "biped.toml", "--quiet"),
            ("together.csv",), "biped.toml", calibrates=True,
        ),
        Base(
            "stand", ("static-init", "stand_cells.csv", "stand_body.csv", *_BIPED),
            ("stand_cells.csv", "stand_body.csv"), "biped.toml", "cells.json", calibrates=True,
        ),
        Base(
            "walk", ("online-replay", "walk_cells.csv", "walk_body.csv", *_BIPED),
            ("walk_cells.csv", "walk_body.csv"), "biped.toml", "cells.json", calibrates=True,
        ),
        Base(
            "hang", ("hang-calib", "hang.csv", *_HEXAPOD), ("hang.csv",), "hexapod.toml",
            calibrates=True,
        ),
        Base(
            "pose",
            ("pose-calib", "poses.csv", *_HEXAPOD, "--parameters", "legs.json", "--structure",
             "single"),
            ("poses.csv",), "hexapod.toml", "legs.json", calibrates=True,
        ),
        Base(
            "apply", ("apply", "walk_cells.csv", *_BIPED), ("walk_cells.csv",), "biped.toml",
            "cells.json",
        ),
        Base(
            "apply_legs",
            ("apply", "legs.csv", *_HEXAPOD, "--parameters", "legs.json"), ("legs.csv",),
            "hexapod.toml", "legs.json",
        ),
        Base("check_weights", ("check", "weights.csv", "--quiet"), ("weights.csv",)),
        Base(
            "check_walk",
            ("check", "walk_cells.csv", "walk_body.csv", "--recipe", "biped.toml", "--quiet"),
            ("walk_cells.csv", "walk_body.csv"), "biped.toml",
        ),
        Base("check_hang", ("check", "hang.csv", *_HEXAPOD), ("hang.csv",), "hexapod.toml"),
        Base(
            "diagnose",
            ("diagnose", "weights.csv", "--experiment", "weights", "--recipe", "weights.toml",
             "--parameters", "bench.json", "--no-pictures", "--quiet"),
            ("weights.csv",), "weights.toml", "bench.json",
        ),
        Base(
            "diagnose_walk",
            ("diagnose", "walk_cells.csv", "walk_body.csv", "--experiment", "walk", *_BIPED,
             "--no-pictures"),
            ("walk_cells.csv", "walk_body.csv"), "biped.toml", "cells.json",
        ),
        Base(
            "simulate",
            ("simulate", "--experiment", "weights", "--recipe", "biped.toml", "--quiet"),
            recipe="biped.toml",
        ),
        Base("effects", ("effects",)),
        Base("schema", ("schema",)),
        Base(
            "export", ("export", "cells.json", "--to", "c-header", "--quiet"),
            parameters="cells.json", out="cells.h", folder=False,
        ),
        Base(
            "convert", ("convert", "forces.mot", "--quiet"), ("forces.mot",), out="forces.parquet",
            folder=False,
        ),
        Base(
            "convert_lines", ("convert", "messages.jsonl", "--quiet"), ("messages.jsonl",),
            out="messages.parquet", folder=False,
        ),
        Base(
            "batch",
            ("batch", "weights.csv", "--command", "offline-fit", "--recipe", "weights.toml",
             "--workers", "1", "--quiet"),
            ("weights.csv",), "weights.toml", grows=True,
        ),
    )
}  # fmt: skip
if all(find_spec(name) for name in ("mujoco", "pinocchio")):
    BASES["kinematics"] = Base(
        "kinematics",
        ("kinematics", "joints.csv", "--recipe", "joints.toml", "--urdf", "robot.urdf", "--quiet"),
        ("joints.csv",), "joints.toml", model="robot.urdf",
    )  # fmt: skip


def build(folder: Path, bases: Collection[Base]) -> Path:
    """Write the files of base cases into one folder; keep one that is complete."""
    done = folder / "complete"
    if done.is_file():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    _recipes(folder)
    _bench(folder)
    _biped(folder)
    _hexapod(folder)
    _foreign(folder)
    if any(base.model for base in bases):
        _joints(folder)
    for name, words in {
        "cells.json": ("offline-fit", "biped_weights.csv", "--models", "affine"),
        "bench.json": ("offline-fit", "weights.csv", "--models", "affine"),
        "legs.json": ("hang-calib", "hang.csv", "--recipe", "hexapod.toml"),
    }.items():
        if all(base.parameters != name for base in bases):
            continue
        out = folder / f"made_{name}"
        code = call([str(folder / w) if (folder / w).is_file() else w for w in words], out)
        made = out / "parameters.json"
        if code not in (0, 1) or not made.is_file():
            raise RuntimeError(f"the base case of {name} failed with exit code {code}")
        made.rename(folder / name)
        shutil.rmtree(out)
    done.touch()
    return folder


def call(words: list[str], out: Path) -> int:
    """Run footcal in this process; its exit code."""
    try:
        main([*words, "--quiet", "--out", str(out)])
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 1
    return 0


def _recipes(folder: Path) -> None:
    def rewritten(source: str, target: str, change: Callable[[str], str]) -> None:
        text = (RECIPES / source).read_text("utf-8")
        head, data, tail = text.partition("[data]\n")
        rest = tail.partition("\n[")[2]
        (folder / target).write_text(change(head + (f"[{rest}" if rest else "")), "utf-8")
        assert data

    rewritten("nao_walk.toml", "biped.toml", str)
    rewritten("hexapod.toml", "hexapod.toml", str)
    rewritten("bench_foot.toml", "foot.toml", str)
    rewritten("bench_foot.toml", "weights.toml", _affine_only)


def _bench(folder: Path) -> None:
    bench = pd.read_csv(SAMPLES / "bench_foot" / "weights.csv")
    bench.to_csv(folder / "weights.csv", index=False)
    placed = pd.read_csv(SAMPLES / "bench_foot" / "placements.csv")
    few = placed[placed.groupby(["placement", "load_n"]).cumcount() < 1]
    few.to_csv(folder / "placements.csv", index=False)
    rng = np.random.default_rng(11)
    scale, zero = -3.41e-5, 8.3e6
    time_s = np.arange(0.0, 120.0, 0.25)
    load_n = np.repeat([0.0, 10.0, 20.0, 30.0, 20.0, 10.0, 0.0, 15.0], 60)
    stream = {"time_s": time_s, "load_n": load_n}
    together: dict[str, object] = {}
    for name in CELLS:
        own = scale * (1 + 0.02 * rng.standard_normal())
        noise = 300 * rng.standard_normal(load_n.size)
        stream[f"{name}_counts"] = np.rint(zero + load_n / own + noise)
        loads = np.round(rng.uniform(0, 30, 60), 4)
        together[f"{name}_load_n"] = loads
        together[f"{name}_counts"] = np.rint(zero + loads / own + 300 * rng.standard_normal(60))
    pd.DataFrame(stream).to_csv(folder / "stream.csv", index=False)
    pd.DataFrame(together).to_csv(folder / "together.csv", index=False)


def _biped(folder: Path) -> None:
    def cut(source: str, target: str, until_s: float, every: int = 1) -> None:
        log = pd.read_parquet(SAMPLES / "biped" / source)
        log = log[log["time_s"] < until_s].iloc[::every]
        log.to_csv(folder / target, index=False)

    cut("stand_cells.parquet", "stand_cells.csv", 60.0, 4)
    cut("stand_body.parquet", "stand_body.csv", 60.5, 4)
    cut("walk_004_cells.parquet", "walk_cells.csv", 10.0)
    cut("walk_004_body.parquet", "walk_body.csv", 10.1)
    weights = pd.read_parquet(SAMPLES / "biped" / "weights.parquet")
    weights.iloc[::5].to_csv(folder / "biped_weights.csv", index=False)


def _hexapod(folder: Path) -> None:
    hang = pd.read_parquet(SAMPLES / "hexapod" / "hang.parquet")
    kept = hang.groupby(["orientation", "leg"]).cumcount() % 20 == 0
    hang[kept].to_csv(folder / "hang.csv", index=False)
    poses = pd.read_parquet(SAMPLES / "hexapod" / "poses.parquet")
    poses[poses["pose"].astype(int) % 9 == 0].to_csv(folder / "poses.csv", index=False)
    walk = pd.read_parquet(SAMPLES / "hexapod" / "walk.parquet")
    walk[walk["time_s"] < 5.0].iloc[:, :14].to_csv(folder / "legs.csv", index=False)


def _foreign(folder: Path) -> None:
    """A storage file of OpenSim, and messages as lines of JSON."""
    time_s = np.arange(200) / 100
    force_n = np.round(700 + 50 * np.sin(2 * np.pi * time_s), 3)
    head = f"forces\nversion=1\nnRows={time_s.size}\nnColumns=2\ninDegrees=no\nendheader\n"
    rows = "\n".join(f"{t:.2f}\t{f}" for t, f in zip(time_s, force_n, strict=True))
    (folder / "forces.mot").write_text(f"{head}time\tground_force_vy\n{rows}\n", "utf-8")
    lines = [
        json.dumps({"topic": "/ft", "stamp": t, "wrench": {"force": {"z": f}}})
        for t, f in zip(time_s, force_n, strict=True)
    ]
    (folder / "messages.jsonl").write_text("\n".join(lines) + "\n", "utf-8")


def _joints(folder: Path) -> None:
    """Joint positions of the biped of `sample_data/physics`, and its model."""
    from tests.core.urdf_robot import biped, joint_names, posture_at, write_urdf

    time_s = np.arange(0.0, 3.0, 0.01)
    q = np.array([posture_at(t) for t in time_s])
    log = {"time_s": time_s, **{f"base_{a}_m": q[:, i] for i, a in enumerate("xyz")}}
    log |= {f"base_q{a}": q[:, 3 + i] for i, a in enumerate("wxyz")}
    log |= {f"{name}_rad": q[:, 7 + i] for i, name in enumerate(joint_names(biped()))}
    pd.DataFrame(log).to_csv(folder / "joints.csv", index=False)
    write_urdf(folder)
    (folder / "joints.toml").write_text(
        '[robot]\nname = "biped"\nmass_kg = 5.3\n[kinematics.feet]\nleft = "left_sole"\n'
        'right = "right_sole"\n', "utf-8",
    )  # fmt: skip


def _affine_only(text: str) -> str:
    """The bench recipe without its placements."""
    return text.partition("[offline_fit]")[0] + '[offline_fit]\nmodels = "affine"\n'
