"""How far gains and zeros may be off, as lines say it: ``trimmed to 0.2 %``, ``not tared (2-3 N)``.

Room: sniff; asked by said_above. A fault is what goes beyond the data sheet, so that these numbers
decide whether a gain of 4 % is one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.plan import IN_NEWTON, LogPlan

_NUMBER = r"(?<![\d.,])\d+(?:[.,]\d+)?"
_OF_GAIN = (
    r"(?:sensitivit\w*|gains?|scale[ds]?|accura\w*|calibrat\w*|certificat\w*|kennwert\w*|"
    r"empfindlichkeit\w*|genauigkeit\w*|kalibrier\w*|sensibilit\w*|sensibilidad\w*|pr[eé]cisi[oó]n\w*|"
    r"étalonn\w*|calibra\w*|gevoelig\w*|nauwkeurig\w*)"
)
_OTHERS = r"(?:non-?\s?line|nichtline|hyst|cross|übersprech|creep|kriech|zero|null|temp)"
_GAIN = re.compile(
    rf"(?i)\b{_OF_GAIN}(?:(?!{_OTHERS})[^.;%]|\.(?=\d)){{0,50}}?(?P<size>{_NUMBER})\s*%"
    r"(?!\s*(?:/|per|pro|of\s+(?:full|range|the\s+range)|f\.?\s?s|v\.?\s?e))"
)
"""A share behind a word of gains; one of full scale or per kelvin is none."""
_ZERO = re.compile(
    r"(?i)\b(?:zeros?|zeroes|offsets?|bias\w*|tared?|nullpunkt\w*|tarier\w*|zéros?|ceros?)\b"
    rf"(?:[^.;%\d]|\.(?=\d)){{0,60}}?(?:{_NUMBER}\s*(?:-|–|to|bis|à|a)\s*)?(?P<size>{_NUMBER})\s*N\b(?!\s*m)"
)
_LEAST_SHARE, _LEAST_N = 1e-3, 0.1
_MOST_SHARE = 0.2


def with_accuracy(plan: LogPlan) -> LogPlan:
    """The plan of cells that read forces, with how far these may be off where lines say it."""
    if IN_NEWTON not in plan.robot:
        return plan
    gain, zero = accuracy_in(plan.file.text.above)
    made = IN_NEWTON
    for key, usual, said in (("scale_relative_sd", "0.05", gain), ("bias_sd_n", "5.0", zero)):
        if said is not None:
            size, words = said
            made = made.replace(f"{key} = {usual}", f"{key} = {size:g}    # likely: '{words}'")
    return replace(plan, robot=tuple(made if own is IN_NEWTON else own for own in plan.robot))


def accuracy_in(
    above: Sequence[str],
) -> tuple[tuple[float, str] | None, tuple[float, str] | None]:
    """How far gains may be off as a share, and zeros in N, each with the words; None unsaid.

    >>> accuracy_in(["Gain within 1 %, crosstalk 0.5 %, zero not tared (up to 2 N)."])
    ((0.01, 'Gain within 1 %'), (2.0, 'zero not tared (up to 2 N'))
    """
    text = " ".join(" ".join(above).split())
    gain = next((f for f in _GAIN.finditer(text) if _size(f) <= 100 * _MOST_SHARE), None)
    zero = next(_ZERO.finditer(text), None)
    return (
        None if gain is None else (max(_size(gain) / 100.0, _LEAST_SHARE), gain[0]),
        None if zero is None else (max(_size(zero), _LEAST_N), zero[0]),
    )


def _size(found: re.Match[str]) -> float:
    return float(found["size"].replace(",", "."))
