"""From a plan to a log: truth by physics, noise by chance, distortion by the chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.noise import SimulatedNoise, added_to_readings
from footcal_cli.core.simulation.robots import Biped


@dataclass(frozen=True)
class Simulated:
    """A log and everything that was true of it.

    Parameters
    ----------
    truth
        True loads and true known quantities, without noise.
    log
        What was logged: readings in counts (newtons where nothing is calibrated) and beliefs.
    chain, values
        The effects and their sizes by full parameter name.
    """

    truth: Log
    log: Log
    chain: Chain
    values: Mapping[str, float]


def measure(
    planned: Log,
    loads: Callable[[Log], FloatArray],
    chain: Chain,
    values: Mapping[str, float],
    *,
    force_noise: SimulatedNoise,
    torque_noise: SimulatedNoise,
    rng: np.random.Generator,
) -> Simulated:
    """Measure a plan with sensors that a chain distorts.

    Parameters
    ----------
    planned
        What the experimenter believes; its readings are not used.
    loads
        True loads (n, c) of a log whose known quantities are true.
    """
    # the plan is what is believed, and the truth is off by the correction
    beliefs = Chain(tuple(item for item in chain.links if Trait.BELIEF in item.effect.traits))
    real, _ = beliefs.remove(planned, values)
    truth = real.with_readings(loads(real))
    noisy = added_to_readings(truth, force_noise, torque_noise, rng)
    shown, _ = chain.apply(noisy, values)
    return Simulated(truth, shown, chain, values)


def counted(log: Log, robot: Biped) -> Log:
    """Readings as the robot's converter gives them: whole counts within its range.

    They stay as they are where the logger writes forces (`Biped.converts`).
    """
    if not robot.converts:
        return log
    return log.with_readings(np.clip(np.rint(log.readings), *robot.codes))
