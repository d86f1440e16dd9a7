"""The selection is repeated without blocks of every kind alike."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Compared
from footcal_cli.core.diagnosis.nested import Nested, folds_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature


def test_no_fold_takes_more_than_its_share_of_one_cells_sessions() -> None:
    kind = np.repeat([0, 1, 2], [13, 12, 14])
    fold = folds_of(kind, 12)
    for number in (0, 1, 2):
        assert np.bincount(fold[kind == number]).max() <= 2
    assert np.unique(fold).size == 12


def test_neighbours_of_one_kind_are_left_out_together() -> None:
    fold = folds_of(np.zeros(30, dtype=np.int64), 12)
    assert np.all(np.diff(fold) >= 0)
    assert fold[0] == 0
    assert fold[-1] == 11


def test_of_few_blocks_each_is_a_fold() -> None:
    assert folds_of(np.zeros(5, dtype=np.int64), 12).tolist() == [0, 1, 2, 3, 4]


def test_blocks_of_which_each_is_a_kind_of_its_own_are_not_all_left_out_at_once() -> None:
    """Attitudes of one leg, of which none knows another's tilt."""
    assert folds_of(np.arange(13), 12).max() == 11
    assert folds_of(np.arange(6)[::-1], 3).tolist() == [0, 0, 1, 1, 2, 2]


def test_a_look_alike_that_a_refit_refused_leads_to_the_same_cause() -> None:
    """For what it loses, or for what it leaves where the cause leaves nothing."""

    def excess(low: float) -> Compared:
        return Compared(Interval(low + 0.5, low, low + 1.0), 0.001, 0.4)

    cause = Cause(
        Signature("clock_drift", "clock_drift", "robot", "s/s"), Interval(2e-3, 1.9e-3, 2.1e-3),
        0.004, Interval(0.9, 0.8, 1.0), 9, 0.0, rivals=(), places=(),
        compared={"delay": excess(0.7), "imu_tilt": excess(-0.1)},
    )  # fmt: skip
    chosen = tuple(
        frozenset(names) for names in (["clock_drift"], ["delay"], ["imu_tilt"], ["com_offset"])
    )
    nested = Nested(np.arange(4), chosen, np.zeros((4, 1)), np.zeros((4, 1)), np.zeros(4))
    assert nested.alike([cause.begun_by]).tolist() == [True, True, True, False]


def test_a_cause_that_was_dropped_may_be_chosen_beside_the_others() -> None:
    chosen = tuple(map(frozenset, (["a"], ["a", "b"], ["a", "c"], ["b"], ["b", "c"])))
    nested = Nested(np.arange(5), chosen, np.zeros((5, 1)), np.zeros((5, 1)), np.zeros(5))
    alike = nested.alike([frozenset("a")], [frozenset("b")])
    assert alike.tolist() == [True, True, False, False, False]


def test_a_pair_is_proposed_without_a_fold_where_it_is_one_of_the_likely_ones() -> None:
    a, b, c = map(frozenset, (["a", "b"], ["a", "c"], ["a"]))
    none = np.zeros((3, 1))
    pairs = ((a, b), (b,), (c, a))
    nested = Nested(np.arange(3), (a, b, c), none, none, np.zeros(3), pairs)
    assert nested.proposed([frozenset("a"), frozenset("b")]).tolist() == [True, False, True]
    # a rival of one of the two may be in its place
    assert nested.proposed([frozenset("a"), frozenset("bc")]).tolist() == [True, True, True]
