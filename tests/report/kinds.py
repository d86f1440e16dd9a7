"""A report of every kind, made of the sample data: the command line of each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BIPED, HEXAPOD = ROOT / "sample_data/biped", ROOT / "sample_data/hexapod"
NAO = ("--recipe", ROOT / "recipes/nao_walk.toml", "--parameters", "@cells")
SIX = ("--recipe", ROOT / "recipes/hexapod.toml", "--parameters", "@hang")
SIMULATED = (
    "simulate", "--experiment", "walk", "--recipe", ROOT / "recipes/nao_simulated.toml",
)  # fmt: skip
RUNS: dict[str, tuple[str | Path, ...]] = {
    "check": ("check", "--recipe", ROOT / "recipes/nao_table2.toml"),
    "cells": ("offline-fit", "--recipe", ROOT / "recipes/nao_walk.toml"),
    "foot": ("offline-fit", "--recipe", ROOT / "recipes/bench_foot.toml"),
    "stand": ("static-init", BIPED / "stand_cells.parquet", BIPED / "stand_body.parquet", *NAO),
    "walk": ("online-replay", "--compare", *NAO),
    "hang": ("hang-calib", "--recipe", ROOT / "recipes/hexapod.toml"),
    "pose": ("pose-calib", *SIX),
    "apply": ("apply", BIPED / "walk_002_cells.parquet", *NAO),
    "apply to legs": ("apply", HEXAPOD / "walk.parquet", *SIX[:2], "--parameters", "@pose"),
    "batch": (
        "batch", BIPED / "walk_002_cells.parquet", BIPED / "walk_010_cells.parquet",
        "--command", "apply", *NAO,
    ),
    "simulate": ("simulate", "--recipe", ROOT / "recipes/nao_simulated.toml"),
    "fleet": ("batch", ROOT / "sample_data/fleet/sessions.csv", "--command", "offline-fit"),
    "stuck log": (*SIMULATED, "--effect", "right_fl.channel_stuck=1"),
    "check a stuck log": ("check", "@stuck log/cells.parquet", *SIMULATED[3:]),
    "diagnose weights": (
        "diagnose", ROOT / "sample_data/bench_foot/weights.csv",
        "--experiment", "weights", "--recipe", ROOT / "recipes/bench_foot.toml",
    ),
    "diagnose a walk": (
        "diagnose", BIPED / "walk_004_faulty_cells.parquet", BIPED / "walk_004_faulty_body.parquet",
        "--experiment", "walk", *NAO,
    ),
    "diagnose none": (
        "diagnose", BIPED / "walk_002_cells.parquet", BIPED / "walk_002_body.parquet",
        "--experiment", "walk", *NAO,
    ),
    "tilted log": (*SIMULATED, "--effect", "imu_tilt=0.01"),
    "diagnose a set": (
        "diagnose", "@tilted log/cells.parquet", "@tilted log/body.parquet", "--experiment", "walk",
        *NAO,
    ),
    "diagnose bad data": (
        "diagnose", "@stuck log/cells.parquet", "@stuck log/body.parquet", "--experiment", "walk",
        *NAO,
    ),
    "unnamed log": (
        "simulate", "--experiment", "weights", "--effect", "soft_seat=0.3",
        "--recipe", HERE / "soft_seat.toml",
    ),
    "diagnose unknown": (
        "diagnose", "@unnamed log/weights.parquet", "--experiment", "weights",
        "--recipe", HERE / "no_seat.toml",
    ),
    "plan": (
        "diagnose", "--plan", "--between", "imu_tilt", "--between", "accel_bias", *NAO[:2],
    ),
}  # fmt: skip
"""A report of every kind; ``@name`` is the calibration of the run of that name, ``@name/file`` a
file of it."""


def words_of(name: str, run: Callable[[str], Path]) -> list[str]:
    """The command line of a kind; ``run`` makes the run that another one starts from, a folder."""
    words = []
    for text in map(str, RUNS[name]):
        start, _, file = text.removeprefix("@").partition("/")
        words.append(str(run(start) / (file or "parameters.json")) if text[0] == "@" else text)
    return words
