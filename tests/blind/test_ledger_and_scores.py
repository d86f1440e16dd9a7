"""The ledger cannot be reached or rewritten; verdicts made by hand get the scores they deserve."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blind.bench import Bench, hide, opened
from tests.blind.ledger import BrokenSealError, canonical, open_ledger
from tests.blind.plan import Cell, Planned
from tests.blind.scoring import Share, Verdict, judge, rho_at_power, risk_coverage

CELLS = [
    Planned("first", (Cell("null", "placements"),)),
    Planned("second", (Cell("single", "weights", ("creep/two_stage",), 0.5),)),
]


def _bench(folder: Path) -> Bench:
    root = folder / "run"
    root.mkdir(parents=True)
    return Bench(root, open_ledger(folder / "ledger", "sealed"))


def _truth(kind: str, *rights: str, size: float = 1.0, parameter: str = "p") -> dict[str, Any]:
    effects = [
        {"key": f"{right}/x", "right": right.split(), "size": size, "parameter": parameter}
        for right in rights
    ]
    return {"kind": kind, "experiment": "walk", "effects": effects, "rho": 0.5}


def _said(
    verdict: str, *names: str, rivals: tuple[tuple[str, ...], ...] = (), p: float = 1e-3
) -> Verdict:
    causes = [
        {"effect": n, "where": "all", "size": 1.05, "sd": 0.05, "ci95": [0.95, 1.15], "p": p}
        for n in names
    ]
    return Verdict.read({"verdict": verdict, "causes": causes, "rivals": rivals, "effects": []})


def test_truth_is_out_of_reach_of_the_logs_and_committed(tmp_path: Path) -> None:
    bench = _bench(tmp_path)
    hide(bench, CELLS, show=False)
    for path in bench.root.rglob("*"):
        if path.is_file() and path.suffix != ".parquet":
            text = path.read_text(encoding="utf-8")
            assert bench.ledger.secret.hex() not in text
            assert str(bench.ledger.folder) not in text
            assert '"effects"' not in text
    names = bench.commitments()["trials"]
    assert len(names) == 2
    assert all(len(commitment) == 64 for commitment in names.values())
    scores, content = opened(bench)
    assert scores == []
    assert content["hidden"] == 2


def test_ledger_beside_or_below_the_logs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must not lie with"):
        Bench(tmp_path, open_ledger(tmp_path / "ledger", "sealed"))


def test_hiding_goes_on_where_it_stopped(tmp_path: Path) -> None:
    bench = _bench(tmp_path)
    hide(bench, CELLS[:1], show=False)
    first = bench.commitments()["trials"]
    hide(bench, CELLS, show=False)
    both = bench.commitments()["trials"]
    assert len(both) == 2
    assert first.items() <= both.items()


def test_a_changed_truth_breaks_the_seal(tmp_path: Path) -> None:
    bench = _bench(tmp_path)
    hide(bench, CELLS, show=False)
    path = next(p for p in bench.ledger.folder.glob("*.json"))
    truth = json.loads(path.read_bytes())
    path.write_bytes(canonical({**truth, "rho": 2.0}))
    with pytest.raises(BrokenSealError, match="changed after it was sealed"):
        opened(bench)
    path.unlink()
    with pytest.raises(BrokenSealError, match="gone"):
        opened(bench)


@pytest.mark.parametrize(
    ("truth", "verdict", "exact", "right", "wrong"),
    [
        (_truth("null"), _said("none"), False, True, False),
        (_truth("null"), _said("unknown"), False, False, False),
        (_truth("null"), _said("named", "creep"), False, False, True),
        (_truth("single", "creep"), _said("named", "creep"), True, True, False),
        (_truth("single", "creep creep_slow"), _said("named", "creep_slow"), True, True, False),
        (_truth("single", "creep"), _said("named", "lag"), False, False, True),
        (_truth("single", "creep"), _said("named", "creep", "lag"), False, False, True),
        (_truth("single", "creep"), _said("named+unknown", "creep"), True, True, False),
        (_truth("single", "creep"), _said("none"), False, False, False),
        (_truth("single", "lag"), _said("ambiguous", rivals=(("lag", "delay"),)),
         False, True, False),
        (
            _truth("single", "lag"),
            _said("ambiguous", "delay", rivals=(("lag", "delay"),)),
            False, True, False,
        ),
        (_truth("single", "lag"), _said("ambiguous", rivals=(("mass", "tilt"),)),
         False, False, False),
        (
            _truth("single", "creep"), _said("ambiguous", "creep", rivals=(("hinge", "lag"),)),
            False, False, False,
        ),
        (_truth("pair", "creep", "lag"), _said("named", "creep", "lag"), True, True, False),
        (_truth("pair", "creep", "lag"), _said("named", "creep"), False, False, False),
        (
            _truth("pair", "creep", "lag"),
            _said("ambiguous", "creep", rivals=(("lag", "delay"),)),
            False, True, False,
        ),
        (_truth("unseen", ""), _said("unknown"), False, True, False),
        (_truth("unseen", ""), _said("none"), False, False, False),
        (_truth("unseen", ""), _said("named+unknown", "creep"), False, False, True),
        (_truth("left_out", "creep"), _said("ambiguous", rivals=(("lag", "x"),)),
         False, True, False),
        (_truth("left_out", "creep"), _said("named", "lag"), False, False, True),
        (_truth("switch", "channel_swap"), _said("bad-data"), False, True, False),
        (_truth("underpowered", "creep"), _said("underpowered"), False, True, False),
        (_truth("underpowered", "creep"), _said("named", "creep"), True, False, True),
        (_truth("small", "creep"), _said("named", "creep"), True, False, True),
        (_truth("small", "creep"), _said("none"), False, True, False),
    ],
)  # fmt: skip
def test_scores_of_verdicts_made_by_hand(
    truth: dict[str, Any], verdict: Verdict, exact: bool, right: bool, wrong: bool
) -> None:
    score = judge(truth, verdict)
    assert (score.exact, score.right, score.wrong) == (exact, right, wrong)


def test_rivals_that_one_remedy_serves_are_one_class() -> None:
    curves, mixed = ("hinge", "nonlinearity"), ("nonlinearity", "hysteresis")
    one = _truth("single", "nonlinearity")
    assert judge(one, _said("named", "nonlinearity")).of_one_class
    assert judge(one, _said("ambiguous", rivals=(curves,))).of_one_class
    assert not judge(one, _said("ambiguous", rivals=(mixed,))).of_one_class
    assert not judge(one, _said("ambiguous", rivals=(("hinge", "dead_zone"),))).of_one_class
    assert not judge(one, _said("unknown")).of_one_class
    two = _truth("pair", "nonlinearity", "crosstalk")
    assert judge(two, _said("ambiguous", "crosstalk", rivals=(curves,))).of_one_class
    assert not judge(two, _said("ambiguous", rivals=(curves,))).of_one_class


def test_a_mass_in_a_walk_must_be_called_not_testable() -> None:
    truth = _truth("untestable", "mass")
    rows = {"not_testable": True, "absent": False}
    for status, right in rows.items():
        record = {"verdict": "none", "effects": [{"effect": "mass", "status": status}]}
        assert judge(truth, Verdict.read(record)).right is right


def test_intervals_of_shares_against_published_values() -> None:
    # Wilson: Newcombe, Stat. Med. 17 (1998), Table I; Clopper–Pearson: the rule of three
    assert Share(81, 263).wilson() == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert Share(0, 20).wilson() == pytest.approx((0.0, 0.1611), abs=1e-4)
    assert Share(0, 300).upper() == pytest.approx(1 - 0.05 ** (1 / 300), rel=1e-9)
    assert Share(5, 5).upper() == 1.0


def test_size_coverage_counts_only_comparable_sizes() -> None:
    inside = judge(_truth("single", "creep", size=1.1), _said("named", "creep"))
    mirrored = judge(_truth("single", "creep", size=-1.1), _said("named", "creep"))
    outside = judge(_truth("single", "creep", size=1.3), _said("named", "creep"))
    other = judge(_truth("single", "creep", parameter=""), _said("named", "creep"))
    assert [s.covered for s in (inside, mirrored, outside, other)] == [True, True, False, None]


def test_power_is_interpolated_on_a_monotone_curve() -> None:
    scores = []
    for rho, hits in ((0.3, 4), (0.5, 6), (1.0, 10)):
        for i in range(10):
            verdict = _said("named", "creep") if i < hits else _said("none")
            scores.append(judge({**_truth("single", "creep"), "rho": rho}, verdict))
    rho, how = rho_at_power(scores)
    assert how == "interpolated"
    assert rho == pytest.approx(np.sqrt(0.5))  # half way in log ρ between 0.5 and 1
    assert rho_at_power(scores[-10:]) == (1.0, "below")
    assert rho_at_power(scores[:10]) == (0.3, "above")


def test_risk_grows_as_less_sure_answers_are_taken() -> None:
    sure = [judge(_truth("single", "creep"), _said("named", "creep", p=1e-6))] * 3
    unsure = [judge(_truth("single", "creep"), _said("named", "lag", p=0.009))]
    silent = [judge(_truth("single", "creep"), _said("none"))]
    known = [*unsure, *silent, *sure]
    coverage, risk = risk_coverage(known, known)
    assert coverage == pytest.approx([0.6, 0.8])
    assert risk == pytest.approx([0.0, 0.2])
    # what a confidence lets through where nothing was hidden
    between = [judge(_truth("null"), _said("named", "lag", p=0.001))]
    coverage, risk = risk_coverage(known, [*between, judge(_truth("null"), _said("none"))])
    assert coverage == pytest.approx([0.6, 0.6, 0.8])
    assert risk == pytest.approx([0.0, 0.5, 0.5])
