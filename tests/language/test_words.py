"""Plain English: words that users must not read, and plurals that agree."""

from __future__ import annotations

import re

import pytest

from tests.language.words import PACKAGE, all_faults, faults, unknown_words


def test_users_read_plain_english() -> None:
    found = all_faults()
    assert not found, "\n" + "\n".join(map(str, found))


@pytest.mark.parametrize(
    "text",
    [
        "as in seed 1", "gain of 0.3 nats", "what is left of it", "tell hysteresis from creep",
        "visible beside it", "1 findings", "all 1 channels", "finding(s)", "see eq. (13)",
    ],
)  # fmt: skip
def test_the_check_finds_planted_faults(text: str) -> None:
    assert list(faults(text, "here"))


@pytest.mark.parametrize(
    "text",
    [
        "the left foot", "placements left out of the fit", "time (s)", "11 findings",
        "Wu & Revzen, eqs. (8)(9)", "a foot in the air", "besides the cells",
    ],
)  # fmt: skip
def test_the_check_lets_good_english_pass(text: str) -> None:
    assert not list(faults(text, "here"))


def test_the_code_too_says_distinguish_rival_and_comparison() -> None:
    words = re.compile(r"(?<![a-z])(told|kindred|contests?)(?![a-z])")
    assert not [p for p in PACKAGE.rglob("*.py") if words.search(p.stem + p.read_text())]


def test_a_working_word_stands_in_the_glossary() -> None:
    text = "A *hysteresis* is known, a *wobbliness* is not; **bold** is no word of ours."
    assert [f.text for f in unknown_words(text, "here", "| hysteresis | loops |")] == ["wobbliness"]
