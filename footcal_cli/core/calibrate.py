"""The calibrations from arrays, one call per experiment, with results of one shape.

``from footcal_cli.core import calibrate``; each function names its arrays as a log names its
columns, with their shapes, in SI units.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from footcal_cli.core.bench.cop_study import CopStudy, study_cop
from footcal_cli.core.bench.placement_rows import PlacementRows, holes_of
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import ChannelStudy, study_rows
from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.hang.intake import hang_log
from footcal_cli.core.hang.joint import HangFit, HangOptions, fit_hang
from footcal_cli.core.inference.earlier import LEAST_P, with_earlier
from footcal_cli.core.online.belief import Belief, belief_from, nameplate
from footcal_cli.core.online.memory import Memory, MemoryOptions, memory_estimates, run_memory
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.noise import starting_noise
from footcal_cli.core.online.streams import BodyStream, Merged, SensorStream
from footcal_cli.core.parameters import Estimates, FloatArray, IntArray
from footcal_cli.core.pose.data import Geometry, PoseData, summarise
from footcal_cli.core.pose.hanging import leg_knowledge
from footcal_cli.core.pose.joint import PoseFit, fit_pose
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.quiet import select_quiet
from footcal_cli.core.stances import stance_rows
from footcal_cli.core.static_init import StaticInit, fit_static, without_false_lifts
from footcal_cli.errors import FitError

__all__ = [
    "Belief", "BodyStream", "Calibration", "Geometry", "HangOptions", "PoseOptions",
    "SensorStream", "belief_from", "hang", "nameplate", "placements", "poses", "stand", "walk",
    "weights",
]  # fmt: skip

GRAVITY_MPS2 = 9.80665
UPDATE_HZ = 20.0
"""Samples of a walk are taken together to about this many updates per second."""

FitT = TypeVar("FitT")


@dataclass(frozen=True)
class Calibration(Generic[FitT]):
    """What a calibration found.

    Parameters
    ----------
    estimates
        Named parameters with units, status and joint covariance.
    fit
        All else that this kind of fit knows.
    """

    estimates: Estimates
    fit: FitT

    def counted_with(self, earlier: Estimates, apart: Collection[str] = ()) -> Estimates:
        """The estimates with an earlier calibration as prior, joint covariance included.

        Parameters
        ----------
        earlier
            From logs that this calibration has not seen.
        apart
            Names that mean something else every time: the tilts of a hanging.

        Raises
        ------
        FitError
            Both differ by more than chance explains: something has changed.
        """
        found = with_earlier([self.estimates], earlier, apart)
        if found.p < LEAST_P:
            raise FitError(
                f"two calibrations differ by more than chance explains (p = {found.p:.1g})",
                remedy="find out what has changed since the earlier one",
            )
        return found.estimates[0]

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the parameters, in their order and units, shape (n,)."""
        return self.estimates.sd

    def summary(self) -> str:
        """One line per parameter: name, value ± sd, unit, status."""
        return self.estimates.summary()


def weights(
    channel: str,
    load_n: FloatArray,
    counts: FloatArray,
    *,
    time_s: FloatArray | None = None,
    session: IntArray | None = None,
    temperature_degc: FloatArray | None = None,
) -> Calibration[ChannelStudy]:
    """Scale and bias of a cell from settled readings of known weights, ``F = scale · S + bias``.

    What else the readings support (a polynomial, hysteresis, creep …) is fitted with them.

    Parameters
    ----------
    load_n, counts
        Shape (n,), in the order of recording.
    time_s, session, temperature_degc
        Shape (n,), where recorded: creep needs stamps, repeatability sessions.
    """
    known = np.arange(counts.size, dtype=float) if time_s is None else time_s
    whole = np.zeros(counts.size, dtype=np.int64) if session is None else session
    record = BenchRecord(
        channel, load_n, counts, known, whole, temperature_degc, timed=time_s is not None
    )
    study = study_rows(record)
    return Calibration(study.estimates, study)


def placements(
    cells: Sequence[str],
    cell_pos_m: FloatArray,
    force_n: FloatArray,
    hole_m: FloatArray,
    load_n: FloatArray,
) -> Calibration[CopStudy]:
    """Corrections of one foot's cell positions from a weight put over known holes.

    The best physical correction on placements left out; polynomials stand in `fit`.

    Parameters
    ----------
    cell_pos_m
        Assumed positions of the cells in the foot frame, shape (c, 2).
    force_n
        Calibrated forces of the cells, shape (n, c).
    hole_m, load_n
        Where the weight acts, shape (n, 2), and what it is, shape (n,).

    Raises
    ------
    FitError
        The placements are too few for any physical correction.
    """
    study = study_cop(
        PlacementRows(tuple(cells), force_n, cell_pos_m, hole_m, load_n, holes_of(hole_m))
    )
    best = None if study.physical is None else study.results[study.physical].parameters
    if best is None:
        raise FitError(
            "the placements are too few to find where the cells are",
            remedy="place the weight over more holes",
        )
    return Calibration(best, study)


def stand(
    sensors: SensorStream,
    body: BodyStream,
    belief: Belief,
    cells_foot_m: Sequence[FloatArray],
    mass_kg: float,
    *,
    gravity_mps2: float = GRAVITY_MPS2,
) -> Calibration[StaticInit]:
    """Scales and biases of the feet's cells as far as quiet standing shows them.

    Parameters
    ----------
    sensors, body
        Counts of the cells, foot by foot, and the robot's motion, each on its own clock.
    belief
        Calibration to start from: an earlier one (`belief_from`), or the data sheet (`nameplate`).
    cells_foot_m
        Cell positions in each foot's frame, shape (cells, 2) per foot.
    """
    merged = _merged(sensors, body, belief, cells_foot_m, mass_kg, gravity_mps2, "stand")
    forces = belief.forces(merged.log.readings)
    quiet = select_quiet(merged.log, forces, gyro_radps=merged.imu_gyro_radps)
    fit = fit_static(without_false_lifts(stance_rows(merged.log, quiet, belief)), belief)
    return Calibration(fit.estimates, fit)


def walk(
    sensors: SensorStream,
    body: BodyStream,
    belief: Belief,
    cells_foot_m: Sequence[FloatArray],
    mass_kg: float,
    *,
    gravity_mps2: float = GRAVITY_MPS2,
) -> Calibration[Memory]:
    """Scales and biases of the feet's cells at the end of a walk; `fit` has them along it.

    Parameters
    ----------
    sensors, body, belief, cells_foot_m, mass_kg
        As in `stand`.
    """
    merged = _merged(sensors, body, belief, cells_foot_m, mass_kg, gravity_mps2, "walk")
    idle = channel_contact(merged.log) == 0.0
    raw_n = merged.raw * np.abs(belief.scale_n_per_count)
    options = MemoryOptions(
        noise=starting_noise(raw_n, idle, mass_kg * gravity_mps2),
        samples_per_update=max(round(merged.rate_hz / UPDATE_HZ), 1),
    )
    memory = run_memory(merged.log, belief, options)
    return Calibration(memory_estimates(memory, belief), memory)


def hang(
    leg: str,
    time_s: FloatArray,
    phase_rad: FloatArray,
    wrench: FloatArray,
    gravity_dir: FloatArray,
    leg_weight_n: float,
    options: HangOptions | None = None,
) -> Calibration[HangFit]:
    """Offsets of a hanging leg's six-axis transducer, its weight and CoM, and its tilt.

    Parameters
    ----------
    time_s, phase_rad
        Stamps and shaft angle, shape (n,), one orientation after the other.
    wrench
        Readings fx fy fz tx ty tz, shape (n, 6), N and Nm.
    gravity_dir
        Nominal direction of gravity in the transducer frame, shape (n, 3).
    leg_weight_n
        Believed weight below the transducer.
    options
        What to fit; all that the logs support where None.
    """
    log = hang_log(leg, time_s, phase_rad, wrench, gravity_dir, leg_weight_n=leg_weight_n)
    fit = fit_hang([log], options)
    return Calibration(fit.estimates, fit)


def poses(
    geometry: Geometry,
    hanging: Sequence[Calibration[HangFit]],
    wrench: FloatArray,
    phase_rad: FloatArray,
    rot_wb: FloatArray,
    robot_weight_n: float,
    noise_sd: FloatArray | None = None,
    options: PoseOptions | None = None,
) -> Calibration[PoseFit]:
    """How K hip transducers are mounted, from standing poses and what hanging said of each leg.

    Parameters
    ----------
    hanging
        From `hang`, per leg in the order of the geometry.
    wrench
        Readings, shape (P, K, 6), N and Nm.
    phase_rad
        Shaft angles, shape (P, K).
    rot_wb
        Body to world, shape (P, 3, 3).
    noise_sd
        Noise of a pose's readings, shape (6,); None: the fit estimates it.
    options
        What is free, and priors.
    """
    legs = tuple(leg_knowledge(one.fit) for one in hanging)
    data = PoseData(
        geometry,
        wrench,
        phase_rad,
        -rot_wb[:, 2, :],
        rot_wb,
        np.full(wrench.shape[:2], np.nan),
        robot_weight_n,
        np.array([leg.weight_n for leg in legs]),
        np.arange(wrench.shape[0]),
    )
    sd = np.repeat([0.05, 0.005], 3) if noise_sd is None else noise_sd
    asked = options or PoseOptions(noise_known=noise_sd is not None)
    fit = fit_pose(summarise(data), legs, np.tile(sd, (len(legs), 1)), asked)
    return Calibration(fit.estimates(), fit)


def _merged(
    sensors: SensorStream,
    body: BodyStream,
    belief: Belief,
    cells_foot_m: Sequence[FloatArray],
    mass_kg: float,
    gravity_mps2: float,
    experiment: str,
) -> Merged:
    cells = tuple(cells_foot_m)
    return merge_cells(sensors, body, belief, cells, mass_kg, gravity_mps2, experiment=experiment)
