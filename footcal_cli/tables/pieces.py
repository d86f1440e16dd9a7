"""Stacks said as a list of their pieces: ``W1+W2+W5``.

Room: tables; asked by sniff, which finds such a column, and by intake, which counts its pieces.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray

MOST = 48
"""Pieces that one number of a log can hold, a bit each."""
_BETWEEN = re.compile(r"\s*[+&;,/|]\s*")


def pieces_of(stacks: Sequence[str], load: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the pieces that lie under a load, and the stack of each row.

    A word that stands where nothing lies alone, such as ``none``, is no piece.

    Parameters
    ----------
    stacks
        What each row says, n texts.
    load
        What it weighs as written, shape (n,).

    Returns
    -------
    names
        In order of appearance; none where they are more than `MOST`.
    stack
        Bit k of a row: piece k lies there, shape (n,).
    """
    said = {text: set(filter(None, _BETWEEN.split(text.strip()))) for text in dict.fromkeys(stacks)}
    loaded = dict.fromkeys(t for t, n in zip(stacks, load, strict=True) if n != 0)
    names = tuple(dict.fromkeys(p for t in loaded for p in _BETWEEN.split(t.strip()) if p))
    if len(names) > MOST:
        return (), np.zeros(len(stacks))
    bits = {
        t: sum(2.0**k for k, name in enumerate(names) if name in own) for t, own in said.items()
    }
    return names, np.array([bits[text] for text in stacks])


def add_up(stacks: Sequence[str], load: FloatArray) -> bool:
    """Whether every load is the sum of one weight per piece, and some stacks have several."""
    good = np.isfinite(load)
    names, stack = pieces_of([s for s, g in zip(stacks, good, strict=True) if g], load[good])
    lies = (stack.astype(np.int64)[:, None] >> np.arange(len(names)) & 1).astype(float)
    rows, first = np.unique(lies, axis=0, return_index=True)
    if len(names) < _FEWEST or len(rows) <= len(names) or rows.sum(axis=1).max() < _FEWEST:
        return False
    each = np.linalg.lstsq(rows, load[good][first], rcond=None)[0]
    return bool(np.abs(lies @ each - load[good]).max() <= _EXACT * np.abs(load[good]).max())


_FEWEST, _EXACT = 2, 1e-3
