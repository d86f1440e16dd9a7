"""`check`: its report, and the log as pictures, findings marked where they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding, some_of
from footcal_cli.core.readings import find_end_codes, find_frozen, find_glitches
from footcal_cli.core.signals import gaps_of
from footcal_cli.plots.log import Drawing, Panel, plot_channels, plot_weights
from footcal_cli.recipe import Robot
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Picture, Sheet, plural
from footcal_cli.report.outcome import Outcome
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import Table

_MOST_PICTURES = 12
_MOST_NAMED = 3
"""So many places of findings stand in the headline."""
_LEG_PANELS = {"force (N)": ("fx_n", "fy_n", "fz_n"), "torque (Nm)": ("tx_nm", "ty_nm", "tz_nm")}
_WORDS = {
    "dead_cell": "stands still", "held_in_part": "held in part",
    "turned_sign": "reversed sign", "stuck_channel": "frozen",
    "duplicate_channel": "a copy", "scale_off_nameplate": "off the nameplate",
    "saturated_codes": "end codes", "outliers": "single samples far off",
    "lost_samples": "lost samples", "exchanged_channels": "exchanged",
    "transducer_turned": "turned", "axis_turned": "an axis turned",
}  # fmt: skip


def outcome_of(
    tables: Sequence[tuple[Table, TableType]], robot: Robot, noted: Sequence[Finding]
) -> Outcome:
    """What was found in logs, and one figure per table."""
    findings = {(f.code, f.where, f.sentence): f for f in noted}
    serious = [finding for finding in findings.values() if finding.severity != "note"]
    rows = sum(len(table) for table, _ in tables)
    alarmed = any(finding.severity == "alarm" for finding in serious)
    return Outcome(
        title="Check of the log",
        verdict=VerdictRecord(
            level="good" if not serious else "bad" if alarmed else "warning",
            sentence=_headline(serious, rows),
            details=(
                "Checked: units of stamps, loads, positions, headings and accelerations; "
                "gaps, lost samples, outliers, readings at an end of the range; channels that are "
                "stuck, loose, repeated, inverted or exchanged; loads, weight and calibration "
                "against the recipe.",
            ),
        ),
        pictures=tuple(
            picture_of(table, kind, robot, serious, number)
            for number, (table, kind) in enumerate(tables[:_MOST_PICTURES], start=1)
        ),
        lead_sheets=(
            Sheet(
                "Logs",
                ("file", "read as", "rows"),
                [(table.path.name, kind.name, f"{len(table):,}") for table, kind in tables],
            ),
        ),
    )


def _headline(serious: Sequence[Finding], rows: int) -> str:
    """How many findings, what they are and where."""
    if not serious:
        return f"Nothing wrong found in {plural(rows, 'row')}."
    named = list(dict.fromkeys(f"{f.code.replace('_', ' ')} ({f.where})" for f in serious))
    return (
        f"{plural(len(serious), 'finding')} in {plural(rows, 'row')}: "
        f"{some_of(named, _MOST_NAMED)}."
    )


def picture_of(
    table: Table, kind: TableType, robot: Robot, findings: Sequence[Finding], number: int
) -> Picture:
    """One table as a figure."""
    name = f"log_{number}_{kind.name}"
    where = f"{table.path.name}, read as {kind.name.replace('_', ' ')}"
    if kind.name == "weights":
        title, draw = "Known load against counts, channel by channel", _weights
        named = {str(c): _wrong(str(c), findings) for c in table.text("channel")}
    elif "leg" in table:
        title, draw = "Wrench of every leg, row by row", _legs
        named = {str(leg): _wrong_leg(str(leg), findings) for leg in table.text("leg")}
    else:
        title, draw = "Every channel of the log", _stream
        named = {column: _wrong(column, findings) for column in _columns(table)}
    wrong = [f"{name} ({words})" for name, words in named.items() if words]
    noun = "leg" if "leg" in table else "channel"
    return Picture(
        name, draw(table, robot, findings),
        f"{where}." + (f" Each {noun} with a finding is orange and named." if wrong else ""),
        title=title,
        result=f"{plural(len(named), noun)}; "
        + (f"findings on {', '.join(wrong)}." if wrong else f"no {noun} has a finding of its own."),
        zoom=True,
    )  # fmt: skip


def _weights(table: Table, robot: Robot, findings: Sequence[Finding]) -> Drawing:
    channel = table.text("channel")
    counts, load = table.number("counts"), table.number("load_n")
    each = {str(c): (counts[channel == c], load[channel == c]) for c in dict.fromkeys(channel)}
    return partial(plot_weights, each, {c: w for c in each if (w := _wrong(c, findings))})


def _stream(table: Table, robot: Robot, findings: Sequence[Finding]) -> Drawing:
    timed = "time_s" in table
    x = table.number("time_s") if timed else np.arange(1.0, len(table) + 1)
    panels = [
        Panel(
            column.removesuffix("_counts"), {column: table.data[column].to_numpy()},
            _wrong(column, findings), _marks(table.number(column), column, robot),
        )
        for column in _columns(table)
    ]  # fmt: skip
    rising = timed and bool(np.all(np.diff(x) >= 0))
    gaps = [(float(x[i]), float(x[i + 1])) for i in gaps_of(x)] if rising and x.size > 3 else []
    return partial(plot_channels, x, panels, label="time (s)" if timed else "row", gaps=gaps)


def _columns(table: Table) -> list[str]:
    """Channels to draw: everything but stamps."""
    return [
        str(c) for c in table.data.columns if c != "time_s" and table.data[c].dtype.kind in "if"
    ]


def _marks(values: FloatArray, column: str, robot: Robot) -> Mapping[str, BoolArray]:
    marks = {"single sample far off": find_glitches(values), "lost": ~np.isfinite(values)}
    if column.endswith("_counts"):
        marks["end code"] = find_end_codes(values, robot.adc.bits)
        marks["frozen"] = find_frozen(values)
    return {what: flags for what, flags in marks.items() if flags.any()}


def _wrong(column: str, findings: Sequence[Finding]) -> str:
    """What was found about one channel, in a few words."""
    own = {column, column.removesuffix("_counts")}
    codes = [
        f.code
        for f in findings
        if f.severity != "note" and own & {part.strip() for part in f.where.split(",")}
    ]
    return ", ".join(dict.fromkeys(_WORDS.get(code, code.replace("_", " ")) for code in codes))


def _legs(table: Table, robot: Robot, findings: Sequence[Finding]) -> Drawing:
    """Wrenches of all legs, each leg's rows one after the other."""
    leg = table.text("leg")
    names = list(dict.fromkeys(leg))
    rows = [np.flatnonzero(leg == name) for name in names]
    length = max(part.size for part in rows)
    panels = []
    for name, part in zip(names, rows, strict=True):
        words = _wrong_leg(str(name), findings)
        for quantity, columns in _LEG_PANELS.items():
            series = {}
            for column in columns:
                values = np.full(length, np.nan)
                values[: part.size] = table.number(column)[part]
                series[column[1]] = values
            panels.append(Panel(f"{name}\n{quantity}", series, words))
    breaks = []
    group = next((g for g in ("orientation", "pose") if g in table), None)
    if group is not None:
        label = table.text(group)[rows[0]]
        starts = np.flatnonzero(np.concatenate([[True], label[1:] != label[:-1]]))
        if starts.size <= 12:
            breaks = [(float(s), str(label[s])) for s in starts]
    return partial(
        plot_channels, np.arange(1.0, length + 1), panels, label="row of the leg", breaks=breaks
    )


def _wrong_leg(leg: str, findings: Sequence[Finding]) -> str:
    """What was found about one leg, in a few words."""
    found = [f for f in findings if f.severity != "note" and leg in _legs_named(f.where)]
    return ", ".join(dict.fromkeys(_WORDS.get(f.code, f.code.replace("_", " ")) for f in found))


def _legs_named(where: str) -> set[str]:
    return {part.strip().split(".")[0] for part in where.replace(" or ", ",").split(",")}
