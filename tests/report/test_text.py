"""What a report prints in a terminal."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Report, Sheet
from footcal_cli.report.text import print_text


def printed(sheet: Sheet) -> str:
    report = Report(
        title="t", verdict=VerdictRecord(level="good", sentence="Fine."),
        sheets=(sheet,),
    )  # fmt: skip
    text = io.StringIO()
    print_text(report, Console(file=text, width=100))
    return text.getvalue()


def test_a_pipe_is_wrapped_only_where_its_width_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    sentence = "A scale and a bias describe all 8 channels, and nothing else is in the data."
    report = Report(title="t", verdict=VerdictRecord(level="good", sentence=sentence))
    for width in (None, "60"):
        monkeypatch.delenv("COLUMNS", raising=False)
        if width:
            monkeypatch.setenv("COLUMNS", width)
        text = io.StringIO()
        print_text(report, Console(file=text, width=60))
        lines = text.getvalue().splitlines()
        assert len(lines) == (2 if width else 1)
        assert not width or max(map(len, lines)) <= 60


def test_no_line_breaks_within_an_option(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    sentence = "Start the next command from this file, next to the page (--parameters)."
    text = io.StringIO()
    report = Report(title="t", verdict=VerdictRecord(level="good", sentence=sentence))
    print_text(report, Console(file=text, width=60))
    assert "(--parameters)." in text.getvalue()


def test_folded_rows_are_counted_and_left_out() -> None:
    rows = [(name, "1") for name in ("first", "second", "third")]
    text = printed(Sheet("S", ("name", "size"), rows, folded_after=1))
    assert "first" in text
    assert "second" not in text
    assert "2 more rows in the report" in " ".join(text.split())


def test_a_table_that_is_not_folded_is_printed_whole() -> None:
    text = printed(Sheet("S", ("name", "size"), [("first", "1"), ("last [N]", "2")]))
    assert "last [N]" in text
    assert "more rows" not in text


def test_numbers_stand_right_in_a_terminal_with_as_many_digits_in_every_row() -> None:
    rows = [("left_fl", "0.25", "estimated"), ("left_fr", "12.108", "fixed")]
    lines = printed(Sheet("S", ("channel", "worst (N)", "status"), rows)).splitlines()
    ends = [line.index(cell) + len(cell) for line, cell in
            ((next(x for x in lines if name in x), cell) for name, cell in
             (("left_fl", "0.250"), ("left_fr", "12.108")))]  # fmt: skip
    assert ends[0] == ends[1]


def test_a_column_in_which_nothing_stands_is_not_printed() -> None:
    text = printed(Sheet("S", ("a", "ridge", "b"), [("x", "–", "1")], brief=("a", "ridge", "b")))
    assert "ridge" not in text
    assert "more column" not in text
