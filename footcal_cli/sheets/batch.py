"""`batch`: report, verdict, tables and figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import Literal

import numpy as np

from footcal_cli.core.fleet import Fleet, ParameterSeries, Sessions
from footcal_cli.core.parameters import Status
from footcal_cli.core.quality import Finding
from footcal_cli.plots import batch as plots
from footcal_cli.records.batch import SessionRecord
from footcal_cli.records.display_units import display_unit
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Picture, Sheet, number, plural, with_sd
from footcal_cli.report.outcome import Outcome

_MOST_REFUSALS = 20
_FOLDED = 40
_MOST_KINDS = 6
_FEWEST_DRAWN = 3
_MOST_NAMED = 2


def outcome_of(
    command: str, found: Sequence[SessionRecord], limits: Mapping[str, float], fleet: Fleet
) -> Outcome:
    """What all sessions say together.

    Parameters
    ----------
    command
        That ran on each session.
    found
        In the order of time.
    limits
        Largest drift by parameter, or by its last word.
    fleet
        The parameters of all sessions that were not refused.
    """
    good = [row for row in found if row.outcome != "refused"]
    dated = days(good) is not None
    missed = gates_missed(fleet, limits)
    table = frame_of(found)
    return Outcome(
        title=f"{len(found)} sessions, {command}",
        verdict=verdict_of(found, fleet, len(missed)),
        pictures=pictures_of(fleet, dated),
        sheets=sheets_of(found, fleet),
        findings=tuple(findings_of(fleet)),
        footer=(
            "Each session's own report lies in sessions/<session>/report.html.",
            "Sessions in the order of their dates." if dated else
            "Not every session has a date: sessions in the order of their names.",
        ),
        tables={"sessions.parquet": table, "sessions.csv": table},
        gates_missed=(*_refused(found), *missed),
        usable=bool(good),
    )  # fmt: skip


def _refused(rows: Sequence[SessionRecord]) -> list[str]:
    """A line per refused session; of many, the first ones."""
    lines = [f"session {r.session}: {r.reason}" for r in rows if r.outcome == "refused"]
    more = len(lines) - _MOST_REFUSALS
    return [
        *lines[:_MOST_REFUSALS],
        *([f"{more} more sessions: see sessions.csv"] if more > 0 else []),
    ]


def in_time(rows: Iterable[SessionRecord]) -> list[SessionRecord]:
    """Sessions by date; by name where one has none."""
    found = sorted(rows, key=lambda row: row.session)
    if all(row.date is not None for row in found):
        found.sort(key=lambda row: _stamp(str(row.date)))
    return found


def days(rows: Sequence[SessionRecord]) -> list[float] | None:
    """Days after the first session; None where a date is missing or all are the same."""
    if not rows or any(row.date is None for row in rows):
        return None
    stamps = [_stamp(str(row.date)) for row in rows]
    days = [(stamp - min(stamps)) / 86400.0 for stamp in stamps]
    return days if max(days) > 0 else None


def _stamp(date: str) -> float:
    """Seconds since 1970; a date without a zone counts as UTC."""
    stamp = datetime.fromisoformat(date)
    return (stamp if stamp.tzinfo is not None else stamp.replace(tzinfo=UTC)).timestamp()


def sessions_of(rows: Sequence[SessionRecord], days: Sequence[float] | None) -> Sessions:
    """Parameters of all sessions that were not refused.

    Parameters
    ----------
    rows
        In the order of time.
    days
        After the first session; None where dates are missing.
    """
    names = list(dict.fromkeys(name for row in rows for name in row.parameters))
    values = {name: np.full(len(rows), np.nan) for name in names}
    sd = {name: np.zeros(len(rows)) for name in names}
    units: dict[str, str] = {}
    for i, row in enumerate(rows):
        for name, found in row.parameters.items():
            units[name] = found.unit
            if found.status is Status.ESTIMATED and found.sd is not None:
                values[name][i], sd[name][i] = found.value, found.sd
    kept = [name for name in names if np.isfinite(values[name]).any()]
    return Sessions(
        names=np.array([row.session for row in rows], dtype=np.str_),
        robot=np.array([row.robot for row in rows], dtype=np.str_),
        operator=np.array([row.operator for row in rows], dtype=np.str_),
        day=np.array([(row.date or "")[:10] for row in rows], dtype=np.str_),
        time=np.arange(len(rows), dtype=float) if days is None else np.array(days),
        values={name: values[name] for name in kept},
        sd={name: sd[name] for name in kept},
        units=units,
    )


def verdict_of(rows: Sequence[SessionRecord], fleet: Fleet, alarms: int) -> VerdictRecord:
    """How many sessions there are, and what is wrong with them."""
    outcomes = Counter(row.outcome for row in rows)
    refused, gates = outcomes["refused"], outcomes["gate not met"]
    apart, changed = fleet.outlying_sessions(), [s for s in fleet.series if s.proved]
    robots = len({row.robot for row in rows if row.outcome != "refused"})
    sentence = (
        f"{len(rows) - refused} of {plural(len(rows), 'session')} of {plural(robots, 'robot')} "
        "were processed"
    )
    parts = [f"{refused} refused"] if refused else []
    parts += [f"gates not met by {gates}"] if gates else []
    parts += [plural(len(apart), "outlying session")] if apart else []
    parts += [_changed(changed)] if changed else []
    parts += [f"{plural(alarms, 'drift')} beyond its limit"] if alarms else []
    codes = Counter(code for row in rows for code in row.findings)
    details = []
    if codes:
        common = ", ".join(f"{c.replace('_', ' ')} in {n}" for c, n in codes.most_common(5))
        details.append(f"Most common findings: {common} sessions.")
    level: Literal["good", "warning", "bad"] = "warning" if parts else "good"
    if refused == len(rows) or alarms:
        level = "bad"
    return VerdictRecord(
        level=level, sentence=sentence + (f"; {', '.join(parts)}." if parts else "."),
        details=tuple(details),
    )  # fmt: skip


def _changed(series: Sequence[ParameterSeries]) -> str:
    """Which parameters changed or drifted; of many, how many."""
    names = " and ".join(one.parameter for one in series)
    return f"{names if len(series) <= _MOST_NAMED else f'{len(series)} parameters'} changed"


def findings_of(fleet: Fleet) -> Iterator[Finding]:
    """Changes, drifts and outlying sessions."""
    for one in fleet.series:
        where = f"{one.robot}, {one.parameter}"
        for change in one.changes:
            name = fleet.sessions.names[one.at[change.first_after]]
            yield Finding(
                "parameter_changed", "warning", where,
                f"{_amount(one, change.size, change.sd, 'changed by')} at session {name} "
                f"(p = {number(change.p, 2)}, corrected for the choice of the place)",
                "ask what was done to the robot before that session",
            )  # fmt: skip
        if one.drifting and one.trend is not None:
            yield Finding(
                "parameter_drifts", "warning", where,
                f"{_amount(one, one.trend.total, one.trend.total_sd, 'drifts by')} over the "
                f"sessions (p = {number(one.trend.p, 2)})",
                "calibrate more often, or find what wears",
            )  # fmt: skip
    for name, parameters in fleet.outlying_sessions().items():
        some = ", ".join(parameters[:4]) + ("" if len(parameters) < 5 else " …")
        yield Finding(
            "outlying_session", "warning", name,
            f"lies apart from the other sessions in {some}",
            "look at its report; run diagnose on its logs",
        )  # fmt: skip


def _amount(one: ParameterSeries, value: float, sd: float, how: str) -> str:
    """``changed by 0.580 ± 0.045 N``, in the unit of the page."""
    factor, unit = display_unit(one.unit, one.values)
    return f"{how} {with_sd(factor * value, factor * sd)} {unit}"


def sheets_of(rows: Sequence[SessionRecord], fleet: Fleet) -> tuple[Sheet, ...]:
    """Sessions, parameters over time, uncertainty budget."""
    sheets = [_sessions_sheet(rows)]
    if fleet.series:
        sheets.append(_series_sheet(fleet.series))
    if any(b.components for b in fleet.budgets):
        sheets.append(_budget_sheet(fleet))
    return tuple(sheets)


def _sessions_sheet(rows: Sequence[SessionRecord]) -> Sheet:
    # what went wrong first: with a thousand sessions nobody scrolls
    order = sorted(range(len(rows)), key=lambda i: (rows[i].outcome == "done", i))
    return Sheet(
        "Sessions", ("session", "robot", "date", "outcome", "verdict or reason", "time (s)"),
        [
            (
                rows[i].session, rows[i].robot, rows[i].date or "–", rows[i].outcome,
                rows[i].reason or _sentence(rows[i]), f"{rows[i].seconds:.1f}",
            )
            for i in order
        ],
        greyed=frozenset(k for k, i in enumerate(order) if rows[i].outcome == "refused"),
        folded_after=_FOLDED if len(rows) > _FOLDED else 0,
    )  # fmt: skip


def _sentence(row: SessionRecord) -> str:
    return "" if row.verdict is None else row.verdict.sentence


def _series_sheet(series: Sequence[ParameterSeries]) -> Sheet:
    order = sorted(series, key=lambda one: (not one.proved, not one.outlying.any()))
    lines = []
    for one in order:
        last = one.levels[-1]
        drift = one.drift
        factor, unit = display_unit(one.unit, one.values)
        what = "no change shown"
        if one.changes:
            what = plural(len(one.changes), "change point")
        elif one.drifting:
            what = "steady drift"
        elif one.trend is None:
            what = "too few sessions"
        lines.append(
            (
                one.robot,
                one.parameter,
                unit,
                str(one.at.size),
                with_sd(factor * last.value, factor * last.sd),
                number(factor * last.between_sd, 2),
                "–" if drift is None else with_sd(*(factor * x for x in drift)),
                what,
                str(int(one.outlying.sum())),
            )
        )
    return Sheet(
        "Parameters over the sessions",
        ("robot", "parameter", "unit", "sessions", "last level", "spread beyond claims",
         "drift, first to last", "verdict", "outlying"),
        lines,
        note="A level is the weighted mean of the sessions between change points, ± sd (Knapp and "
        "Hartung). 5 % for any false change or outlying session in the whole batch. What a "
        "session did not estimate does not count.",
        folded_after=_FOLDED if len(lines) > _FOLDED else 0,
    )  # fmt: skip


def _budget_sheet(fleet: Fleet) -> Sheet:
    values = {one.parameter: one.values for one in fleet.series}
    lines = []
    for one in fleet.budgets:
        if not one.components:
            continue
        by_name = {c.name: c for c in one.components}
        factor, unit = display_unit(one.unit, values.get(one.parameter, ()))
        cells = [
            f"{number(factor * c.sd, 3)} [{number(factor * c.low, 2)}, "
            f"{number(factor * c.high, 2)}]"
            if (c := by_name.get(name)) is not None
            else "–"
            for name in ("repeatability", "day", "operator", "robot")
        ]
        share = one.gauge_share
        repeat = one.sd_of("repeatability")
        ratio = number(repeat / one.claimed_sd, 2) if one.claimed_sd > 0 else "–"
        distinct = "–"
        if share is not None and one.gauge_sd > 0:
            distinct = str(max(int(1.41 * one.sd_of("robot") / one.gauge_sd), 1))
        lines.append(
            (
                one.parameter,
                unit,
                str(one.sessions),
                number(factor * one.claimed_sd, 3),
                *cells,
                ratio,
                number(2.0 * factor * one.standard_uncertainty, 3),
                "–" if share is None else f"{100 * share:.0f}",
                distinct,
            )
        )
    return Sheet(
        "Uncertainty budget (gauge R&R)",
        ("parameter", "unit", "sessions", "claimed sd", "repeatability", "day", "operator",
         "robot", "repeatability / claimed", "U (k = 2)", "% GRR", "ndc"),
        lines,
        note="Sd by source with 95 % interval, change points and drifts taken out and outlying "
        "sessions left out; – where the sessions do not determine it. U: expanded uncertainty of "
        "one session's value, from the larger of claim and repeatability, and days or operators; "
        "an error that all sessions share is not in it. % GRR and ndc as in AIAG, Measurement "
        "Systems Analysis (2010), robots as parts.",
        folded_after=_FOLDED if len(lines) > _FOLDED else 0,
    )  # fmt: skip


def pictures_of(fleet: Fleet, dated: bool) -> tuple[Picture, ...]:
    """A figure per kind of parameter, what changed first, and the budget."""
    kinds: dict[str, list[ParameterSeries]] = {}
    for one in sorted(fleet.series, key=lambda s: (not s.proved, not s.outlying.any())):
        if one.at.size < _FEWEST_DRAWN:
            continue
        kinds.setdefault(one.parameter.rsplit(".", 1)[-1], []).append(one)
    pictures = [
        Picture(
            f"over_time_{kind}", partial(plots.plot_series, series, dated),
            f"'{kind}' of every session with its 95 % interval and levels, of several robots as "
            "changes from each robot's first level; dashed: a change point, circle: an "
            "outlying session."
            + _not_drawn({s.parameter for s in series}),
            title=f"{kind.replace('_', ' ').capitalize()} of every session over time",
            result=f"{sum(s.proved for s in series) or 'None'} of {len(series)} series changed; "
            f"{plural(sum(int(s.outlying.sum()) for s in series), 'outlying session')}.",
        )
        for kind, series in list(kinds.items())[:_MOST_KINDS]
    ]  # fmt: skip
    if any(b.components for b in fleet.budgets):
        pictures.append(
            Picture("budget", lambda: plots.plot_budgets(fleet.budgets),
                    "Where the variance of a robot's parameter comes from, session to session; the "
                    "upright stroke marks what the fits claim.",
                title="Variance of each parameter by source",
                result=lambda: _largest_source(fleet))
        )  # fmt: skip
    return tuple(pictures)


def _largest_source(fleet: Fleet) -> str:
    """Which source is the largest, and in how many parameters."""
    largest = [max(b.components, key=lambda c: c.sd).name for b in fleet.budgets if b.components]
    source = max(set(largest), key=largest.count)
    return (
        f"The largest source is {source} in {largest.count(source)} of "
        f"{plural(len(largest), 'parameter')}."
    )


def _not_drawn(names: set[str]) -> str:
    more = len(names) - plots.MOST_PANELS
    return f" {more} more parameters are in the table." if more > 0 else ""


def frame_of(rows: Sequence[SessionRecord]) -> dict[str, object]:
    """``sessions.parquet``: a row per session; parameters with sd, errors by name."""
    frame: dict[str, object] = {
        name: [getattr(row, name) for row in rows]
        for name in (
            "session", "robot", "date", "operator", "command", "outcome", "exit_code", "reason",
            "attempts", "seconds", "rows", "digest",
        )
    }  # fmt: skip
    frame["logs"] = ["; ".join(row.logs) for row in rows]
    frame["verdict"] = [_sentence(row) for row in rows]
    frame["findings"] = ["; ".join(row.findings) for row in rows]
    for name in dict.fromkeys(name for row in rows for name in row.parameters):
        found = [row.parameters.get(name) for row in rows]
        frame[name] = [np.nan if p is None else p.value for p in found]
        frame[f"{name}.sd"] = [np.nan if p is None or p.sd is None else p.sd for p in found]
        frame[f"{name}.status"] = ["" if p is None else str(p.status.value) for p in found]
    for name in dict.fromkeys(name for row in rows for name in row.rmse):
        frame[f"rmse.{name}"] = [row.rmse.get(name, np.nan) for row in rows]
    return frame


def gates_missed(fleet: Fleet, limits: Mapping[str, float]) -> list[str]:
    """Proved drifts beyond their limits; a limit's key is a parameter or its last word."""
    missed = []
    for one in fleet.series:
        limit = limits.get(one.parameter, limits.get(one.parameter.rsplit(".", 1)[-1]))
        drift = one.drift
        if limit is None or drift is None or not one.proved or abs(drift[0]) <= limit:
            continue
        missed.append(
            f"{one.robot}, {one.parameter}: drift {with_sd(*drift)} {one.unit} > {limit:g} "
            f"{one.unit}"
        )
    return missed
