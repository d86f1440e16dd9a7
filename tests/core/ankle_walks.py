"""A humanoid on ankle transducers walks: logs whose truth is known, for tests of core and CLI."""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.measure import Simulated
from footcal_cli.core.simulation.noise import SimulatedNoise
from tests.core.ankle_simulation import (
    Ankles,
    humanoid,
    six_axis_channels,
    six_axis_feet_log,
)

ROBOT = humanoid()
CHANNELS = six_axis_channels(ROBOT)
ANKLES = Ankles(
    force_noise=SimulatedNoise(1.0, 1.0, 0.5), torque_noise=SimulatedNoise(0.1, 0.1, 0.5),
    com_noise_m=5e-4, acc_noise_mps2=0.05, angmom_noise_nm=1.0,
)  # fmt: skip


def ankle_walk(
    seed: int,
    duration_s: float,
    offsets: Mapping[str, float],
    effects: Mapping[str, Mapping[str, float]],
) -> tuple[Simulated, dict[str, float]]:
    """A calm walk read with these offsets and effects; and the true values of its chain.

    Parameters
    ----------
    offsets
        By channel, as ``left.fz``, N or Nm.
    effects
        Parameters by effect, as ``{"delay": {"robot.delay": 0.03}}``.
    """
    values = {
        f"{foot}.offset_{axis}": offsets[f"{foot}.{axis}"]
        for foot, axis in (channel.split(".") for channel in CHANNELS)
    }
    links = [link(TABLE["offset"], CHANNELS)]
    for name, parameters in effects.items():
        owners = sorted({full.split(".")[0] for full in parameters})
        links.append(link(TABLE[name], CHANNELS, owners))
        values |= parameters
    plan = WalkPlan(
        duration_s=duration_s, speed_mps=0.2, step_s=1.0, stand_s=2.0, bob_m=0.012,
        angmom_rate_nm=6.0, variation_m=0.01, variation_seed=seed,
    )  # fmt: skip
    done = six_axis_feet_log(
        "walk", ROBOT, lambda t: walking(ROBOT, plan, t), duration_s, chain_of(links), values,
        seed=seed, ankles=ANKLES,
    )  # fmt: skip
    return done, values
