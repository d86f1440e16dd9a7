"""The bench: known weights on single cells, and a weight on the holes of a foot's plate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.simulation.forces import shares
from footcal_cli.core.simulation.measure import Simulated, counted, measure
from footcal_cli.core.simulation.noise import CELL_NOISE, QUIET, SimulatedNoise, stream
from footcal_cli.core.simulation.robots import Biped

GRID_STEP_M = 0.02
GRID_COLUMNS, GRID_ROWS = 6, 3


@dataclass(frozen=True)
class WeightsPlan:
    """Known weights on one cell at a time.

    Parameters
    ----------
    loads_n
        Steps of the staircase, from the first to the last.
    up_and_down
        Come down the same steps.
    hold_s, sample_s
        How long each load stays, and the time between readings.
    sessions, pause_s
        Repetitions of the staircase and the unloaded time between.
    warming_degc_per_s
        Temperature rise while measuring, from 22 °C.
    pieces
        Of which pieces each load is made, bit by bit, where that is noted.
    """

    loads_n: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0)
    up_and_down: bool = True
    hold_s: float = 20.0
    sample_s: float = 2.0
    sessions: int = 3
    pause_s: float = 60.0
    warming_degc_per_s: float = 0.002
    noise: SimulatedNoise = CELL_NOISE
    pieces: tuple[int, ...] = ()

    def schedule(self) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
        """Stamps, loads, direction (+1 rising, −1 falling, 0 first) and session, shape (n,)."""
        down = self.loads_n[-2::-1] if self.up_and_down else ()
        steps = np.array([*self.loads_n, *down])
        rising = np.sign(np.diff(steps, prepend=steps[0]))
        readings = max(int(self.hold_s / self.sample_s), 1)
        once = np.arange(len(steps) * readings) * self.sample_s
        whole = len(steps) * self.hold_s + self.pause_s
        sessions = np.arange(self.sessions)
        return (
            (once + whole * sessions[:, None]).ravel(),
            np.tile(np.repeat(steps, readings), self.sessions),
            np.tile(np.repeat(rising, readings), self.sessions),
            np.repeat(sessions, len(once)),
        )


def weights_logs(
    robot: Biped,
    plan: WeightsPlan,
    chain: Chain,
    values: Mapping[str, float],
    *,
    seed: int,
    together: bool = False,
    to_counts: bool = True,
) -> dict[str, Simulated]:
    """A staircase of weights on every cell.

    Parameters
    ----------
    together
        One log with all channels, each loaded in turn while all are read (shows crosstalk);
        otherwise a log per channel.
    to_counts
        Round and clip to the converter's counts (the chain must hold the calibration).
    """
    groups = {"all": robot.channels} if together else {c: (c,) for c in robot.channels}
    logs = {name: _weigh(channels, plan, chain, values, seed) for name, channels in groups.items()}
    if not to_counts:
        return logs
    return {name: replace(done, log=counted(done.log, robot)) for name, done in logs.items()}


def _weigh(
    channels: tuple[str, ...],
    plan: WeightsPlan,
    chain: Chain,
    values: Mapping[str, float],
    seed: int,
) -> Simulated:
    time_s, load, direction, session = plan.schedule()
    rows, count = len(time_s), len(channels)
    whole = time_s[-1] + plan.hold_s + plan.pause_s
    on = np.repeat(np.eye(count), rows, axis=0)
    stamps = np.concatenate([time_s + whole * i for i in range(count)])
    stacks = {}
    if plan.pieces:
        of_load = dict(zip(plan.loads_n, plan.pieces, strict=True))
        stacks["pieces"] = np.tile([float(of_load[n]) for n in load.tolist()], count)
    planned = Log(
        "weights",
        channels,
        stamps,
        np.zeros((rows * count, count)),
        {
            "load_n": on * np.tile(load, count)[:, None],
            "temperature_degc": 22.0 + plan.warming_degc_per_s * stamps,
            "direction": np.tile(direction, count),
            **stacks,
        },
        np.tile(session, count),
    )
    return measure(
        planned,
        lambda log: log.known["load_n"],
        chain,
        values,
        force_noise=plan.noise,
        torque_noise=QUIET,
        rng=stream(seed, f"weights {'+'.join(channels)}"),
    )


@dataclass(frozen=True)
class PlacementsPlan:
    """A weight on each hole of a 20 mm grid (18 holes) of a foot's plate.

    Parameters
    ----------
    loads_n
        Weights put on every hole (1 g to 6 kg).
    repeats
        Readings of each placement.
    warming_degc_per_s
        How fast the cells warm up, from 22 °C.
    """

    loads_n: tuple[float, ...] = (0.00981, 0.981, 4.903, 19.61, 58.84)
    repeats: int = 20
    warming_degc_per_s: float = 0.0
    noise: SimulatedNoise = CELL_NOISE

    def holes_m(self, robot: Biped, foot: str) -> FloatArray:
        """The holes in the foot frame, shape (h, 2): those of the grid around its middle.

        Holes beyond the cells are left out; the grid is finer on a foot smaller than a NAO's.
        """
        x = (np.arange(GRID_COLUMNS) - 0.5 * (GRID_COLUMNS - 1)) * GRID_STEP_M
        y = (np.arange(GRID_ROWS) - 0.5 * (GRID_ROWS - 1)) * GRID_STEP_M
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        holes: FloatArray = robot.room * grid + robot.cells_m(foot).mean(axis=0)
        return holes[robot.within(foot, holes)]


def placements_log(
    robot: Biped,
    foot: str,
    plan: PlacementsPlan,
    chain: Chain,
    values: Mapping[str, float],
    *,
    seed: int,
    to_counts: bool = True,
) -> Simulated:
    """All placements on one foot; block: the placement (hole and weight)."""
    holes = plan.holes_m(robot, foot)
    place = np.arange(len(holes) * len(plan.loads_n))
    hole = np.tile(holes, (len(plan.loads_n), 1))
    load = np.repeat(np.array(plan.loads_n), len(holes))
    block = np.repeat(place, plan.repeats)
    cells = robot.cells_m(foot)
    channels = tuple(f"{foot}_{cell}" for cell in robot.feet[foot])
    time_s = 0.5 * np.arange(float(len(block)))
    planned = Log(
        "placements",
        channels,
        time_s,
        np.zeros((len(block), len(channels))),
        {
            "load_n": load[block],
            "hole_m": hole[block],
            "cell_pos_m": np.broadcast_to(cells, (len(block), *cells.shape)).copy(),
            "temperature_degc": 22.0 + plan.warming_degc_per_s * time_s,
        },
        block,
    )

    def loads(log: Log) -> FloatArray:
        arms = log.known["cell_pos_m"] - log.known["hole_m"][:, None]
        each: FloatArray = log.known["load_n"][:, None] * shares(arms)
        return each

    done = measure(
        planned,
        loads,
        chain,
        values,
        force_noise=plan.noise,
        torque_noise=QUIET,
        rng=stream(seed, f"placements {foot}"),
    )
    return replace(done, log=counted(done.log, robot)) if to_counts else done
