"""What a command has to say: a result, figures, tables, findings.

`footcal_cli.report.page` writes it as one HTML file, `footcal_cli.report.text` for a terminal.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import floor, isfinite, log10
from typing import TYPE_CHECKING

from footcal_cli.core.quality import RAISED, Finding
from footcal_cli.records.display_units import display_unit
from footcal_cli.records.results import (
    ParametersRecord,
    ReadColumnRecord,
    RmseRecord,
    VerdictRecord,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE_DPI = 130
_GROUPED, _WRITTEN_OUT = 1e3, 1e15
"""From where on thousands are set apart, and up to where no power of ten is written."""
_READ_ALOUD = 12
"""So many columns are printed before the rest is folded away."""
_FIGURE_METADATA = {"Software": None}  # keeps figures the same bytes for the same data


@dataclass(frozen=True)
class Drawn:
    """A figure as drawn: the PNG, and its curves as JSON where they can be zoomed into."""

    png: bytes
    curves: str = ""


@dataclass(frozen=True)
class Picture:
    """A figure of a report.

    Parameters
    ----------
    name
        File name without ending.
    draw
        Draws the figure; not called where no pictures are wanted.
    caption
        What to see in it and how to read it.
    title
        What is seen, in a few words.
    result
        What it shows of these data, in one sentence, for readers who cannot see it; a function
        is called only if the figure is drawn.
    zoom
        Whether the page can zoom into its curves and read values off them.
    """

    name: str
    draw: Callable[[], Figure]
    caption: str
    title: str
    result: str | Callable[[], str]
    zoom: bool = False

    @property
    def sentence(self) -> str:
        """The result in words."""
        return self.result if isinstance(self.result, str) else self.result()

    def drawn(self) -> Drawn:
        """The figure, drawn."""
        from footcal_cli.report.curves import curves_of

        figure, buffer = self.draw(), io.BytesIO()
        with warnings.catch_warnings():  # a name in letters that the font lacks; tables have it
            warnings.filterwarnings("ignore", "Glyph", UserWarning)
            figure.savefig(buffer, format="png", dpi=FIGURE_DPI, metadata=_FIGURE_METADATA)
        return Drawn(buffer.getvalue(), curves_of(figure) if self.zoom else "")


@dataclass(frozen=True)
class Sheet:
    """A table of a report; cells are ready text, greyed rows are what could not be judged.

    Parameters
    ----------
    title, columns, rows
        What it shows; every row has one text per column.
    greyed
        Numbers of the rows to print in grey.
    folded_after
        Rows from this number on are folded away on the page and left out of the terminal; 0: none.
    brief
        Columns that a terminal shows; empty: as many of the first as fit.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    greyed: frozenset[int] = frozenset()
    folded_after: int = 0
    brief: Sequence[str] = ()


@dataclass(frozen=True)
class Report:
    """What a command has to say, in the order in which it is shown.

    `lead_sheets` stand before the pictures, `sheets` behind them; without a lead sheet the first
    of `sheets` leads.
    """

    title: str
    verdict: VerdictRecord
    pictures: tuple[Picture, ...] = ()
    sheets: tuple[Sheet, ...] = ()
    findings: tuple[Finding, ...] = ()
    footer: tuple[str, ...] = field(default=())
    lead_sheets: tuple[Sheet, ...] = ()

    @property
    def leading(self) -> tuple[Sheet, ...]:
        """Tables that hold the result."""
        return self.lead_sheets or self.sheets[:1]

    @property
    def details(self) -> tuple[Sheet, ...]:
        """Tables that support it."""
        return self.sheets if self.lead_sheets else self.sheets[1:]


def number(value: float | None, digits: int = 4) -> str:
    """A number for people: `digits` significant ones, an en dash for none.

    Nothing has an exponent that a person would write out: 110, 8,347,750; beyond that, and for
    small ones, a power of ten: 4.2 × 10⁻⁶.
    """
    if value is None or value != value:
        return "–"
    text = f"{value:z.{digits}g}"
    if abs(value) < _WRITTEN_OUT and ("e+" in text or abs(value) >= _GROUPED):
        decimals = len(text.partition(".")[2]) if "e" not in text else 0
        text = f"{float(text):,.{decimals}f}"
    head, _, power = text.partition("e")
    if power:
        text = f"{head} × {power_of_ten(int(power))}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def power_of_ten(exponent: int) -> str:
    """A power of ten with its exponent raised."""
    return f"10{str(exponent).translate(RAISED)}"


def with_sd(value: float, sd: float | None) -> str:
    """``value ± sd``, both to the second digit of the sd."""
    if sd is None or not sd > 0 or sd != sd:
        return number(value, 6)
    decimals = 1 - floor(log10(sd))
    if -15 < decimals < 7:
        shown = max(decimals, 0)
        grouped = "," if abs(value) >= _GROUPED else ""
        return f"{value:z{grouped}.{shown}f} ± {sd:{grouped}.{shown}f}".replace("-", "−")
    power = floor(log10(max(abs(value), sd)))
    shown = max(decimals + power, 1)
    scaled = f"({value / 10.0**power:z.{shown}f} ± {sd / 10.0**power:.{shown}f})"
    return f"{scaled} × {power_of_ten(power)}".replace("-", "−")


def with_same_decimals(values: Sequence[float], digits: int = 3) -> list[str]:
    """Numbers about zero, all with the decimals that the largest needs: 0.0114, −0.0003, 0.0000."""
    largest = max((abs(v) for v in values if isfinite(v)), default=0.0)
    decimals = digits - 1 - floor(log10(largest)) if largest > 0 else 0
    if decimals > 6:
        return [number(value, digits) for value in values]
    return [f"{v:z,.{max(decimals, 0)}f}".replace("-", "−") if isfinite(v) else "–" for v in values]


def plural(count: int, one: str, many: str = "") -> str:
    """``1 finding``, ``2 findings``; `many` where the plural is not `one` with an s."""
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def rmse_sheet(rmse: RmseRecord) -> Sheet:
    """The error table every report has."""
    units = {r.unit: display_unit(r.unit) for r in rmse.rows}
    return Sheet(
        "Errors before and after",
        ("quantity", "stage", "against", "data", "RMSE", "unit", "samples"),
        [
            (r.quantity, r.stage, r.reference, r.split.replace("_", " "),
             number(units[r.unit][0] * r.rmse), units[r.unit][1], f"{r.n:,}")
            for r in rmse.rows
        ],
        note="Root mean square errors. Held out: data that the fit did not use. Rejected samples: "
        + (", ".join(f"{n:,} ({why})" for why, n in rmse.rejected.items()) or "none")
        + ".",
    )  # fmt: skip


def read_as_sheet(columns: Mapping[str, Mapping[str, ReadColumnRecord]]) -> Sheet:
    """How foreign columns were read: their unit in full, and their range before and after."""

    def spread(ends: tuple[float, float] | None) -> str:
        return "–" if ends is None else f"{number(ends[0], 6)} … {number(ends[1], 6)}"

    return Sheet(
        "Columns as read",
        ("log", "column", "is", "read as", "as written", "used as", "unit"),
        [
            (path, c.source, c.name, c.unit or "–", spread(c.as_written), spread(c.as_read),
             c.canonical_unit or "–")
            for path, own in columns.items()
            for c in own.values()
        ],
        folded_after=_READ_ALOUD,
    )  # fmt: skip


def read_aloud(columns: Mapping[str, Mapping[str, ReadColumnRecord]]) -> list[str]:
    """The same for the terminal, converted columns first, each name once."""
    every = [column for own in columns.values() for column in own.values()]
    every.sort(key=lambda column: len(column.ranges) < 2)
    lines = list({column.name: column.sentence for column in every}.values())
    more = len(lines) - _READ_ALOUD
    if more > 0:
        lines[_READ_ALOUD:] = [f"… and {plural(more, 'more column')} in the report"]
    return lines


def history_sheet(
    started_from: ParametersRecord | None, now: ParametersRecord | None, source: str
) -> Sheet | None:
    """A calibration and the one it started from; None where nothing can be compared."""
    if started_from is None or now is None:
        return None
    rows = []
    scales = [one.value for one in now.parameters.values() if one.unit == "N/count"]
    for name, new in now.parameters.items():
        old = started_from.parameters.get(name)
        if old is None or old.unit != new.unit:
            continue
        factor, unit = display_unit(new.unit, scales)
        change = new.value - old.value
        known = old.sd is not None and isfinite(old.sd) and old.sd > 0
        in_sd = f"{change / old.sd:+.1f}".replace("-", "−") if known and old.sd else "–"
        rows.append(
            (name, *(with_sd(factor * p.value, None if p.sd is None else factor * p.sd)
                     for p in (old, new)), unit, in_sd, str(new.status))
        )  # fmt: skip
    if not rows:
        return None
    return Sheet(
        "History: this calibration and the one it started from",
        ("parameter", "before ± sd", "now ± sd", "unit", "change (sd before)", "status now"),
        rows,
        note=f"Before: {source}, made {started_from.created} by {started_from.command}. A change "
        "beyond ±3 sd means that the sensor, its mounting or the model changed.",
        folded_after=24 if len(rows) > 30 else 0,
    )
