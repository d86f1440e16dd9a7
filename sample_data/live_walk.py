"""Calibrate while the robot walks: lines come one by one, as from a serial port.

    python sample_data/live_walk.py [SECONDS]

Replace `lines()` by a port: ``for line in serial.Serial("/dev/ttyACM0", 115200): …``. Both streams
must have the stamps of one clock.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.core.online.belief import nameplate
from footcal_cli.core.online.estimator import LiveEstimator
from footcal_cli.core.online.feed import LiveFeed, RobotFacts
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.noise import WalkNoise
from footcal_cli.core.online.streams import BodyStream, MergeRule, SensorStream

HERE = Path(__file__).parent / "biped"
CELLS = np.array([[0.07, 0.03], [0.07, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
CHANNELS = tuple(f"{foot}_{c}" for foot in ("left", "right") for c in ("fl", "fr", "rl", "rr"))
SCALE_N_PER_COUNT, ZERO_COUNTS = -3.41e-5, 8.32e6


def lines(seconds: float) -> Iterator[str]:
    """What the port would say: ``C,time,8 counts`` of the cells, ``B,time,16 numbers`` of the body.

    In the order of their stamps.
    """
    said = []
    for letter, name in (("C", "cells"), ("B", "body")):
        table = pd.read_parquet(HERE / f"walk_002_{name}.parquet").drop(
            columns="temperature_degc", errors="ignore"
        )
        table = table[table["time_s"] < seconds]
        for row in table.to_numpy():
            said.append((row[0], f"{letter},{','.join(map(repr, row.tolist()))}"))
    yield from (line for _, line in sorted(said))


def main(seconds: float) -> None:
    """Print the biases in N with their sd once a second."""
    scale = np.full(8, SCALE_N_PER_COUNT)
    belief = nameplate(CHANNELS, scale, -scale * ZERO_COUNTS)
    feed = LiveFeed(RobotFacts(belief, (CELLS, CELLS), mass_kg=5.3), rule=MergeRule(delay_s=0.02))
    estimator = LiveEstimator(belief, MemoryOptions(noise=WalkNoise()))
    next_s = 1.0
    for line in lines(seconds):
        letter, *numbers = line.split(",")
        row = np.array([float(number) for number in numbers])
        stamp, row = row[:1], row[1:]
        if letter == "C":
            rows = feed.push(sensors=SensorStream(stamp, row[None, :], CHANNELS))
        else:
            feet = row[8:].reshape(1, 2, 4)
            rows = feed.push(body=BodyStream(
                stamp, row[None, :3], row[None, 3:6], row[None, 6:8], feet[:, :, :3], feet[:, :, 3]
            ))  # fmt: skip
        if not len(rows):
            continue
        for update in estimator.push(rows):
            if update.time_s < next_s:
                continue
            next_s = update.time_s + 1.0
            at = [update.names.index(f"{name}.bias") for name in CHANNELS]
            biases = " ".join(
                f"{update.values[i]:+.3f}±{update.sd[i]:.3f}" for i in at
            )  # in N, on top of what the data sheet promises
            print(f"{update.time_s:6.1f} s  {biases}")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 12.0)
