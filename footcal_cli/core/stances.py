"""Means of quiet standing: what each stance says of the linear rows, and what it is worth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.rows import Rows, cell_rows
from footcal_cli.core.online.six_axis import six_axis_rows
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.signals import autocorrelation_time

FORCE_SHARE, LEVER_SHARE, SWING_SHARE = 0.0015, 0.002, 0.003
"""What a stance's mean is worth at best: force by the robot's weight, lever about the CoM by the
CoM's height, as cells that were calibrated hole by hole are left with ([NAO], Table 3: 0.08 N of
53 N, 0.5 mm under a CoM at 0.26 m); by the weight a lifted cell, on which cables and a loose sole
pull."""
_USUAL_HEIGHT_M = 0.25
"""Of a CoM that nobody logged: that of [NAO]."""
COM_SHARE = 0.004
"""Sd of where the model has the CoM, as a share of its height, the same in every stance: masses of
links are some per cent off, and an inertial unit leans by milliradians."""


@dataclass(frozen=True)
class StanceRows:
    """Means of the linear rows over each stance.

    Parameters
    ----------
    h
        Shape (rows, p), columns in prior sd.
    error
        With the believed calibration, shape (rows,).
    sd
        Noise of each row's mean, shape (rows,).
    output
        Name of each row's balance.
    stance
        Shape (rows,).
    names, units, prior_sd, prior_correlation
        Of the unknowns.
    effective_samples
        Independent samples behind each stance's mean force, shape (stances,).
    shared
        Errors of one sd that all stances have in common (the model's CoM ahead, and to the left),
        shape (rows, m).
    floors
        What a stance does not average out: force (N), moment (Nm), lifted cell (N).
    """

    h: FloatArray
    error: FloatArray
    sd: FloatArray
    output: tuple[str, ...]
    stance: IntArray
    names: tuple[str, ...]
    units: tuple[str, ...]
    prior_sd: FloatArray
    prior_correlation: FloatArray
    effective_samples: FloatArray
    shared: FloatArray
    floors: tuple[float, float, float]

    @property
    def whitened(self) -> FloatArray:
        """Rows in units of their noise."""
        return self.h / self.sd[:, None]

    def only(self, keep: BoolArray) -> StanceRows:
        """Some of the rows."""
        return replace(
            self,
            h=self.h[keep],
            error=self.error[keep],
            sd=self.sd[keep],
            output=tuple(name for name, kept in zip(self.output, keep, strict=True) if kept),
            stance=self.stance[keep],
            shared=self.shared[keep],
        )


def stance_rows(
    log: Log,
    quiet: QuietSet,
    belief: Belief,
    *,
    force_sd_n: float | None = None,
    moment_sd_nm: float | None = None,
    swing_sd_n: float | None = None,
    com_sd_m: float | None = None,
) -> StanceRows:
    """Average the static balance over each stance.

    The scatter of the mean counts by its effective sample size; the errors that a stance does not
    average out (posture, creep) are the given floors. A CoM that the model puts in a wrong place
    is wrong in every stance alike: no number of them averages it out.

    Parameters
    ----------
    log
        Raw counts.
    quiet
        From `select_quiet`.
    force_sd_n, moment_sd_nm, swing_sd_n
        Floors of total force, moments and lifted cells; where None, `FORCE_SHARE` of the weight,
        `LEVER_SHARE` of the CoM's height times the weight, and `SWING_SHARE` of the weight.
    com_sd_m
        Sd of the model's CoM along each of the body's horizontal axes; `COM_SHARE` of its height
        where None.
    """
    if com_sd_m is None:
        com_sd_m = COM_SHARE * _height_of(log) if np.isfinite(log.known["com_m"]).any() else 0.0
    rows = cell_rows(
        log, belief, samples_per_update=1, states=_COM, plate=False, static=True,
        state_sd=dict.fromkeys(_COM, com_sd_m),
    )  # fmt: skip
    own = floors_of(weight_of(log), _height_of(log))
    force = own[0] if force_sd_n is None else force_sd_n
    moment = own[1] if moment_sd_nm is None else moment_sd_nm
    swing = own[2] if swing_sd_n is None else swing_sd_n
    each = [force, moment, moment] + [swing] * len(log.channels)
    means = stance_means(rows, quiet, np.array(each), (force, moment, swing))
    return _shared_out(means, np.array([name in _COM for name in rows.names]))


def floors_of(weight_n: float, height_m: float) -> tuple[float, float, float]:
    """Floors of total force (N), moments (Nm) and lifted cells (N) of a robot's stances."""
    return FORCE_SHARE * weight_n, LEVER_SHARE * height_m * weight_n, SWING_SHARE * weight_n


def _height_of(log: Log) -> float:
    """Mean height of the CoM, m; `_USUAL_HEIGHT_M` where nobody logged it."""
    height = log.known["com_m"][:, 2]
    seen = height[np.isfinite(height)]
    return float(np.abs(seen).mean()) if seen.size else _USUAL_HEIGHT_M


def weight_of(log: Log) -> float:
    """What the feet carry in a log, N."""
    return float(np.mean(log.known["mass_kg"] * log.known["gravity_mps2"]))


DATA_SHEET = 0.01
"""Sd of the scale of each axis of a six-axis transducer, as a share of it."""
_COM = ("robot.com_correction_x", "robot.com_correction_y")


def _shared_out(rows: StanceRows, common: BoolArray) -> StanceRows:
    """Rows with some of the unknowns, shape (p,), as errors that all stances share."""
    own = ~common
    return replace(
        rows,
        h=rows.h[:, own],
        names=tuple(name for name, keep in zip(rows.names, own, strict=True) if keep),
        units=tuple(unit for unit, keep in zip(rows.units, own, strict=True) if keep),
        prior_sd=rows.prior_sd[own],
        prior_correlation=rows.prior_correlation[np.ix_(own, own)],
        shared=rows.h[:, common],
    )


def six_axis_stance_rows(log: Log, quiet: QuietSet, mass_share_sd: float) -> StanceRows:
    """Average the balance of six-axis feet over each stance.

    A scale is off by what a data sheet allows, in all stances alike; floors as for cells. What
    stands is the stated mass: of it and of all offsets together, moments show little.

    Parameters
    ----------
    mass_share_sd
        Sd of the stated mass as a share of it.
    """
    mass_sd = mass_share_sd * float(np.mean(log.known["mass_kg"]))
    rows = six_axis_rows(
        log, samples_per_update=1, mass=True, walking=False,
        prior_sd={"scale": DATA_SHEET, "mass_correction": mass_sd},
    )  # fmt: skip
    floors = floors_of(weight_of(log), _height_of(log))
    force, moment, lifted = floors
    totals = [force] * 3 + [moment] * 2
    swing = lifted * rows.swing_sd_factor
    means = stance_means(rows, quiet, np.concatenate([totals, swing]), floors)
    return _shared_out(means, np.array([".scale_" in name for name in rows.names]))


def stance_means(
    rows: Rows, quiet: QuietSet, each: FloatArray, floors: tuple[float, float, float]
) -> StanceRows:
    """Average rows, one per sample, over each stance.

    Parameters
    ----------
    each
        What a stance does not average out of each output, shape (k,).
    floors
        The same by kind: force, moment, lifted cell.
    """
    h, error, sd, output, stance, worth = [], [], [], [], [], []
    for number in range(quiet.stances):
        inside = quiet.stance == number
        tau = autocorrelation_time(rows.error[inside, 0])
        worth.append(float(inside.sum() / tau))
        for k, name in enumerate(rows.outputs):
            use = inside & rows.valid[:, k]
            if use.sum() < inside.sum() / 2:
                continue
            h.append(rows.h[use, k].mean(axis=0))
            error.append(rows.error[use, k].mean())
            spread = np.std(rows.error[use, k]) / np.sqrt(use.sum() / tau)
            sd.append(np.hypot(spread, each[k]))
            output.append(name)
            stance.append(number)
    return StanceRows(
        h=np.array(h).reshape(-1, len(rows.names)),
        error=np.array(error),
        sd=np.array(sd),
        output=tuple(output),
        stance=np.array(stance, dtype=np.int64),
        names=rows.names,
        units=rows.units,
        prior_sd=rows.prior_sd,
        prior_correlation=rows.prior_correlation,
        effective_samples=np.array(worth),
        shared=np.zeros((len(error), 0)),
        floors=floors,
    )
