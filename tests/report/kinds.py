"""A report of every kind, made of the sample data: the command line of each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIPED, HEXAPOD = ROOT / "sample_data/biped", ROOT / "sample_data/hexapod"
NAO = ("--recipe", ROOT / "recipes/nao_walk.toml", "--parameters", "@cells")
SIX = ("--recipe", ROOT / "recipes/hexapod.toml", "--parameters", "@hang")
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
    "diagnose weights": (
        "diagnose", ROOT / "sample_data/bench_foot/weights.csv",
        "--experiment", "weights", "--recipe", ROOT / "recipes/bench_foot.toml",
    ),
    "diagnose a walk": (
        "diagnose", BIPED / "walk_004_faulty_cells.parquet", BIPED / "walk_004_faulty_body.parquet",
        "--experiment", "walk", *NAO,
    ),
}  # fmt: skip
"""A report of every kind; ``@name`` is the calibration of the run of that name."""


def words_of(name: str, calibration: Callable[[str], Path]) -> list[str]:
    """The command line of a kind; ``calibration`` makes the run that another one starts from."""
    texts = [str(word) for word in RUNS[name]]
    return [str(calibration(text[1:])) if text.startswith("@") else text for text in texts]
