"""Records that are linear in a few regressors, reduced to all that their likelihood needs.

A record w (n, c) with regressors z (n, d) is predicted as ``z Cᵀ``, with coefficients C(θ) that may
depend on the parameters in any way. Then ``‖W (w − z Cᵀ)‖²`` is ``‖R C − y‖²`` but for a constant,
with the triangular factor R of the whitened regressors: d numbers per channel, however long the
record is, and nothing is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from footcal_cli.core import chances
from footcal_cli.core.chain import Chain
from footcal_cli.core.experiments.contract import Experiment, residual
from footcal_cli.core.inference.autoregression import ChannelNoise
from footcal_cli.core.inference.fit import Fit, fit_map
from footcal_cli.core.inference.levels import LevelLaw, lasting_levels, whitening
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, ParameterSet

LEAST_NOISE = 1e-9
"""Noise of a channel against the noisiest: a dead one shows none at all."""
SEEN = 1e-7
"""Singular values below this share of the largest count as none."""
LEAST_FREEDOM, CHANCE = 0.5, 0.05
"""Degrees of freedom that a variance between records needs, and how improbable without it."""


@dataclass(frozen=True)
class Probe:
    """An experiment's residual that is linear in d regressors: it is known everywhere from d rows.

    Parameters
    ----------
    names
        Of the chain's parameters θ.
    log
        L records of d rows each.
    inverse
        Z⁻¹ of the regressors Z (d, d), row by row, which are those of every record.
    """

    experiment: Experiment
    chain: Chain
    names: tuple[str, ...]
    log: Log
    inverse: FloatArray

    @classmethod
    def of(
        cls,
        experiment: Experiment,
        chain: Chain,
        names: tuple[str, ...],
        log: Log,
        rows: FloatArray,
    ) -> Probe:
        """Of the regressors (d, d) of each record of a log."""
        return cls(experiment, chain, names, log, np.asarray(np.linalg.inv(rows), float))

    def errors(self, log: Log, theta: FloatArray) -> FloatArray:
        """The residual of any log of the experiment, shape (n, c)."""
        values = dict(zip(self.names, theta.tolist(), strict=True))
        return residual(self.experiment, self.chain, log, values).error

    def coefficients(self, theta: FloatArray) -> FloatArray:
        """C of the errors ``z Cᵀ`` of each record, shape (L, c, d)."""
        error = self.errors(self.log, theta)
        rows = error.reshape(-1, len(self.inverse), error.shape[1])
        return np.asarray((self.inverse @ rows).transpose(0, 2, 1))


@dataclass(frozen=True)
class Reduced:
    """All that the likelihood needs of L records of c channels.

    Parameters
    ----------
    factor
        Factor R of the whitened regressors, shape (L, c, d, d).
    target
        ``y``: the whitened records, turned likewise, shape (L, c, d).
    across
        What whitens the levels of each channel across records, shape (c, L, L); None: nothing.
    """

    factor: FloatArray
    target: FloatArray
    across: FloatArray | None = None

    @classmethod
    def of(
        cls,
        designs: Sequence[FloatArray],
        records: Sequence[FloatArray],
        noise: Sequence[ChannelNoise],
        triangles: Sequence[tuple[FloatArray, FloatArray]],
    ) -> Reduced:
        """Reduce records (n, c) with regressors (n, d), and their `triangle`."""
        columns, channels = designs[0].shape[1], len(noise)
        factor = np.zeros((len(designs), channels, columns, columns))
        target = np.zeros((len(designs), channels, columns))
        white = [channel for channel in range(channels) if noise[channel].is_white]
        coloured = [channel for channel in range(channels) if not noise[channel].is_white]
        sd = np.array([channel.innovation_sd for channel in noise])
        sd = np.maximum(sd, LEAST_NOISE * sd.max())
        room = np.empty((columns + 1, max(len(z) for z in designs)))
        for i, (z, w, (r, y)) in enumerate(zip(designs, records, triangles, strict=True)):
            factor[i, white] = r / sd[white, None, None]
            target[i, white] = y.T[white] / sd[white, None]
            rows = room[:, : len(z)]
            if coloured:
                rows[:-1] = z.T
            for channel in coloured:
                rows[-1] = w[:, channel]
                seen = noise[channel].products(rows)
                factor[i, channel], own = _triangle(seen[:-1, :-1], seen[:-1, -1:])
                target[i, channel] = own[:, 0]
        return cls(factor, target)

    def only(self, regressors: IntArray) -> Reduced:
        """The same records predicted by some of the regressors alone."""
        return Reduced(self.factor[..., regressors], self.target)

    def with_levels(self, sd: FloatArray) -> Reduced:
        """The same records, each with a random level of its own, ``b ~ N(0, sd²)`` per channel.

        With a = R e, e the first regressor, a constant, errors have covariance ``I + sd² a aᵀ``;
        they are whitened by ``I − s a aᵀ``, ``s = (1 − 1/√(1 + sd² |a|²)) / |a|²``.

        Parameters
        ----------
        sd
            Shape (c,), in the channels' units.
        """
        a = self.factor[..., 0]
        size = np.sum(a**2, axis=-1)
        share = (1.0 - 1.0 / np.sqrt(1.0 + sd**2 * size)) / np.where(size > 0.0, size, 1.0)
        along = share[..., None] * a
        return Reduced(
            self.factor
            - along[..., None] * np.einsum("lcd,lcde->lce", a, self.factor)[..., None, :],
            self.target - along * np.sum(a * self.target, axis=-1)[..., None],
        )

    def with_lasting_levels(self, covariance: FloatArray) -> Reduced:
        """The same records with random levels that are correlated across records.

        Parameters
        ----------
        covariance
            Of the levels of each channel, shape (c, L, L), in the channels' units squared.
        """
        size = np.sqrt(np.sum(self.factor[..., 0] ** 2, axis=-1))
        each = zip(size.T, covariance, strict=True)
        return replace(self, across=np.stack([whitening(*one) for one in each]))

    def _white(self, error: FloatArray) -> FloatArray:
        """Errors (L, c, d, …) with their levels whitened across records."""
        if self.across is None:
            return error
        a = self.factor[..., 0]
        size = np.sqrt(np.sum(a**2, axis=-1))
        unit = a / np.where(size > 0.0, size, 1.0)[..., None]
        level = np.einsum("lcd,lcd...->lc...", unit, error)
        moved = np.einsum("clk,kc...->lc...", self.across, level) - level
        return np.asarray(error + np.einsum("lcd,lc...->lcd...", unit, moved))

    def level_law(
        self,
        time_s: FloatArray,
        coefficients: FloatArray,
        slope: FloatArray,
        group: slice,
    ) -> LevelLaw | None:
        """How levels of a group of channels last from record to record, as `level_sd` sees them."""
        a = self.factor[:, group, :, 0]
        size = np.sqrt(np.sum(a**2, axis=-1))
        unit = a / np.where(size > 0.0, size, 1.0)[..., None]
        error = np.einsum("lcd,lcde,lce->lc", unit, self.factor[:, group], coefficients[:, group])
        error -= np.sum(unit * self.target[:, group], axis=-1)
        seen = np.einsum("lcd,lcde,lcep->lcp", unit, self.factor[:, group], slope[:, group])
        return lasting_levels(time_s, error, seen, size)

    def level_sd(
        self,
        coefficients: FloatArray,
        slope: FloatArray,
        covariance: FloatArray,
        groups: Sequence[slice],
        before: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Sd of the level of a record beyond its own noise, and its degrees of freedom.

        By moments: with u the error along a record's level, ``E u² = 1 + sd² |a|² − h``, h the
        variance that the parameters have along it. Slow drift, and whatever else changes from
        record to record, shows there and nowhere else: within a record it is the level. The sd
        solves ``Σ (u² + h) / (1 + sd² |a|²) = n`` (Paule and Mandel 1982): where it is far above
        the noise all levels count alike, however exact each is.

        Parameters
        ----------
        coefficients, slope
            C and its derivative at the fit, shapes (L, c, d) and (L, c, d, parameters).
        covariance
            Of the parameters, shape (parameters, parameters).
        groups
            Channels that share one sd: forces, torques.
        before
            The sd that the fit allowed for, shape (c,); None where it allowed for none.

        Returns
        -------
        Shape (c,) each; an sd is 0 where chance explains the levels. Few levels must differ by far
        more than their noise before chance is excluded.
        """
        a = self.factor[..., 0]
        size = np.sum(a**2, axis=-1)
        unit = a / np.sqrt(np.where(size > 0.0, size, 1.0))[..., None]
        error = np.einsum("lcd,lcde,lce->lc", unit, self.factor, coefficients)
        error -= np.sum(unit * self.target, axis=-1)
        seen = np.einsum("lcd,lcde,lcep->lcp", unit, self.factor, slope)
        fitted = np.einsum("lcp,pq,lcq->lc", seen, covariance, seen)
        sd, freedom = np.zeros((2, self.target.shape[1]))
        for group in groups:
            excess = float(np.sum(error[:, group] ** 2 - 1.0 + fitted[:, group]))
            if before is None:
                dof = float(np.sum(1.0 - fitted[:, group]))
                freedom[group] = max(dof, 1.0)
                chance = chances.chi2_sf(excess + dof, max(dof, LEAST_FREEDOM))
                sure = dof >= LEAST_FREEDOM and chance < CHANCE
            else:
                sure = bool(before[group].any())
            if sure:
                sd[group] = _spread(error[:, group] ** 2 + fitted[:, group], size[:, group])
        return sd, freedom

    def fit(
        self,
        parameters: ParameterSet,
        coefficients: Callable[[FloatArray], FloatArray],
        jacobian: Callable[[FloatArray], FloatArray],
        start: FloatArray | None = None,
    ) -> Fit:
        """Maximum a posteriori of parameters.

        Parameters
        ----------
        parameters
            Priors.
        coefficients, jacobian
            C(θ), shape (L, c, d), and its derivative, shape (L, c, d, parameters).
        start
            All parameters, shape (n,); the prior means where None.
        """

        def residual(theta: FloatArray) -> FloatArray:
            seen = (self.factor @ coefficients(theta)[..., None])[..., 0]
            return np.asarray(self._white(seen - self.target).ravel())

        def slope(theta: FloatArray) -> FloatArray:
            table = self._white(self.factor @ jacobian(theta))
            return np.asarray(table.reshape(self.target.size, theta.size))

        return fit_map(residual, parameters, jacobian=slope, start=start)


def _spread(square: FloatArray, size: FloatArray) -> float:
    """The sd s that solves ``Σ square / (1 + s² size) = n``; 0 where none is needed."""
    seen = size > 0.0
    square, size = square[seen], size[seen]
    if square.sum() <= square.size:
        return 0.0
    most = square.sum() / (square.size * size.min())

    def over(variance: float) -> float:
        return float(np.sum(square / (1.0 + variance * size))) - square.size

    return float(np.sqrt(optimize.brentq(over, 0.0, most)))


def triangle(
    z: FloatArray, w: FloatArray, gram: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """R (d, d) and y (d, c) with ``‖R c − y‖²`` equal to ``‖z c − w‖²`` but for a constant.

    `gram` is ``zᵀ z`` where it is known already.
    """
    return _triangle(z.T @ z if gram is None else gram, z.T @ w)


def _triangle(gram: FloatArray, cross: FloatArray) -> tuple[FloatArray, FloatArray]:
    """`triangle` of ``zᵀ z`` and ``zᵀ w``."""
    eigenvalues, vectors = np.linalg.eigh(gram)
    root = np.sqrt(np.clip(eigenvalues, 0.0, None))
    seen = root > SEEN * root[-1]
    factor = np.where(seen, root, 0.0)[:, None] * vectors.T
    inverse = np.where(seen, 1.0 / np.where(seen, root, 1.0), 0.0)
    return factor, inverse[:, None] * (vectors.T @ cross)
