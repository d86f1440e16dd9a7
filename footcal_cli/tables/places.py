"""Where the columns of a table type stand in a file: by the recipe, by name, by stem and unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from footcal_cli.core.quality import Finding, some_of
from footcal_cli.errors import DataError, nearest
from footcal_cli.tables.canonical import NOT_SAID, is_reading
from footcal_cli.tables.columns import UNIT_SUFFIXES, Column, TableType, converts
from footcal_cli.tables.reading import READ_AGAIN, ForeignColumn, Reading
from footcal_cli.tables.sources import row_time, source_names
from footcal_cli.tables.units import MEANT, PLACES_TOO, may_mean

_IN_BRACKETS = re.compile(r"[\[(<{]([^\])>}]*)[\])>}]\s*$")
_WORD = 2
"""Letters that a unit must have at least at the end of a name, where no brackets are round it."""


def places_of(table: TableType, reading: Reading, path: Path) -> list[Places]:
    """As `every_entry`, refusing what is missing or ambiguous."""
    found = every_entry(table, reading, path)
    for places in found:
        if places.missing:
            raise places.missing[0]
        for name, several in places.twice.items():
            raise DataError(
                f"{name} stands there more than once: {', '.join(several)}", file=path,
                column=several[0],
                remedy=f"say which one in [columns], {name} = '{several[0]}', or take one out",
            )  # fmt: skip
    return found


def every_entry(table: TableType, reading: Reading, path: Path) -> list[Places]:
    """Where the columns stand: once, or for every entry of a wide file."""
    header = source_names(path, reading)
    names = {column.name for column in table.columns}
    again = reading.wide_into == READ_AGAIN and {n for own in reading.wide.values() for n in own}
    apart = reading.wide_into in names or (again and again <= names)
    if not reading.wide or not apart:
        found = _looked_up(table, header, reading, path)
        wide = {name for own in reading.wide.values() for name in own}
        if found.missing and wide & names:
            # what is missing stands in an entry of wide, of which nothing becomes
            found.missing.insert(0, DataError(
                f"wide_into = '{reading.wide_into}' is no column of this table: its entries are "
                "not read", file=path,
                remedy=f"say wide_into = {', '.join(sorted(names - wide))} or {READ_AGAIN}",
            ))  # fmt: skip
        return [found]
    return [
        _looked_up(
            table, header, replace(reading, columns={**reading.columns, **into, **own}), path
        )
        for entry, own in reading.wide.items()
        for into in [{} if again else {reading.wide_into: ForeignColumn(value=entry)}]
    ]  # fmt: skip


@dataclass(frozen=True)
class Places:
    """Where the columns of a table type stand in a file.

    `twice` holds columns that stand there under several names, `passed_over` those whose name the
    recipe gives although the file has the canonical one too, `not_mapped` those that were taken by
    their canonical name because the file has none of the recipe's, `not_there` the recipe's names
    of optional columns that the file has under no name.
    """

    found: dict[str, ForeignColumn]
    missing: list[DataError]
    twice: dict[str, list[str]]
    passed_over: dict[str, list[str]]
    not_mapped: tuple[str, ...] = ()
    not_there: dict[str, str] = field(default_factory=dict)


def _looked_up(table: TableType, header: Sequence[str], reading: Reading, path: Path) -> Places:
    """Find every column: mapped by the recipe, by its name, or by its stem and a unit."""
    canonical = _in_own_names(table, set(header), reading.columns)
    places = Places({}, [], {}, {}, canonical)
    known = set(header)
    columns = {name: place for name, place in reading.columns.items() if name not in canonical}
    for spec in table.columns:
        own = _own_names(spec, known)
        if spec.name in columns:
            place = columns[spec.name]
            if not place.in_file:
                places.found[spec.name] = place
            elif place.column in known:
                unit = place.unit or _unit_in_name(place.column, spec)
                places.found[spec.name] = replace(place, unit=unit)
                others = [name for name in own if name != place.column]
                if others:
                    places.passed_over[spec.name] = others
            elif not spec.optional:
                places.missing.append(DataError(
                    f"missing column '{place.column}' that [columns] names for {spec.name}"
                    f"{nearest(place.column, header)}",
                    file=path, remedy=f"the file has: {_some(header)}", foreign=True,
                ))  # fmt: skip
            elif not own:
                places.not_there[spec.name] = place.column
            continue
        if len(own) > 1:
            places.twice[spec.name] = list(own)
        if own:
            name = next(iter(own))
            places.found[spec.name] = ForeignColumn(name, own[name])
        elif spec.name == "time_s" and (counted := row_time(reading)) is not None:
            places.found[spec.name] = counted
        elif not spec.optional:
            places.missing.append(DataError(
                f"missing column '{spec.name}' ({spec.meaning}){nearest(spec.name, header)}",
                file=path,
                remedy=f"map it in the recipe's [columns]; the file has: {_some(header)}",
                foreign=True,
            ))  # fmt: skip
    for group in table.whole:
        there = [name for name in group if name in places.found]
        if there and len(there) < len(group):
            lacks = next(name for name in group if name not in there)
            places.missing.append(DataError(
                f"missing column '{lacks}'{nearest(lacks, header)}: {there[0]} says nothing "
                "without it", file=path,
                remedy=f"map it in the recipe's [columns], or take out {', '.join(there)}",
            ))  # fmt: skip
    for groups in table.either:
        if not any(all(name in places.found for name in group) for group in groups):
            first = groups[0][0]
            instead = "; ".join(f"{g[0]} …" if len(g) > 1 else g[0] for g in groups[1:])
            places.missing.append(DataError(
                f"missing column '{first}'{nearest(first, header)}, or {instead} instead",
                file=path,
                remedy=f"map one of them in [columns]; the file has: {_some(header)}",
                foreign=True,
            ))  # fmt: skip
    return places


def _in_own_names(
    table: TableType, known: set[str], columns: Mapping[str, ForeignColumn]
) -> tuple[str, ...]:
    """The mapped columns of a file that has none of the recipe's names and footcal's own instead.

    A recipe that reads a robot's logs reads what `simulate`, `convert` and `kinematics` wrote of
    that robot, too.
    """
    mapped = [spec for spec in table.columns if spec.name in columns]
    mapped = [spec for spec in mapped if columns[spec.name].in_file]
    own = [spec.name in known for spec in mapped]
    foreign = any(columns[spec.name].column in known for spec in mapped)
    whole = all(there or spec.optional for there, spec in zip(own, mapped, strict=True))
    return tuple(spec.name for spec in mapped) if any(own) and whole and not foreign else ()


def _unit_in_name(column: str, spec: Column) -> str | None:
    """The unit by which a foreign name ends, if it is one of the quantity; else the canonical.

    With a question mark where it may be one: ``weight_gr``, or ``force_lb``, which may be of the
    left back foot.
    """
    if spec.suffix is None or spec.unit is None:
        return spec.unit
    bracketed = _IN_BRACKETS.search(column)
    end = bracketed[1].strip() if bracketed else re.split(r"[_ ]", column)[-1]
    if end in UNIT_SUFFIXES and converts(end, spec.suffix):
        return UNIT_SUFFIXES[end]
    no_word = end in (spec.unit, column) or (len(end) < _WORD and not bracketed)
    if no_word or is_reading(spec) or not may_mean(end, spec.unit):
        return spec.unit
    doubtful = end in MEANT or (end in PLACES_TOO and not bracketed)
    return f"{end}{NOT_SAID}" if doubtful else end


def _own_names(spec: Column, known: set[str]) -> dict[str, str | None]:
    """Names in a file that are the canonical one, or its stem with another unit; with the unit."""
    own: dict[str, str | None] = {spec.name: spec.unit} if spec.name in known else {}
    if spec.suffix is None:
        return own
    stem = spec.name.removesuffix(spec.suffix)
    for suffix, unit in UNIT_SUFFIXES.items():
        name = stem + suffix
        # true forces of a cell (left_fl_n) are not its counts in another unit
        if name in known and name != spec.name and converts(suffix, spec.suffix):
            own[name] = unit
    return own


def passed_over(places: Places, path: Path) -> list[Finding]:
    """Columns that the recipe gives although the file has the canonical ones, or only those."""
    found = [
        Finding(
            "column_passed_over", "note", path.name,
            f"{name} was read from '{places.found[name].column}', as [columns] says; the file has "
            f"{', '.join(others)} too",
            "take the entry out of [columns] if the other one is meant",
        )
        for name, others in places.passed_over.items()
    ]  # fmt: skip
    own = [name for name in places.not_mapped if name in places.found]
    if own:
        found.append(Finding(
            "columns_not_mapped", "note", path.name,
            f"the file has none of the names in [columns], and footcal's own: {_some(own)} were "
            "read as they are called",
            "nothing to do where footcal wrote the log; else correct [columns]",
        ))  # fmt: skip
    return found


def _some(names: Sequence[str], at_most: int = 8) -> str:
    return some_of([name[:40] for name in names], at_most)
