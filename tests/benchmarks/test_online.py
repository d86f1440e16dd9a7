"""The contenders of `make bench` do the same thing: they give the same answers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from footcal_cli.core.study.window import WindowTrack
from tests.benchmarks.contenders import Contender, contenders
from tests.benchmarks.limits import compiler


@pytest.fixture(scope="module")
def groups() -> dict[str, dict[str, Callable[[], object]]]:
    found: dict[str, dict[str, Callable[[], object]]] = {}
    for one in contenders():
        assert isinstance(one, Contender)
        found.setdefault(one.group, {})[one.name] = one.run
    return found


def theta(answer: object) -> np.ndarray:
    """Solutions of a window, (u, settings, 2c)."""
    if isinstance(answer, WindowTrack):
        return np.concatenate([answer.gain, answer.bias_n], axis=2)
    return np.asarray(answer).reshape(-1, np.asarray(answer).shape[-2], 16)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("start", ["window, up to 5", "window, sliding sums, 64"])
def test_windows_in_c_solve_what_the_package_solves(
    groups: dict[str, dict[str, Callable[[], object]]], start: str
) -> None:
    own = next(group for name, group in groups.items() if name.startswith(start))
    package, limit = theta(own["compiled"]()), np.asarray(own["C limit"]())
    np.testing.assert_allclose(
        limit.reshape(package.shape), package, atol=1e-7 * np.abs(package).max()
    )


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_the_filter_in_c_and_in_a_textbook_find_what_the_package_finds(
    groups: dict[str, dict[str, Callable[[], object]]],
) -> None:
    own = next(group for name, group in groups.items() if "without the search" in name)
    textbook, limit = np.asarray(own["textbook NumPy loop with an inverse"]()), own["C limit"]()
    np.testing.assert_allclose(np.asarray(limit), textbook, atol=1e-7 * np.abs(textbook).max())
