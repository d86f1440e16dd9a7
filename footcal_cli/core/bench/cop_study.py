"""Which CoP correction the placements support, and how far it can be trusted.

Every number that matters is an error at a placement the fit has not seen. The same fits without
one placement give the covariance of the physical parameters (delete-one-group jackknife) and the sd
of a corrected CoP, ``sd² = a² + (b / Fz)²``: force noise shrinks with the load, the rest does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.bench.cop_kinds import GAIN_MODELS, MODELS, CopModel
from footcal_cli.core.bench.cop_models import CopFit, fit_cop
from footcal_cli.core.bench.placement_rows import PlacementRows
from footcal_cli.core.effects.cells import CROSSTALK
from footcal_cli.core.effects.foot import CELL_POSITION
from footcal_cli.core.inference.held_out import Choice, HeldOut, choose, folds
from footcal_cli.core.inference.linear import variance_shares
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, Status
from footcal_cli.core.signals import root_mean_square
from footcal_cli.errors import FitError

RIDGES = (0.0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Penalties tried where the empirical design is badly conditioned."""
ILL_CONDITIONED = 30.0
"""Condition number of the standardised design from which a ridge is looked for."""
_MOST_FOLDS = 40


@dataclass(frozen=True)
class CopResult:
    """One correction, its errors on and off the fit, and its uncertainty.

    Parameters
    ----------
    fit
        On all placements that are not held out.
    cop_rmse_m
        On those placements: root mean squared distance of the CoP.
    left_out
        CoP errors with the row's own placement left out, shape (m, 2), with its placement.
    left_out_total
        The same for the vertical force, shape (m,); NaN where the weight is unknown.
    floor_m, force_noise_nm
        a and b of the sd of a corrected CoP per axis, shape (2,) each.
    parameters
        Physical models: cell corrections, crosstalk or scales with jackknife covariance.
    groups
        Placements behind all this.
    """

    fit: CopFit
    cop_rmse_m: float
    left_out: HeldOut
    left_out_total: HeldOut
    floor_m: FloatArray
    force_noise_nm: FloatArray
    parameters: Estimates | None
    groups: int

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.fit.model.name

    def cop_sd_m(self, rows: PlacementRows) -> FloatArray:
        """Sd of a corrected CoP at a new placement, shape (n, 2)."""
        lightness = 1.0 / np.fmax(rows.total_n, rows.min_force_n)
        noise = self.force_noise_nm * (lightness if rows.cells else 0.0 * lightness)[:, None]
        return np.sqrt(self.floor_m**2 + noise**2)

    def extrapolated(self, rows: PlacementRows, fitted: PlacementRows) -> BoolArray:
        """Beyond the box of holes or the loads the correction was fitted on, shape (n,)."""
        cop = self.fit.cop_m(rows)
        low, high = fitted.hole_m.min(axis=0), fitted.hole_m.max(axis=0)
        slack = 0.02 * (high - low)
        with np.errstate(invalid="ignore"):
            outside = np.any((cop < low - slack) | (cop > high + slack), axis=1)
        if not rows.cells:
            return np.asarray(outside)
        return np.asarray(outside | (rows.total_n > 1.02 * fitted.total_n.max()))


@dataclass(frozen=True)
class CopStudy:
    """All corrections compared on one foot.

    Parameters
    ----------
    results
        In order of complexity.
    choice
        One-standard-error rule over placements; indices into `results`. CoP and vertical force
        count alike, each in units of the best model's error.
    physical, empirical
        Positions of the best physical and the best empirical correction, None where not tried.
    cop_gain_m2, force_gain_n2
        Mean squared left-out error of the best empirical minus that of the best physical model,
        over placements, each with the standard error of this difference.
    """

    results: tuple[CopResult, ...]
    choice: Choice
    physical: int | None
    empirical: int | None
    cop_gain_m2: tuple[float, float]
    force_gain_n2: tuple[float, float]

    @property
    def chosen(self) -> CopResult:
        """The correction the evidence supports."""
        return self.results[self.choice.chosen]

    def __getitem__(self, name: str) -> CopResult:
        return next(result for result in self.results if result.name == name)

    def verdict(self) -> str:
        """Physics or polynomial, in one sentence."""
        if self.physical is None or self.empirical is None:
            return f"chosen: {self.chosen.name}"
        best, other = self.results[self.physical], self.results[self.empirical]
        errors = (
            f"CoP {1e3 * best.left_out.rmse:.2f} mm against {1e3 * other.left_out.rmse:.2f} mm, "
            f"vGRF {best.left_out_total.rmse:.3g} N against {other.left_out_total.rmse:.3g} N "
            "on left-out placements"
        )
        gains = (("CoP", self.cop_gain_m2), ("vGRF", self.force_gain_n2))
        won = [name for name, (gain, sd) in gains if gain > 2.0 * sd]
        lost = [name for name, (gain, sd) in gains if gain < -2.0 * sd]
        physics, polynomial = f"the physical model ({best.name})", f"the polynomial ({other.name})"
        if won and not lost:
            return f"{physics} beats {polynomial} in {' and '.join(won)}: {errors}"
        if lost and not won:
            return f"{polynomial} beats {physics} in {' and '.join(lost)}: {errors}"
        return f"{physics} and {polynomial} cannot be distinguished: {errors}"


@dataclass(frozen=True)
class FootStudy:
    """Everything the placements say about one foot.

    Parameters
    ----------
    rows
        Placements that were fitted.
    study
        The corrections compared on them.
    held_out
        Placements kept apart from every fit, None where there are none.
    before
        All placements with the forces of an uncalibrated foot, None where nothing is known of it.
    """

    foot: str
    rows: PlacementRows
    study: CopStudy
    held_out: PlacementRows | None = None
    before: PlacementRows | None = None

    @property
    def estimates(self) -> Estimates | None:
        """Corrections of the cells where a physical model was chosen."""
        return self.study.chosen.parameters

    def effects(self) -> tuple[str, ...]:
        """Names of the effects that `estimates` are parameters of."""
        model = self.study.chosen.fit.model
        if not model.physical or model.places_known:
            return ()
        mixed = model.with_forces and not model.with_gains
        return (CELL_POSITION.name, CROSSTALK.name) if mixed else (CELL_POSITION.name,)

    def biases(self, known: FloatArray) -> FloatArray:
        """Biases of the cells by the chosen model, from those they had (N), shape (c,) both."""
        fit = self.study.chosen.fit
        found = known + fit.bias_corrections_n if fit.model.with_bias else known
        return np.asarray(fit.shares * found if fit.model.with_gains else found)


def study_cop(rows: PlacementRows, models: tuple[CopModel, ...] | None = None) -> CopStudy:
    """Fit and compare corrections by leaving out one placement after the other.

    Parameters
    ----------
    rows
        Placements of one foot, held-out ones already removed.
    models
        Alternatives, else all; those with more coefficients than placements can carry are not
        tried.

    Raises
    ------
    FitError
        Fewer than three placements with a CoP, or none with a load.
    """
    known = rows.load_n[np.isfinite(rows.load_n)]
    if known.size and not (known > 0).any():
        raise FitError(
            f"no load of the {known.size} placements is above 0 N (largest {known.max():.4g} N)",
            remedy="check the load column and its sign",
        )
    groups = np.unique(rows.placement[rows.valid]).size
    if groups < 3:
        raise FitError(
            f"{groups} placements with more than {rows.min_force_n:g} N cannot be left out one by "
            "one",
            remedy="place weights over at least three holes",
        )
    cells = len(rows.cells)
    if models is None:
        models = MODELS if rows.believed_scale is None else GAIN_MODELS
    tried = [
        m
        for m in models
        if m.coefficients(cells) <= 2 * (groups - 1) and (cells or not m.needs_cells)
    ]
    results = tuple(_study_one(model, rows) for model in tried)
    cost = [float(model.coefficients(cells)) for model in tried]
    order = np.argsort(cost, kind="stable")
    results = tuple(results[i] for i in order)
    usable = [i for i, r in enumerate(results) if r.fit.is_of_the_foot(rows.cell_pos_m)]
    errors = _joint_errors(results)
    picked = choose([errors[i] for i in usable], [sorted(cost)[i] for i in usable])
    choice = Choice(usable[picked.chosen], usable[picked.best])
    physical, empirical = (_best(results, usable, physical=p) for p in (True, False))
    cop_gain = force_gain = (0.0, 0.0)
    if physical is not None and empirical is not None:
        one, other = results[empirical], results[physical]
        cop_gain = gain_between(one.left_out, other.left_out)
        force_gain = gain_between(one.left_out_total, other.left_out_total)
    return CopStudy(results, choice, physical, empirical, cop_gain, force_gain)


def gain_between(worse: HeldOut, better: HeldOut) -> tuple[float, float]:
    """Difference of mean squared errors over groups and its standard error."""
    difference = worse.mse_by_group() - better.mse_by_group()
    return float(difference.mean()), float(difference.std(ddof=1) / np.sqrt(difference.size))


def _joint_errors(results: tuple[CopResult, ...]) -> list[HeldOut]:
    """Left-out errors of CoP and force, each over the smallest rmse that any model reaches."""
    cop = min(result.left_out.rmse for result in results)
    totals = [result.left_out_total.error for result in results]
    if not all(np.isfinite(total).all() for total in totals):
        return [result.left_out for result in results]
    force = min(result.left_out_total.rmse for result in results)
    return [
        HeldOut(
            np.column_stack([result.left_out.error / cop, result.left_out_total.error / force]),
            result.left_out.group,
        )
        for result in results
    ]


def _best(results: tuple[CopResult, ...], usable: list[int], *, physical: bool) -> int | None:
    """Position of the smallest CoP error among the physical or the empirical models."""
    at = [i for i in usable if results[i].fit.model.physical is physical]
    return min(at, key=lambda i: results[i].left_out.mse_by_group().mean()) if at else None


def _study_one(model: CopModel, rows: PlacementRows) -> CopResult:
    fit = fit_cop(model, rows)
    ridge = 0.0
    if not model.physical and fit.condition > ILL_CONDITIONED:
        ridge = _choose_ridge(model, rows)
        fit = fit_cop(model, rows, ridge)
    out, total_error, replicas = _leave_out(model, rows, ridge)
    used = rows.valid
    error = fit.cop_m(rows)[used] - rows.hole_m[used]
    floor, noise = _scatter(out.error, rows.total_n[used])
    return CopResult(
        fit=fit,
        cop_rmse_m=root_mean_square(np.linalg.norm(error, axis=1)),
        left_out=out,
        left_out_total=HeldOut(total_error, out.group),
        floor_m=floor,
        force_noise_nm=noise,
        parameters=_parameters(fit, rows, replicas) if model.physical else None,
        groups=int(np.unique(rows.placement).size),
    )


def _leave_out(
    model: CopModel, rows: PlacementRows, ridge: float
) -> tuple[HeldOut, FloatArray, list[CopFit]]:
    """Errors at left-out placements, and the fits that made them."""
    cop = np.full((len(rows), 2), np.nan)
    total = np.full(len(rows), np.nan)
    replicas = []
    for out in folds(rows.placement, _MOST_FOLDS):
        replica = fit_cop(model, rows.select(~out), ridge)
        replicas.append(replica)
        part = rows.select(out)
        cop[out], total[out] = replica.cop_m(part), replica.total_n(part)
    used = rows.valid
    error = cop[used] - rows.hole_m[used]
    # a fit that breaks down at a placement it has not seen counts as one that knows only the middle
    broken = ~np.isfinite(error).all(axis=1)
    error[broken] = (rows.hole_m[used] - rows.hole_m[used].mean(axis=0))[broken]
    return HeldOut(error, rows.placement[used]), (total - rows.load_n)[used], replicas


def _choose_ridge(model: CopModel, rows: PlacementRows) -> float:
    """The largest penalty within one standard error of the best, over left-out placements."""
    tried = [_leave_out(model, rows, ridge)[0] for ridge in RIDGES]
    # more penalty is less complex
    return RIDGES[choose(tried, [-ridge for ridge in RIDGES]).chosen]


def _scatter(error: FloatArray, total_n: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``error² = a² + (b / Fz)²`` per axis."""
    if not np.isfinite(total_n).all():
        return np.sqrt(np.mean(error**2, axis=0)), np.zeros(2)
    design = np.column_stack([np.ones_like(total_n), total_n**-2.0])
    found = np.sqrt([variance_shares(squared, design) for squared in error.T**2])
    return found[:, 0], found[:, 1]


def _parameters(fit: CopFit, rows: PlacementRows, replicas: list[CopFit]) -> Estimates:
    """Cell corrections (and crosstalk or scales), and their covariance.

    The jackknife over placements, and what the usual sizes of cells say where placements do not.
    """

    def read(one: CopFit) -> FloatArray:
        corrections = one.corrections_m(rows.cell_pos_m).ravel()
        return np.concatenate([corrections, mixed(one)]) if one.model.with_forces else corrections

    def mixed(one: CopFit) -> FloatArray:
        if rows.believed_scale is None or not one.model.with_gains:
            return one.crosstalk
        return one.shares * rows.believed_scale

    if fit.model.places_known:
        return _gains(fit, rows, replicas)
    names = [f"{cell}.cell_correction_{axis}" for cell in rows.cells for axis in "xy"]
    units = ["m"] * len(names)
    if fit.model.with_forces:
        kind, unit = ("scale", "N/count") if fit.model.with_gains else (CROSSTALK.size.name, "-")
        names += [f"{cell}.{kind}" for cell in rows.cells]
        units += [unit] * len(rows.cells)
    loose = np.array([read(one) for one in fit.moved_within_usual()]) - read(fit)
    covariance = _jackknife(np.array([read(one) for one in replicas])) + loose.T @ loose
    status = (Status.ESTIMATED,) * len(names)
    return Estimates(tuple(names), tuple(units), read(fit), covariance, status)


def _gains(fit: CopFit, rows: PlacementRows, replicas: list[CopFit]) -> Estimates:
    """Scales of cells that sit where they are believed, by the jackknife over placements."""
    scale = np.ones(len(rows.cells)) if rows.believed_scale is None else rows.believed_scale
    names = tuple(f"{cell}.scale" for cell in rows.cells)
    status = tuple(
        Status.ESTIMATED if share != 1.0 or not fit.model.single else Status.FIXED
        for share in fit.shares
    )
    covariance = _jackknife(np.array([one.shares for one in replicas]) * scale)
    return Estimates(names, ("N/count",) * len(names), fit.shares * scale, covariance, status)


def _jackknife(values: FloatArray) -> FloatArray:
    """Covariance (k, k) of k parameters by their values without each of n groups, (n, k)."""
    rest = values - values.mean(axis=0)
    return np.asarray((len(values) - 1) / len(values) * rest.T @ rest)
