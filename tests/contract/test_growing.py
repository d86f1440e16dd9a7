"""Growing in a copy: an effect or an experiment touches one file, a command a file and a line."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EFFECT = """

def _bow(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x + theta["bow"] * np.tanh(x / 10.0), state


def _unbow(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    x = y.copy()
    for _ in range(60):
        x = y - theta["bow"] * np.tanh(x / 10.0)
    return x, state


BOW = Effect(
    name="bow",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("bow", "N", 0.0, -5.0, 5.0, 0.5),),
    apply=on_readings(_bow),
    remove=on_readings(_unbow),
    experiments=("weights",),
    formula="y = x + b tanh(x / 10 N)",
    source="this test",
    remedy="straighten it",
)
EFFECTS = (*EFFECTS, BOW)
"""
RECOVER = """
import numpy as np
from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.experiments.contract import residual
from footcal_cli.core.experiments.weights import EXPERIMENT
from footcal_cli.core.inference.fit import fit_map
from footcal_cli.core.log import Log

load = np.tile(np.linspace(0.0, 40.0, 21), 4)
chain = chain_of([link(TABLE["bow"], ("left_fl",))])
truth = Log("weights", ("left_fl",), np.arange(84.0), load[:, None], {"load_n": load},
            np.zeros(84, dtype=np.int64))
noise = np.random.default_rng(3).normal(0.0, 0.05, load.size)[:, None]
shown, _ = chain.apply(truth.with_readings(truth.readings + noise), {"left_fl.bow": 0.7})
free = chain.parameters()
sd = np.array([0.05])

def whitened(theta):
    error = residual(EXPERIMENT, chain, shown, dict(zip(free.names, theta)))
    return (error.error / sd)[error.valid]

fit = fit_map(whitened, free)
print(fit.estimates["left_fl.bow"], fit.estimates.sd_of("left_fl.bow"))
"""
EXPERIMENT = """
from footcal_cli.core.experiments.contract import Balance, Experiment


def balance(log):
    total = log.readings.sum(axis=1, keepdims=True) - log.known["weight_n"][:, None]
    return Balance(("fz",), ("N",), total, total == total)


KNOWN = {"weight_n": "who stands on all cells, N"}
EXPERIMENT = Experiment("scales", KNOWN, balance, ("scale_bias",))
"""
STAND_ON = """
from dataclasses import replace

import numpy as np
from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects.calibration import SCALE_BIAS
from footcal_cli.core.experiments.contract import residual
from footcal_cli.core.experiments.scales import EXPERIMENT
from footcal_cli.core.inference.fit import fit_map
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import ParameterSet

rng = np.random.default_rng(5)
cells, share = ("left_fl", "left_fr"), rng.uniform(0.1, 0.9, 200)
weight = rng.choice([0.0, 300.0, 600.0], 200)
true = {"left_fl.scale": 2e-3, "left_fl.bias": 1.0, "left_fr.scale": -1e-3, "left_fr.bias": -2.0}
force = np.stack([share * weight, (1.0 - share) * weight], axis=1)
log = Log("scales", cells, np.arange(200.0), force, {"weight_n": weight}, np.zeros(200, dtype=int))
chain = chain_of([link(SCALE_BIAS, cells)])
shown = chain.apply(log.with_readings(force + rng.normal(0.0, 0.5, force.shape)), true)[0]
begun = {name: 1.1 * value for name, value in true.items()}
free = ParameterSet(
    tuple(replace(p, value=begun.get(p.name, p.value)) for p in chain.parameters())
)
sd = np.array([0.5 * 2.0**0.5])


def whitened(theta):
    error = residual(EXPERIMENT, chain, shown, dict(zip(free.names, theta)))
    return (error.error / sd)[error.valid]


fit = fit_map(whitened, free)
for name in ("left_fl.scale", "left_fr.scale"):
    print((fit.estimates[name] - true[name]) / fit.estimates.sd_of(name))
print(fit.rank)
"""
COMMAND = '''"""``footcal greet``."""

import typer


def greet() -> None:
    """Say hello."""
    typer.echo("hello")
'''


@pytest.fixture(scope="module")
def grown(tmp_path_factory: pytest.TempPathFactory, repository: Path) -> Path:
    """A copy of the package with one more effect, experiment and command."""
    place = tmp_path_factory.mktemp("grown")
    package = place / "footcal_cli"
    shutil.copytree(repository / "footcal_cli", package, ignore=shutil.ignore_patterns("*.pyc"))
    with (package / "core" / "effects" / "cells.py").open("a", encoding="utf-8") as file:
        file.write(EFFECT)
    (package / "core" / "experiments" / "scales.py").write_text(EXPERIMENT, encoding="utf-8")
    (package / "commands" / "greet.py").write_text(COMMAND, encoding="utf-8")
    app = package / "app.py"
    line = 'COMMANDS = {\n    "greet": "Say hello.",\n'
    app.write_text(
        app.read_text(encoding="utf-8").replace("COMMANDS = {\n", line), encoding="utf-8"
    )
    return place


def python(place: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words], cwd=place, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(place)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_new_effect_is_fitted_through_the_one_residual(grown: Path) -> None:
    value, sd = map(float, python(grown, "-c", RECOVER).split())
    assert abs(value - 0.7) < 4.0 * sd < 0.1


def test_a_new_experiment_is_fitted_through_the_one_residual(grown: Path) -> None:
    """Who stands on two cells tells their scales; of two biases it tells the sum."""
    *errors, rank = map(float, python(grown, "-c", STAND_ON).split())
    assert rank == 3
    assert max(map(abs, errors)) < 4.0


def test_a_new_effect_can_be_simulated(grown: Path) -> None:
    words = ("simulate", "--experiment", "weights", "--effect", "left_fl.bow=0.7", "--quiet")
    python(grown, "-m", "footcal_cli", *words, "--no-pictures", "--out", "run")
    truth = json.loads((grown / "run" / "truth.json").read_text(encoding="utf-8"))
    assert truth["parameters"]["left_fl.bow"] == 0.7


@pytest.mark.slow
def test_a_new_effect_is_diagnosed_by_name(grown: Path) -> None:
    how = ("--experiment", "weights", "--quiet", "--no-pictures", "--out")
    python(grown, "-m", "footcal_cli", "simulate", "--effect", "left_fl.bow=3", *how, "hidden")
    python(grown, "-m", "footcal_cli", "diagnose", "hidden/weights.parquet", *how, "found")
    found = json.loads((grown / "found" / "diagnosis.json").read_text(encoding="utf-8"))
    (cause,) = found["causes"]
    assert (cause["effect"], cause["where"]) == ("bow", "left_fl")
    assert abs(cause["size"] - 3.0) < 4.0 * cause["sd"]


def test_a_new_command_runs_and_is_listed(grown: Path) -> None:
    assert python(grown, "-m", "footcal_cli", "greet") == "hello\n"
