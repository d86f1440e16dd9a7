"""Whether two names are of one cell, as benches, streams and sheets write them.

Room: sniff; asked by bench_cells and geometry.
"""

from __future__ import annotations

import re

from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.units import split_unit


def plainly(name: str) -> str:
    """A name without its unit, signs and capitals."""
    return re.sub(r"[\W_]+", "", split_unit(name)[0]).lower()


def is_word_of(name: str, word: str) -> bool:
    """Whether one of a name's words, or several of them in a row, are the other name.

    >>> is_word_of("PI_conteggi", "PI"), is_word_of("TE_conteggi", "GI")
    (True, False)
    """
    parts = re.findall(r"[^\W_]+", split_unit(name)[0].lower())
    ends = range(len(parts) + 1)
    return any("".join(parts[i:j]) == plainly(word) for i in ends for j in ends[i + 1 :])


def ends_alike(name: str, word: str) -> bool:
    """Whether one of two names ends with the other."""
    name, word = plainly(name), plainly(word)
    return name.endswith(word) or word.endswith(name)


def same_of_a_foot(name: str, word: str) -> bool:
    """Whether two names say one foot and end with one number: ``left_0``, ``/left/cells.data[0]``.

    >>> same_of_a_foot("/left_foot/load_cells.data[0]", "left_0")
    True
    """
    feet = {name_guess(own).side for own in (name, word)}
    counted = {tuple(re.findall(r"\d+", split_unit(own)[0])[-1:]) for own in (name, word)}
    return len(feet) == len(counted) == 1 and feet != {""} and counted != {()}


def holds_name(name: str, word: str) -> bool:
    """Whether a name holds another one of two letters at least."""
    return len(plainly(word)) > 1 and plainly(word) in plainly(name)
