"""What becomes of the rivals of one log in the next."""

from __future__ import annotations

from dataclasses import replace

import pytest

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.suspects import Followed, Says, survivors
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.sheets.diagnosis.followed import followed_words

THERE = Followed("delay", Interval(1.1, 0.8, 1.4))
GONE = Followed("lag", Interval(0.05, -0.1, 0.2))
OPEN = Followed("clock_drift", Interval(0.4, -1.0, 1.8))
UNSEEN = Followed("sensor_lag", None)


@pytest.mark.parametrize(
    ("suspect", "says"),
    [
        (THERE, Says.THERE),
        (GONE, Says.GONE),
        (OPEN, Says.OPEN),
        (UNSEEN, Says.UNSEEN),
        # not nothing, and not what was asked for: both logs' doubts count
        (Followed("lag", Interval(0.3, 0.1, 0.5)), Says.OPEN),
        (Followed("lag", Interval(0.1, 0.02, 0.18)), Says.GONE),
        (Followed("lag", Interval(0.3, -0.1, 0.7)), Says.GONE),
        (Followed("lag", Interval(0.3, -0.1, 0.7), sd=0.4), Says.OPEN),
        (Followed("lag", Interval(0.1, -0.3, 0.5), sd=0.25), Says.GONE),
        (Followed("lag", Interval(0.1, -0.9, 1.1)), Says.OPEN),
        # sure to be there means sure not to be nothing
        (Followed("lag", Interval(0.9, -0.1, 1.9)), Says.OPEN),
    ],
)
def test_a_share_of_one_is_there_and_a_share_of_nothing_is_gone(
    suspect: Followed, says: Says
) -> None:
    assert suspect.says is says


def test_who_is_left() -> None:
    assert survivors(Verdict.NAMED, ["delay"], [GONE, OPEN, THERE]) == ("delay",)
    assert survivors(Verdict.NONE, [], [GONE, THERE, OPEN]) == ("delay",)
    # what the experiment took out of the question is left when the others are gone
    assert survivors(Verdict.NONE, [], [GONE, UNSEEN]) == ("sensor_lag",)
    assert survivors(Verdict.NONE, [], [OPEN, UNSEEN]) == ("clock_drift", "sensor_lag")
    # another name acquits nobody
    assert survivors(Verdict.NAMED, ["hysteresis"], [GONE, OPEN]) == ("clock_drift",)
    # beside something that nobody knows only who is there at just the size asked for is left
    assert survivors(Verdict.UNKNOWN, [], [THERE, UNSEEN]) == ("delay",)
    assert survivors(Verdict.UNKNOWN, [], [GONE, UNSEEN]) == ()
    assert survivors(Verdict.UNKNOWN, [], [THERE, replace(THERE, effect="lag")]) == ()
    much = Followed("delay", Interval(2.0, 1.6, 2.4))
    assert survivors(Verdict.UNKNOWN, [], [much, UNSEEN]) == ()
    # and without power nothing is said
    for silent in (Verdict.UNDERPOWERED, Verdict.BAD_DATA):
        assert survivors(silent, ["delay"], [THERE, GONE]) == ()


def test_the_sentence_names_who_is_left_and_what_the_others_lack() -> None:
    said = followed_words([THERE, GONE], ["delay"])
    assert "delay is left" in said
    assert "lag 0.05 [-0.10, 0.20]" in said
    assert "nothing certain" in followed_words([OPEN], [])
