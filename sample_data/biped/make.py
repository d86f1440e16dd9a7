"""Load cells on the physics engine's biped: counts, noise, telemetry, and the truth of it all.

Reads the motions of ``sample_data/physics/biped.py`` and writes the logs of this folder:

    python sample_data/physics/biped.py --out MOTION
    python sample_data/biped/make.py MOTION

Every load is the engine's contact force at the pad; scale, bias, noise, effects, converter and
telemetry are footcal's chain.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.core.simulation.bench_logs import WeightsPlan
from footcal_cli.core.simulation.biped_logs import Course, Streams, biped_logs
from footcal_cli.core.simulation.noise import CELL_NOISE
from footcal_cli.core.simulation.plans import Plans, Spread
from footcal_cli.core.simulation.recorded import recorded
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.core.simulation.scenario import (
    Scenario,
    biped_scenario,
    calibration,
    simulate,
    with_effects,
)
from footcal_cli.intake.scenario import parse_effect
from footcal_cli.records.files import write_record
from footcal_cli.records.results import EffectRecord, TruthRecord
from footcal_cli.tables.table import write_parquet

HERE = Path(__file__).resolve().parent
CALIBRATION_SEED = 11
#: What mounting did to the cells after the bench: relative sd of the scales, sd of the biases (N).
MOUNTED_SCALE, MOUNTED_BIAS_N = 0.02, 0.3
#: Log -> motion, experiment, seed of its noise, effects. One robot: the calibration is the same.
PLAN = {
    "stand": ("stand", "stand", 1, ()),
    "walk_002": ("walk_0.02", "walk", 2, ()),
    "walk_004": ("walk_0.04", "walk", 3, ()),
    "walk_010": ("walk_0.1", "walk", 4, ()),
    "walk_004_faulty": ("walk_0.04", "walk", 5, ("left_rr.hysteresis=0.8,hysteresis_reach=4",)),
}
DECIMALS = {"com_acc": 4, "com_": 6, "angmom": 5, "left_foot": 6, "right_foot": 6, "time": 6}


def rounded(name: str, values: np.ndarray) -> np.ndarray:
    """Digits that mean something, as float32 where six decimals fit; stamps stay float64."""
    if values.dtype.kind == "U":
        return values
    if values.dtype.kind in "iu":
        return values.astype(np.int32)
    decimals = next((d for start, d in DECIMALS.items() if name.startswith(start)), 4)
    short = np.round(values, decimals)
    return short if name == "time_s" else short.astype(np.float32)


def mounted(robot: Biped, bench: dict[str, float]) -> dict[str, float]:
    """Scales and biases in the feet: those of the bench, changed by mounting the cells."""
    rng = np.random.default_rng(CALIBRATION_SEED)
    values = {}
    for channel in robot.channels:
        scale, bias = bench[f"{channel}.scale"], bench[f"{channel}.bias"]
        at_zero_n = bias + scale * robot.zero_counts + MOUNTED_BIAS_N * rng.standard_normal()
        scale *= 1.0 + MOUNTED_SCALE * rng.standard_normal()
        values |= {
            f"{channel}.scale": float(scale),
            f"{channel}.bias": float(at_zero_n - scale * robot.zero_counts),
        }
    return values


def write_log(
    folder: Path, log: str, scenario: Scenario, robot: Biped, truth: dict[str, object]
) -> None:
    """The files of one log and what is true of it."""
    for stem, content in scenario.files.items():
        short = {name: rounded(name, np.asarray(v)) for name, v in content.items()}
        name = stem if stem == log else f"{log}_{stem}"
        write_parquet(pd.DataFrame(short), folder / f"{name}.parquet")
    record = TruthRecord(
        robot=asdict(robot),
        parameters=dict(scenario.values),
        effects=tuple(
            EffectRecord(effect=item.effect.name, owners=dict(item.owners))
            for item in scenario.chain.links
        ),
        **truth,
    )
    write_record(record, folder / f"{log}_truth.json")


def main() -> None:
    """Write the logs and their truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("motion", type=Path)
    parser.add_argument("--out", type=Path, default=HERE)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    robot = Biped()
    chain, bench = calibration(robot, Spread(), CALIBRATION_SEED)
    plans = Plans(weights=WeightsPlan(sessions=3))
    noise = {name: float(value) for name, value in asdict(CELL_NOISE).items()}
    weighed = simulate("weights", robot, plans, (), seed=CALIBRATION_SEED, given=bench)
    told = {"experiment": "weights", "seed": CALIBRATION_SEED, "noise": noise}
    write_log(options.out, "weights", weighed, robot, told)
    for log, (motion, experiment, seed, effects) in PLAN.items():
        table = pd.read_parquet(options.motion / f"motion_{motion}.parquet")
        columns = {name: table[name].to_numpy(float) for name in table}
        columns["time_s"] = columns["time_s"] - columns["time_s"][0]
        motion_at, loads_at = recorded(robot, columns)
        requests = [parse_effect(text) for text in effects]
        whole, values = with_effects(chain, mounted(robot, bench), requests, robot.channels)
        both = biped_logs(
            Course(experiment, robot, motion_at, float(columns["time_s"][-1]), loads_at),
            whole, values, seed=seed,
        )  # fmt: skip
        told = {
            "experiment": experiment,
            "seed": seed,
            "noise": noise,
            "details": {"motion": motion, "body_delay_s": Streams().body_delay_s},
        }
        write_log(options.out, log, biped_scenario(robot, both), robot, told)


if __name__ == "__main__":
    main()
