"""The selection is repeated without blocks of every kind alike."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.nested import folds_of


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
