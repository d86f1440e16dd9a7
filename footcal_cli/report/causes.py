"""Findings of one cause on many channels as one line.

Room: report; asked by text and page. Records keep a finding for each channel.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.core.quality import Finding

_NUMBER = re.compile(r"(?:(?<=[\s(])[-+−])?\d+(?:,\d{3})*(?:\.\d+)?")
"""A number with its sign, its groups of thousands and its decimals."""
_FEWEST = 3
"""Fewer findings with different numbers stay apart."""


def one_per_cause(findings: Sequence[Finding]) -> list[Finding]:
    """Findings that differ in their channel, and in numbers, joined to the first of them.

    ``a: 3 of 90 samples are missing`` and the same of b and c is one line of a, b, c; numbers that
    differ are given as a range, ``3 … 5 of 90``.
    """
    groups: dict[tuple[str, ...], list[Finding]] = {}
    for finding in findings:
        alike = _NUMBER.sub("#", finding.sentence)
        key = (finding.code, finding.severity, alike, finding.remedy)
        groups.setdefault(key, []).append(finding)
    made = []
    for group in groups.values():
        same = len({finding.sentence for finding in group}) == 1
        made += [_joined(group)] if same or len(group) >= _FEWEST else group
    return made


def _joined(group: Sequence[Finding]) -> Finding:
    where = ", ".join(dict.fromkeys(finding.where for finding in group))
    columns = zip(*(_NUMBER.findall(finding.sentence) for finding in group), strict=True)
    ranges = iter([(min(column, key=_value), max(column, key=_value)) for column in columns])

    def spelled(found: re.Match[str]) -> str:
        low, high = next(ranges)
        return found[0] if _value(low) == _value(high) else f"{low} … {high}"

    return replace(group[0], where=where, sentence=_NUMBER.sub(spelled, group[0].sentence))


def _value(text: str) -> float:
    return float(text.replace("−", "-").replace(",", ""))
