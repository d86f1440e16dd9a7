"""The list of tests that take long names tests that are there."""

from __future__ import annotations

from pathlib import Path

from tests.thorough import listed, long_ones


def test_each_listed_test_is_there(repository: Path) -> None:
    for name in sorted(listed()):
        file, _, function = name.partition("::")
        assert f"def {function.rpartition('::')[2]}(" in (repository / file).read_text("utf-8"), (
            name
        )


def test_contracts_stay_however_long_they_take() -> None:
    lines = [
        "9.00s call     tests/contract/test_a.py::test_b",
        "0.90s setup    tests/core/c.py::d[1]",
        "0.90s call     tests/core/c.py::d[2]",
    ]
    assert long_ones(lines) == ["tests/core/c.py::d"]
