"""What is done in each simulated experiment, and how far robots differ from their drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from footcal_cli.core.simulation.bench_logs import PlacementsPlan, WeightsPlan
from footcal_cli.core.simulation.biped_logs import StandPlan, Streams
from footcal_cli.core.simulation.gait import WalkPlan
from footcal_cli.core.simulation.hexapod_logs import HangPlan, PosePlan
from footcal_cli.core.simulation.robots import Biped


@dataclass(frozen=True)
class Spread:
    """How far the simulated robot is from its nameplate and design, before any effect.

    Parameters
    ----------
    scale, bias_n
        Sd of the cells' scales (relative) and biases.
    hang_tilt_rad
        Sd of the tilt of each hanging, about each axis across gravity.
    mount_rotation_rad, mount_translation_m
        Sd of the transducers' mounting errors, per axis.
    """

    scale: float = 0.02
    bias_n: float = 0.3
    hang_tilt_rad: float = 0.035
    mount_rotation_rad: float = 0.02
    mount_translation_m: float = 0.003


@dataclass(frozen=True)
class Plans:
    """What is done in each experiment, and how the streams are sampled."""

    weights: WeightsPlan = field(default_factory=WeightsPlan)
    placements: PlacementsPlan = field(default_factory=PlacementsPlan)
    stand: StandPlan = field(default_factory=StandPlan)
    walk: WalkPlan = field(default_factory=WalkPlan)
    hang: HangPlan = field(default_factory=HangPlan)
    pose: PosePlan = field(default_factory=PosePlan)
    streams: Streams = field(default_factory=Streams)

    def of_size(self, robot: Biped, full_load_n: float | None = None) -> Plans:
        """The same plans for a robot of another weight: loads, forces and their noise go with it.

        Parameters
        ----------
        full_load_n
            Largest weight on a cell, where the usual share of the robot's is less.
        """
        usual = Biped()
        heavier = robot.weight_n / usual.weight_n
        moment = heavier * robot.length
        loads, s = self.weights.loads_n, self.streams
        more = max(heavier, (full_load_n or 0.0) / max(loads))
        return replace(
            self,
            weights=replace(
                self.weights, loads_n=_weights_n(loads, more),
                noise=self.weights.noise.of_range(heavier),
            ),
            placements=replace(
                self.placements, loads_n=_weights_n(self.placements.loads_n, heavier),
                noise=self.placements.noise.of_range(heavier),
            ),
            stand=replace(self.stand, squat_m=self.stand.squat_m * robot.length),
            walk=replace(self.walk, angmom_rate_nm=self.walk.angmom_rate_nm * moment),
            streams=replace(
                s,
                cell_noise=s.cell_noise.of_range(heavier),
                force_noise=s.force_noise.of_range(heavier),
                torque_noise=s.torque_noise.of_range(moment),
                angmom_noise_nm=s.angmom_noise_nm * moment,
            ),
        )  # fmt: skip

    def with_noise(self, factor: float) -> Plans:
        """The same plans with all noise larger or smaller."""
        s = self.streams
        return replace(
            self,
            weights=replace(self.weights, noise=self.weights.noise.scaled(factor)),
            placements=replace(self.placements, noise=self.placements.noise.scaled(factor)),
            hang=replace(
                self.hang,
                force_noise=self.hang.force_noise.scaled(factor),
                torque_noise=self.hang.torque_noise.scaled(factor),
            ),
            pose=replace(
                self.pose,
                force_noise=self.pose.force_noise.scaled(factor),
                torque_noise=self.pose.torque_noise.scaled(factor),
            ),
            streams=replace(
                s,
                cell_noise=s.cell_noise.scaled(factor),
                force_noise=s.force_noise.scaled(factor),
                torque_noise=s.torque_noise.scaled(factor),
                com_noise_m=s.com_noise_m * factor,
                acc_noise_mps2=s.acc_noise_mps2 * factor,
                angmom_noise_nm=s.angmom_noise_nm * factor,
            ),
        )


def _weights_n(loads_n: Sequence[float], factor: float) -> tuple[float, ...]:
    """Weights that are so many times as heavy, to three digits."""
    return tuple(load if factor == 1.0 else float(f"{factor * load:.3g}") for load in loads_n)
