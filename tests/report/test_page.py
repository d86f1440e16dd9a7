"""The page of a report: order, numbers, anchors, alignment, what cannot be seen in words."""

from __future__ import annotations

import re

import pytest
from matplotlib.figure import Figure

from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.quality import Finding
from footcal_cli.records.display_units import display_unit
from footcal_cli.records.results import (
    ParameterRecord,
    ParametersRecord,
    RmseRecord,
    RmseRow,
    RunRecord,
    VerdictRecord,
)
from footcal_cli.report import (
    Drawn,
    Picture,
    Report,
    Sheet,
    history_sheet,
    number,
    plural,
    rmse_sheet,
    with_same_decimals,
    with_sd,
)
from footcal_cli.report.page import _is_tall, _moment, _options_whole, render_html
from footcal_cli.sheets.diagnosis.words import with_interval

ALARM = Finding("stuck", "alarm", "left_rr", "reads 812 throughout", "replace the cable")
NOTE = Finding("repeats", "note", "left_fl", "few repeats", "repeat")
TABLE = Sheet(
    "Calibration", ("channel", "scale (N)", "status"),
    [("left_fl", "−3.40 ± 0.02", "estimated"), ("left_fr", "1,204", "fixed"),
     ("left_rl", "–", "not observable")],
)  # fmt: skip

_PNG = bytes.fromhex("89504e470d0a1a0a0000000d49484452000004000000020008060000000000")
"""The head of a picture of 1024 × 512."""


def page(**changes: object) -> str:
    parts: dict[str, object] = {
        "title": "Test",
        "verdict": VerdictRecord(
            level="warning",
            sentence="One cell does not fit.",
            actions=("Repeat it.",),
            details=("It is left_rr.",),
        ),
        "pictures": (
            Picture(
                "residuals",
                Figure,
                "Should be flat.",
                title="Residual by load",
                result="One cell does not fit.",
            ),
        ),
        "sheets": (TABLE, Sheet("Errors", ("a", "b"), [("x", "1")])),
        "findings": (ALARM, NOTE),
    }
    report = Report(**{**parts, **changes})  # type: ignore[arg-type]
    run = RunRecord(
        command="offline-fit", started="2026-11-24", arguments={}, recipe={}, options={},
        inputs={}, rows={}, seed=0, timings_s={}, verdict=report.verdict, exit_code=0,
    )  # fmt: skip
    return render_html(
        report, run, "{}", {"residuals": Drawn(_PNG)}, ("parameters.json", "rmse.csv")
    )


def test_result_and_action_come_before_evidence_and_details() -> None:
    text = page()
    order = [
        "One cell does not fit.", "→ Repeat it.", "It is left_rr.", "replace the cable",
        "Table 1. Calibration", "few repeats",
        "<figure", "Table 2. Errors", "parameters.json</a>",
    ]  # fmt: skip
    body = text[text.index("<main>") :]
    body = re.sub(r"<nav.*?</nav>", "", body, flags=re.DOTALL)
    places = [body.index(words) for words in order]
    assert places == sorted(places)


def test_only_a_long_note_of_a_table_is_folded() -> None:
    for note, folded in (("Bias at zero counts.", False), ("A rule of many words. " * 20, True)):
        text = page(sheets=(Sheet("Calibration", ("a",), [("x",)], note=note),))
        before = text[: text.index(note.strip())]
        assert before.rstrip().endswith('<p class="note">')
        assert ("How to read this table" in before) is folded


def test_every_link_of_the_page_leads_somewhere() -> None:
    text = page()
    anchors = set(re.findall(r'id="([^"]+)"', text))
    links = re.findall(r'href="#([^"]+)"', text)
    assert len(links) >= 4
    assert set(links) <= anchors


def test_numbers_stand_right_and_words_left() -> None:
    cells = re.findall(r'<td class="(\w+)">([^<]+)</td>', page())
    kinds = {cell: kind for kind, cell in cells}
    assert kinds["−3.40 ± 0.02"] == kinds["1,204"] == kinds["–"] == "number"
    assert kinds["left_fl"] == kinds["estimated"] == "word"


def test_a_figure_tells_its_result_to_readers_who_cannot_see_it() -> None:
    assert 'alt="Residual by load. One cell does not fit."' in page()


def test_findings_that_ask_for_the_same_ask_once() -> None:
    other = Finding("stuck", "alarm", "left_fl", "reads 0 throughout", "replace the cable")
    text = page(findings=(ALARM, other, NOTE))
    assert text.count("→ replace the cable") == 1
    assert "reads 812" in text
    assert "reads 0" in text


def test_a_column_in_which_nothing_stands_is_left_out() -> None:
    sheet = Sheet("T", ("a", "ridge", "b"), [("x", "–", "1"), ("y", "", "−0.00")])
    text = page(sheets=(sheet,))
    assert "ridge" not in text
    assert '<td class="number">0.00</td>' in text


def test_numbers_about_zero_share_their_decimals() -> None:
    assert with_same_decimals([0.0114, -0.00032, -1e-6, float("nan")]) == [
        "0.0114", "−0.0003", "0.0000", "–",
    ]  # fmt: skip
    assert with_same_decimals([1234.5, 0.2]) == ["1,234", "0"]


def test_one_unit_per_quantity_on_a_page() -> None:
    row = RmseRow(quantity="cop", unit="m", stage="after", reference="hole", split="all",
                  rmse=0.0005936, n=450)  # fmt: skip
    assert rmse_sheet(RmseRecord(rows=(row,), rejected={})).rows[0][4:6] == ("0.5936", "mm")
    history = history_sheet(
        calibration(-3.4e-5, 1e-8, "N/count"), calibration(-3.5e-5, 1e-8, "N/count"), "last.json"
    )
    assert history is not None
    assert history.rows[0][1:4] == ("−34.000 ± 0.010", "−35.000 ± 0.010", "µN/count")
    assert display_unit("N/count", [0.02, -0.01]) == (1e3, "mN/count")
    assert display_unit("N/count", [42.0, -38.0]) == (1.0, "N per unit read")  # of volts
    assert display_unit("N/count", [0.999, -1.02]) == (1.0, "N/N")  # of calibrated forces
    assert display_unit("N/count", [0.9, 0.6]) == (1.0, "N per unit read")


def test_an_interval_has_the_decimals_and_the_power_of_its_value() -> None:
    assert with_interval(Interval(11.0, 3.64, 14.0), "%") == "11.0 % [3.6, 14.0]"
    assert with_interval(Interval(0.721, 0.599, 0.842), "N") == "0.721 N [0.599, 0.842]"
    small = with_interval(Interval(-1.9e-5, -4e-5, 2.3e-6), "1/N")
    assert small == "(−1.9 [−4.0, 0.2]) × 10⁻⁵ 1/N"


def test_severity_and_level_are_told_in_words_and_marks() -> None:
    text = page()
    assert "✕ alarm" in text
    assert "! Needs attention" in text


def test_a_table_of_a_hostile_log_is_only_text() -> None:
    text = page(sheets=(Sheet("<script>", ("<b>",), [("<script>alert(1)</script>",)]),))
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text


def calibration(value: float, sd: float | None, unit: str = "N") -> ParametersRecord:
    one = ParameterRecord(value=value, sd=sd, unit=unit, status="estimated")  # type: ignore[arg-type]
    return ParametersRecord(
        command="offline-fit", created="2026-11-01", robot="r", gravity_mps2=9.8,
        sign_convention="", frame="", expressed_at="", parameters={"left_fl.bias": one},
    )  # fmt: skip


def test_history_counts_a_change_in_the_sd_that_was_known_before() -> None:
    sheet = history_sheet(calibration(2.0, 0.5), calibration(3.5, 0.1), "last.json")
    assert sheet is not None
    assert sheet.rows[0][1:5] == ("2.00 ± 0.50", "3.50 ± 0.10", "N", "+3.0")


@pytest.mark.parametrize("before", [None, calibration(2.0, 0.5, "mN")])
def test_history_compares_nothing_that_cannot_be_compared(before: ParametersRecord | None) -> None:
    assert history_sheet(before, calibration(3.5, 0.1), "last.json") is None


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(112.3, 2, "110"), (-1234.0, 3, "−1,230"), (0.012345, 3, "0.0123"), (8.4e6, 2, "8,400,000"),
     (999.7, 3, "1,000"), (None, 3, "–"), (8347750.0, 7, "8,347,750"), (4.2e-6, 2, "4.2 × 10⁻⁶"),
     (-6.02e23, 3, "−6.02 × 10²³")],
)  # fmt: skip
def test_numbers_are_written_out_where_people_would(
    value: float | None, digits: int, text: str
) -> None:
    assert number(value, digits) == text


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [(8347750.25, 1.3, "8,347,750.2 ± 1.3"), (1.234e-9, 2.5e-10, "(1.23 ± 0.25) × 10⁻⁹"),
     (-3e-9, 2e-8, "(−0.3 ± 2.0) × 10⁻⁸"), (2.5e6, 12000.0, "2,500,000 ± 12,000")],
)  # fmt: skip
def test_a_value_and_its_sd_share_digits_and_power(value: float, sd: float, text: str) -> None:
    assert with_sd(value, sd) == text


def test_no_line_of_a_page_breaks_within_an_option() -> None:
    page = str(_options_whole("start from it (--cop-correction); a<b -- no option"))
    assert page == (
        'start from it (<span class="whole">--cop-correction</span>); a&lt;b -- no option'
    )


def test_plurals() -> None:
    assert plural(1, "finding") == "1 finding"
    assert plural(2, "finding") == "2 findings"
    assert plural(3, "repeat of the loss", "repeats of the loss") == "3 repeats of the loss"


def test_a_column_of_numbers_has_as_many_digits_in_every_row() -> None:
    rows = [("before", "2.02"), ("memory", "1.3"), ("none", "–"), ("whole", "12")]
    text = page(sheets=(Sheet("Errors", ("method", "CoP (mm)"), rows),))
    assert ">1.30</td>" in text
    assert ">12</td>" in text
    fixed = [("a", "0.654"), ("b", "10.000"), ("c", "-1.500")]
    text = page(sheets=(Sheet("Errors", ("method", "likeness"), fixed),))
    assert ">0.654</td>" in text
    assert ">−1.500</td>" in text


def test_zero_has_no_sign_and_thousands_are_set_apart_from_four_digits_on() -> None:
    assert with_sd(-0.0001, 0.034) == "0.000 ± 0.034"
    assert number(-0.0) == "0"
    assert number(4799) == "4,799"
    assert number(1234.56, 6) == "1,234.56"
    assert plural(4800, "row") == "4,800 rows"


def test_the_moment_of_a_run_is_read_without_knowing_iso_8601() -> None:
    assert _moment("2026-11-25T19:13:43+00:00") == "2026-11-25 19:13 UTC"


def test_only_figures_as_high_as_wide_keep_their_size_on_paper() -> None:
    assert not _is_tall(_PNG)
    assert _is_tall(_PNG[:16] + _PNG[20:24] + _PNG[16:20])
