"""Effects beyond chance that are no cause: one sentence per reason, units of the table."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import EffectStatus, Verdict
from footcal_cli.core.diagnosis.refusal import Refusal, Why
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.problem import Signature
from footcal_cli.records.results import VerdictRecord
from footcal_cli.sheets.diagnosis import report, sentences
from footcal_cli.sheets.diagnosis.contract import Answer
from footcal_cli.sheets.diagnosis.refused import refused_lines


def flip(where: str, size: float) -> Refusal:
    return Refusal(Signature("sign_flip", "sign_flip", where, "-"), Why.IMPOSSIBLE, size)


def test_places_of_one_effect_share_a_sentence_in_per_cent() -> None:
    lines = refused_lines([flip("left_fl", 0.0209), flip("left_fl", 0.0209), flip("rr", -0.0155)])
    assert lines == ["Sign flip in left_fl (2.1 %) and rr (−1.6 %): no such size is possible."]


def test_a_cause_that_predicts_too_little_says_how_little_and_what_is_needed() -> None:
    slope = Signature("floor_slope", "floor_roll", "robot", "rad")
    lines = refused_lines([Refusal(slope, Why.LITTLE, 0.001, share=0.003, limit=0.01)])
    assert len(lines) == 1
    assert lines[0].startswith("Floor slope (0.3 % of the squared error, 1.0 % are needed): ")


def test_every_reason_has_its_own_sentence() -> None:
    tilt = Signature("imu_tilt", "imu_roll", "robot", "rad")
    tried = [Refusal(tilt, why, 0.01, 0.1, 0.05, 0.2) for why in Why]
    lines = refused_lines(tried)
    assert len(set(lines)) == len(Why)
    assert all(line.startswith("IMU tilt") and line.endswith(".") for line in lines)
    assert not any(" rad" in line or "_" in line for line in lines)


@pytest.mark.parametrize(("informative", "enough"), [(12.0, True), (5.5, False)])
def test_blocks_that_are_enough_are_not_called_too_few(
    monkeypatch: pytest.MonkeyPatch, informative: float, *, enough: bool
) -> None:
    """Eight are needed: where twelve inform of an effect it is their content that is too little."""
    row = SimpleNamespace(status=EffectStatus.NOT_TESTABLE, informative=informative)
    first = SimpleNamespace(rules=Rules(), smallest_p=5e-4, effects=[row])
    found: Any = SimpleNamespace(problem=SimpleNamespace(blocks=12), rounds=[first])
    monkeypatch.setattr(sentences, "cannot_lines", lambda *_: [])
    sentence, _ = sentences.underpowered(cast("Any", found), {})
    assert ("8 are needed" in sentence) is not enough
    assert sentence.startswith("Too little moves" if enough else "Too short")


def test_cells_with_too_few_sessions_are_named_with_how_many(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Twelve blocks of four cells reach the level, three of one do not."""
    logs = [SimpleNamespace(channels=(c,), block=np.arange(3).repeat(5)) for c in "ABCD"]
    first = SimpleNamespace(rules=Rules(), smallest_p=5e-4)
    found: Any = SimpleNamespace(
        case=SimpleNamespace(logs=logs), rounds=[first], verdict=Verdict.UNDERPOWERED
    )
    said = VerdictRecord(level="warning", sentence="Record at least 1 more.")
    monkeypatch.setattr(report, "study_sentence", lambda _: None)
    alone: Any = [SimpleNamespace(channel="B")]
    answer = report._undecided(Answer(said, (), None, None), found, alone)
    assert answer.verdict.sentence == (
        "1 of 4 cells need more than a scale and a bias: B. "
        "Too few blocks to name the cause: 3 of B."
    )
