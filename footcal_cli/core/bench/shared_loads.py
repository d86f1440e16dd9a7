r"""Scale and zeros of cells that nobody calibrated, by known weights at known places of their foot.

Room: core.bench; asked by intake. With the reading :math:`c_i` of a cell at :math:`x_i`, one scale
:math:`s` and biases :math:`b_i`,

.. math:: \sum_i (s c_i + b_i) = F, \qquad \sum_i x_i (s c_i + b_i) = F x

is linear. Where loads of several sizes stand on several places, each cell shows its zero by itself:
under a stiff plate :math:`c_i = z_i + F (u_i + v_i x + w_i y)`. It is where the fit of each cell's
gain starts, not its result: cells of one make differ by some percent.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray

_LIGHT = 0.5
"""Share of the largest load: without a lighter one no zero is seen beyond it."""


def common_scale(
    counts: FloatArray, load_n: FloatArray, place_m: FloatArray, cell_m: FloatArray,
    scale: float | None = None,
) -> tuple[float, FloatArray]:  # fmt: skip
    """Scale of all cells in N/count, and the bias of each in N, shape (c,), by least squares.

    Of biases that no output sees the smallest are taken.

    Parameters
    ----------
    counts, load_n, place_m
        Of n placements, shapes (n, c), (n,) and (n, 2); places without a load count for nothing.
    cell_m
        Shape (c, 2).
    scale
        Where it is known already.
    """
    lever = float(np.sqrt(np.mean(cell_m**2))) or 1.0
    each = np.concatenate([np.ones((1, len(cell_m))), cell_m.T / lever])  # outputs by cells
    whole = (counts @ each.T).T.ravel()
    put = np.concatenate([load_n, *(load_n[:, None] * np.nan_to_num(place_m) / lever).T])
    biases = np.repeat(each, len(load_n), axis=0)
    # readings about their means: counts may be millions, of which some thousands are the load
    middle = counts.mean(axis=0)
    about = whole - np.repeat(each @ middle, len(load_n))
    size = float(np.std(about)) or 1.0
    centred = about / size
    if scale is None:
        found = np.linalg.lstsq(np.column_stack([centred, biases]), put, rcond=None)[0]
        scale, rest = float(found[0] / size), found[1:]
    else:
        rest = np.linalg.lstsq(biases, put - scale * size * centred, rcond=None)[0]
    return scale, np.asarray(rest - scale * middle)


def zeros_seen(counts: FloatArray, load_n: FloatArray, place_m: FloatArray) -> FloatArray | None:
    """What each cell reads without a load, shape (c,); None where loads are too much alike.

    Parameters as for `common_scale`.
    """
    if load_n.min() > _LIGHT * load_n.max():
        return None
    lever = float(np.sqrt(np.mean(place_m**2))) or 1.0
    design = np.column_stack([load_n, load_n[:, None] * place_m / lever]) / np.max(np.abs(load_n))
    design = np.column_stack([design, np.ones(len(load_n))])
    if np.linalg.matrix_rank(design, tol=1e-3 * np.sqrt(len(design))) < design.shape[1]:
        return None
    middle = counts.mean(axis=0)
    return np.asarray(np.linalg.lstsq(design, counts - middle, rcond=None)[0][-1] + middle)
