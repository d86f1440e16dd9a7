"""A pytest plugin: the CPU seconds of every test, children included, into the file TEST_COSTS.

``TEST_COSTS=costs.tsv python -m pytest -p tests.mutations.costs``: unlike the durations of pytest
they hardly depend on what else the machine does.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Note what the test cost, with the fixtures that it was the first to ask for."""
    began = sum(os.times()[:4])
    yield
    with open(os.environ["TEST_COSTS"], "a", encoding="utf-8") as file:
        file.write(f"{item.nodeid}\t{sum(os.times()[:4]) - began:.3f}\n")
