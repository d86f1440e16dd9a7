"""What a refit that is no better makes of a cause that its linear proxy found."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis import rivals, ways
from footcal_cli.core.diagnosis.answer import EffectRow, EffectStatus, Verdict
from footcal_cli.core.diagnosis.curves import Curve
from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.engine import left_apart
from footcal_cli.core.diagnosis.form import Form
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.material import Nameless
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import Unnamed
from footcal_cli.core.diagnosis.verdicts import _verdict
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.lines import Line
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.written import Written
from footcal_cli.sheets.diagnosis.sentences import _surest

QUIET = Detection(
    groups=("gait phase",), group_p=np.ones(1), bump_p=0.6, flexible_p=1.0, line=Line(),
    curve=Curve(), between_p=1.0, spell_p=1.0, flexible_gain=np.zeros(12), loss=np.ones(12),
    driver="",
)  # fmt: skip
LOUD = replace(QUIET, flexible_p=1e-4, flexible_gain=np.full(12, 0.1))


_HYSTERESIS = SimpleNamespace(
    signature=SimpleNamespace(effect="hysteresis", cause=("hysteresis", "width", "left")), rivals=()
)


def _said(before: Detection, removed: float, *unnamed: Unnamed) -> Verdict:
    rounds = [
        SimpleNamespace(verdict=Verdict.NAMED, before=before, library=SimpleNamespace(causes=())),
        SimpleNamespace(verdict=Verdict.NONE, before=before, library=SimpleNamespace(causes=())),
    ]
    return _verdict(cast(Any, rounds), cast(Any, [_HYSTERESIS]), None, unnamed, Rules(), removed)[0]


def test_a_cause_whose_refit_removes_nothing_is_none_where_nothing_else_is_seen() -> None:
    assert _said(QUIET, -0.1) is Verdict.NONE
    assert _said(QUIET, 0.5) is Verdict.NAMED


def test_it_is_unknown_where_something_is_seen() -> None:
    assert _said(LOUD, -0.1) is Verdict.UNKNOWN


def test_a_name_that_a_nameless_curve_replaces_or_adds_to_is_unknown() -> None:
    nothing, much = np.zeros(12), np.full(12, 0.1)
    assert _said(QUIET, 0.5, Unnamed(Form(0.4, nothing), rival=False)) is Verdict.NAMED
    assert _said(QUIET, 0.5, Unnamed(Form(0.4, nothing), rival=True)) is Verdict.UNKNOWN
    assert _said(QUIET, 0.5, Unnamed(Form(1e-4, much), rival=False)) is Verdict.UNKNOWN
    assert _said(QUIET, 0.5, Unnamed(Form(1e-4, 1e-3 * much), rival=False)) is Verdict.NAMED


def test_what_is_left_counts_against_a_name_only_where_it_matters() -> None:
    """A name of 3 beside 1.2 that any function of the signals explains: 71 % of both."""
    small = replace(LOUD, tolerated=0.2)
    assert _said(LOUD, 3.0) is Verdict.UNKNOWN
    assert _said(small, 3.0) is Verdict.NAMED
    assert _said(small, 2.7) is Verdict.UNKNOWN


def test_a_size_that_changes_counts_by_what_its_change_explains() -> None:
    """Of 3 + 0.08 the constant size explains 97.4 %, of 3 + 0.12 it explains 96.2 %."""
    for bought, verdict in ((0.08, Verdict.NAMED), (0.12, Verdict.UNKNOWN)):
        form = Form(1e-4, np.full(12, bought / 12))
        rounds = [SimpleNamespace(verdict=Verdict.NAMED, before=replace(LOUD, tolerated=0.2),
                                  library=SimpleNamespace(causes=()))] * 2  # fmt: skip
        said = _verdict(cast(Any, rounds), cast(Any, [_HYSTERESIS]), form, (), Rules(), 3.0)[0]
        assert said is verdict


@dataclass(frozen=True)
class _Round:
    before: Detection
    rules: Rules = field(default_factory=Rules)


@dataclass(frozen=True)
class _Way:
    rounds: tuple[_Round, ...]
    current: Any = field(default_factory=lambda: SimpleNamespace(traces=None, raw=None))


@pytest.mark.parametrize(
    ("rate_hz", "whole_n", "aside"), [(0.0, 0.08, True), (0.0, 0.3, False), (20.0, 0.08, False)]
)
def test_spells_of_placements_are_as_large_as_their_error_at_most(
    monkeypatch: pytest.MonkeyPatch, rate_hz: float, whole_n: float, *, aside: bool
) -> None:
    left = (Nameless("fz", "N", 0.0, whole_n, 0.06, 0.2),)
    monkeypatch.setattr(ways, "nameless_beside", lambda *_, **__: left)
    subject = SimpleNamespace(problem=SimpleNamespace(rate_hz=rate_hz))
    way = _Way((_Round(replace(QUIET, spell_p=2e-4)),))
    seen = ways.at_its_size(cast(Any, subject), cast(Any, way))
    assert left_apart(seen.rounds[-1].before, Rules()) is not aside


@pytest.mark.parametrize(
    ("mine", "its", "more"),
    [((1e-8, 30.3), (0.89, 0.02), True),
     ((0.01, 8.0), (0.89, 0.02), False),
     ((1e-8, 30.3), (1e-3, 9.0), False)],
)  # fmt: skip
def test_a_cause_is_out_beside_one_that_adds_much_and_to_which_it_adds_little(
    monkeypatch: pytest.MonkeyPatch,
    mine: tuple[float, float],
    its: tuple[float, float],
    *,
    more: bool,
) -> None:
    best, other = cast(Any, "best"), cast(Any, "other")
    monkeypatch.setattr(rivals, "adding_p", lambda _, one, *__: mine if one == "best" else its)
    nothing = cast(Any, None)
    found = rivals.adds_more(nothing, best, other, [], nothing, nothing, Rules())
    assert found is more


@pytest.mark.parametrize(
    ("p", "status", "said"),
    [(1e-4, EffectStatus.ABSENT, True), (0.2, EffectStatus.ABSENT, False),
     (1e-4, EffectStatus.UNDECIDED, False)],
)  # fmt: skip
def test_a_cause_that_is_sure_and_small_is_quoted_with_its_size(
    p: float, status: EffectStatus, said: bool
) -> None:
    """*None* does not call noise what one effect surely explains."""
    signature = Signature("cross_coupling", "size", "fr", "", owners=(("fr", ("fr.fx",)),))
    size = Interval(-0.0429, -0.0598, -0.0259)
    row = EffectRow(signature, size, 0.12, 0.074, 0.25, p, 0.06, 17.0, 14, status, "")
    refused = SimpleNamespace(refused=())
    one = SimpleNamespace(
        effects=(row,), rules=Rules(), before=SimpleNamespace(p=1e-5), search=refused
    )
    case = SimpleNamespace(written=Written())
    found = cast(Investigation, SimpleNamespace(rounds=(one,), case=case))
    sentence = _surest(found)
    assert (sentence is not None) == said
    if sentence is not None:
        assert "cross coupling in fr, −0.0429 [−0.0598, −0.0259]" in sentence
        assert "from 0.12 on it would matter" in sentence
