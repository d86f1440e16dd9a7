"""Tables, pictures and numbers in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Rows = Sequence[Sequence[str]]


def table(head: Sequence[str], rows: Rows) -> str:
    """A table with its head."""
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def picture(name: str, caption: str) -> str:
    """A picture of the page, its caption below."""
    return f"![{caption}](pictures/papers/{name}.png)\n\n*{caption}.*"


def shown(value: float, digits: int = 3) -> str:
    """A number with so many digits, whole where it is large, without an exponent."""
    if abs(value) >= 10.0**digits:
        return f"{value:.0f}"
    return np.format_float_positional(value, precision=digits, fractional=False, trim="-")


def p_shown(value: float) -> str:
    """A p value."""
    return "< 0.001" if value < 0.001 else f"{value:.3f}"
