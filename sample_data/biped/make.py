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

from footcal_cli.commands.simulate import parse_effect
from footcal_cli.core.simulation.biped_logs import Streams, biped_logs
from footcal_cli.core.simulation.recorded import recorded
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.core.simulation.scenario import Spread, biped_scenario, calibration, with_effects
from footcal_cli.records import EffectRecord, TruthRecord, write_record
from footcal_cli.tables import write_parquet

HERE = Path(__file__).resolve().parent
CALIBRATION_SEED = 11
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
    if values.dtype.kind in "iu":
        return values.astype(np.int32)
    decimals = next((d for start, d in DECIMALS.items() if name.startswith(start)), 4)
    short = np.round(values, decimals)
    return short if name == "time_s" else short.astype(np.float32)


def main() -> None:
    """Write the logs and their truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("motion", type=Path)
    parser.add_argument("--out", type=Path, default=HERE)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    robot = Biped()
    for log, (motion, experiment, seed, effects) in PLAN.items():
        table = pd.read_parquet(options.motion / f"motion_{motion}.parquet")
        columns = {name: table[name].to_numpy(float) for name in table}
        columns["time_s"] = columns["time_s"] - columns["time_s"][0]
        motion_at, loads_at = recorded(robot, columns)
        chain, values = calibration(robot, Spread(), CALIBRATION_SEED)
        requests = [parse_effect(text) for text in effects]
        chain, values = with_effects(chain, values, requests, robot.channels)
        streams = Streams()
        both = biped_logs(
            experiment, robot, motion_at, float(columns["time_s"][-1]), chain, values,
            seed=seed, streams=streams, loads_at=loads_at,
        )  # fmt: skip
        scenario = biped_scenario(robot, both)
        for stem, content in scenario.files.items():
            short = {name: rounded(name, np.asarray(v)) for name, v in content.items()}
            write_parquet(pd.DataFrame(short), options.out / f"{log}_{stem}.parquet")
        noise = asdict(streams.cell_noise)
        truth = TruthRecord(
            experiment=experiment,
            seed=seed,
            robot=asdict(robot),
            parameters=dict(scenario.values),
            effects=tuple(
                EffectRecord(effect=item.effect.name, owners=dict(item.owners))
                for item in chain.links
            ),
            noise={name: float(value) for name, value in noise.items()},
            details={"motion": motion, "body_delay_s": streams.body_delay_s},
        )
        write_record(truth, options.out / f"{log}_truth.json")


if __name__ == "__main__":
    main()
