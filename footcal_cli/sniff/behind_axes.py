"""Words behind the axes of a transducer: what was worked out of a hold, or which leg it is of.

Room: sniff; called by columns. ``Fx ORT [N]`` and ``Fx SS [N]`` are a mean and its scatter in
whatever language: a scatter is never negative, and small next to how its mean changes. Of several
words of another kind each is a transducer, ``Fx VL`` and ``Fx HR``; a single one says nothing.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.groups import AXES
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.units import split_unit
from footcal_cli.tables.rawcolumn import RawColumn

_LAST_WORD = re.compile(r"(.*?\w)[\W_]+([^\W\d_]+\d?)\.?")
_SMALL = 0.2
"""A scatter's largest share of how far its mean changes."""


def without_words_behind(
    called: Sequence[str], names: Sequence[str], raw: Mapping[str, RawColumn]
) -> list[str]:
    """What columns are called, without the words that stand behind all six axes.

    Parameters
    ----------
    called, names
        What each column is called, and its name in the file.
    raw
        Columns by these names.
    """
    found: dict[str, dict[str, int]] = {}
    short: dict[int, tuple[str, str]] = {}
    for i, name in enumerate(called):
        bare = split_unit(name)[0]
        unit = name[len(bare) :] if name.startswith(bare) else ""
        parts = _LAST_WORD.fullmatch(bare)
        if parts is None or name_guess(name).axis:
            continue
        stem, word = parts[1] + unit, parts[2]
        axis = name_guess(stem).axis
        if axis in AXES and axis not in found.setdefault(word, {}):
            found[word][axis] = i
            short[i] = stem, word
    whole = {word: axes for word, axes in found.items() if set(axes) == set(AXES)}
    scatters = {
        word for word, axes in whole.items()
        if any(_scatters(axes, mean, names, raw) for mean in whole.values() if mean is not axes)
    }  # fmt: skip
    kept = whole.keys() - scatters
    made = list(called)
    for word, axes in whole.items():
        for i in axes.values():
            stem, _ = short[i]
            made[i] = f"{stem} std" if word in scatters else f"{word} {stem}" * (len(kept) > 1)
            made[i] = made[i] or stem
    return made


def _scatters(
    axes: Mapping[str, int], means: Mapping[str, int], names: Sequence[str],
    raw: Mapping[str, RawColumn],
) -> bool:  # fmt: skip
    """Whether six columns are the scatter of six others."""
    for axis, i in axes.items():
        scatter, mean = _numbers(raw[names[i]]), _numbers(raw[names[means[axis]]])
        if not scatter.size or not mean.size or np.nanmin(scatter) < 0.0:
            return False
        if np.nanmedian(scatter) > _SMALL * np.ptp(mean[np.isfinite(mean)]):
            return False
    return True


def _numbers(column: RawColumn) -> FloatArray:
    """Numbers of a column; empty where it holds others, or nothing."""
    if column.kind != "number":
        return np.zeros(0)
    values = np.asarray(column.values, dtype=np.float64)
    return values if np.isfinite(values).any() else np.zeros(0)
