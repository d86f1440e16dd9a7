"""What a refit that is no better makes of a cause that its linear proxy found."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.curves import Curve
from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.form import Form
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import Unnamed
from footcal_cli.core.diagnosis.verdicts import _verdict
from footcal_cli.core.inference.lines import Line

QUIET = Detection(
    groups=("gait phase",), group_p=np.ones(1), bump_p=0.6, flexible_p=1.0, line=Line(),
    curve=Curve(), between_p=1.0, spell_p=1.0, flexible_gain=np.zeros(12), loss=np.ones(12),
    driver="",
)  # fmt: skip
LOUD = replace(QUIET, flexible_p=1e-4, flexible_gain=np.full(12, 0.1))


def _said(before: Detection, removed: float, *unnamed: Unnamed) -> Verdict:
    rounds = [
        SimpleNamespace(verdict=Verdict.NAMED, before=before, library=SimpleNamespace(causes=())),
        SimpleNamespace(verdict=Verdict.NONE, before=before, library=SimpleNamespace(causes=())),
    ]
    signature = SimpleNamespace(effect="hysteresis", cause=("hysteresis", "width", "left"))
    cause = SimpleNamespace(signature=signature, rivals=())
    return _verdict(cast(Any, rounds), cast(Any, [cause]), None, unnamed, Rules(), removed)[0]


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
