"""Two streams on two clocks made one log: [NAO], sections 2.2 and 4.1."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N
from footcal_cli.core.contact import (
    ContactRule,
    Validity,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import (
    CUTOFF_HZ,
    Clock,
)


@dataclass(frozen=True)
class SensorStream:
    """What the feet show, on their clock.

    Parameters
    ----------
    time_s
        Shape (n,).
    readings
        Counts of cells, or newtons and newton metres of transducers, NaN where lost, shape (n, c).
    """

    time_s: FloatArray
    readings: FloatArray
    channels: tuple[str, ...]


@dataclass(frozen=True)
class BodyStream:
    """What the robot knows of itself, on its own clock.

    Parameters
    ----------
    time_s
        Shape (m,).
    com_m, com_acc_mps2
        Shape (m, 3); heights above the ground. An acceleration that is nowhere known (NaN) is
        the CoM's second derivative, or the first one of its velocity.
    angmom_rate_nm
        Shape (m, 2).
    feet_m, feet_yaw_rad
        Shape (m, feet, 3) and (m, feet).
    feet_rot
        Foot frame to world, shape (m, feet, 3, 3); only six-axis feet need it.
    imu_acc_mps2, imu_gyro_radps
        Shape (m, 3); None where the log has none.
    com_vel_mps
        Velocity of the CoM, shape (m, 3); None where the log has none.
    angmom_nms
        Angular momentum about the CoM, shape (m, 2), of which the rate is taken; None likewise.
    """

    time_s: FloatArray
    com_m: FloatArray
    com_acc_mps2: FloatArray
    angmom_rate_nm: FloatArray
    feet_m: FloatArray
    feet_yaw_rad: FloatArray
    feet_rot: FloatArray | None = None
    imu_acc_mps2: FloatArray | None = None
    imu_gyro_radps: FloatArray | None = None
    com_vel_mps: FloatArray | None = None
    angmom_nms: FloatArray | None = None

    def without_skipped(self) -> BodyStream:
        """Without the cycles that the estimator skipped: rows that say nothing of CoM and feet.

        Left in, one of them would spoil every yaw after it, which is counted on from row to row.
        """
        rows = len(self.time_s)
        said = np.isfinite(np.column_stack([self.com_m, self.feet_m.reshape(rows, -1)])).any(axis=1)
        if said.all() or not said.any():
            return self
        own = {name: value for name, value in vars(self).items() if value is not None}
        return replace(self, **{name: value[said] for name, value in own.items()})


@dataclass(frozen=True)
class MergeRule:
    """How streams are merged.

    Parameters
    ----------
    delay_s
        Fixed delay of the body stream, compensated (NAO: 20 ± 4 ms); 0 for an unknown robot.
    cutoff_hz
        Low-pass of forces, accelerations and angular momentum.
    causal
        Filter and tell contact without the future.
    largest_acc_mps2
        A CoM acceleration above this is not believed (saturation, impact).
    min_force_n
        ε of the CoP.
    """

    delay_s: float = 0.0
    cutoff_hz: float = CUTOFF_HZ
    causal: bool = False
    largest_acc_mps2: float = 8.0
    min_force_n: float = MIN_FORCE_N
    contact: ContactRule = field(default_factory=ContactRule)


@dataclass(frozen=True)
class Merged:
    """One log, and what was wrong with its streams.

    Parameters
    ----------
    log
        Filtered readings on the sensors' clock; rows that must not count are NaN.
    raw
        The same rows unfiltered.
    validity
        Which samples may count, and why not.
    sensor_clock, body_clock
        Repeated stamps, gaps.
    imu_acc_mps2, imu_gyro_radps
        On the sensors' clock, unfiltered; None where the log has none.
    """

    log: Log
    raw: FloatArray
    validity: Validity
    sensor_clock: Clock
    body_clock: Clock
    rate_hz: float
    imu_acc_mps2: FloatArray | None
    imu_gyro_radps: FloatArray | None

    @property
    def weight_n(self) -> float:
        """Weight that the feet carry, of the first sample, N."""
        known = self.log.known
        return float(known["mass_kg"][0] * known["gravity_mps2"][0])

    def part(self, start: int, stop: int) -> Merged:
        """Samples ``start:stop``; clocks and rate stay those of the whole."""
        cut = slice(start, stop)
        imu = (self.imu_acc_mps2, self.imu_gyro_radps)
        acc, gyro = (None if values is None else values[cut] for values in imu)
        return replace(
            self, log=self.log.rows(start, stop), raw=self.raw[cut],
            validity=replace(
                self.validity, valid=self.validity.valid[cut], reason=self.validity.reason[cut]
            ),
            imu_acc_mps2=acc, imu_gyro_radps=gyro,
        )  # fmt: skip
