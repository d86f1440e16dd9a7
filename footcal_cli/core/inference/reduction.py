"""Records that are linear in a few regressors, reduced to all that their likelihood needs.

A record w (n, c) with regressors z (n, d) is predicted as ``z Cᵀ``, with coefficients C(θ) that may
depend on the parameters in any way. Then ``‖W (w − z Cᵀ)‖²`` is ``‖R C − y‖²`` but for a constant,
with the triangular factor R of the whitened regressors: d numbers per channel, however long the
record is, and nothing is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.autoregression import ChannelNoise
from footcal_cli.core.inference.fit import Fit, fit_map
from footcal_cli.core.parameters import FloatArray, IntArray, ParameterSet

SEEN = 1e-7
"""Singular values below this share of the largest count as none."""


@dataclass(frozen=True)
class Reduced:
    """All that the likelihood needs of L records of c channels.

    Parameters
    ----------
    factor
        Factor R of the whitened regressors, shape (L, c, d, d).
    target
        ``y``: the whitened records, turned likewise, shape (L, c, d).
    """

    factor: FloatArray
    target: FloatArray

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
        white = [channel for channel in range(channels) if noise[channel].ar.size == 0]
        coloured = [channel for channel in range(channels) if noise[channel].ar.size > 0]
        sd = np.array([channel.innovation_sd for channel in noise])
        for i, (z, w, (r, y)) in enumerate(zip(designs, records, triangles, strict=True)):
            factor[i, white] = r / sd[white, None, None]
            target[i, white] = y.T[white] / sd[white, None]
            both = np.column_stack([z, w]) if coloured else z
            for channel in coloured:
                seen = noise[channel].whitened(both[:, [*range(columns), columns + channel]])
                factor[i, channel], own = triangle(seen[:, :-1], seen[:, -1:])
                target[i, channel] = own[:, 0]
        return cls(factor, target)

    def only(self, regressors: IntArray) -> Reduced:
        """The same records predicted by some of the regressors alone."""
        return Reduced(self.factor[..., regressors], self.target)

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
            return np.asarray((seen - self.target).ravel())

        def slope(theta: FloatArray) -> FloatArray:
            table = self.factor @ jacobian(theta)
            return np.asarray(table.reshape(self.target.size, theta.size))

        return fit_map(residual, parameters, jacobian=slope, start=start)


def triangle(
    z: FloatArray, w: FloatArray, gram: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """R (d, d) and y (d, c) with ``‖R c − y‖²`` equal to ``‖z c − w‖²`` but for a constant.

    `gram` is ``zᵀ z`` where it is known already.
    """
    eigenvalues, vectors = np.linalg.eigh(z.T @ z if gram is None else gram)
    root = np.sqrt(np.clip(eigenvalues, 0.0, None))
    seen = root > SEEN * root[-1]
    factor = np.where(seen, root, 0.0)[:, None] * vectors.T
    inverse = np.where(seen, 1.0 / np.where(seen, root, 1.0), 0.0)
    return factor, inverse[:, None] * (vectors.T @ (z.T @ w))
