"""What `make demo` says of its reports is true of the runs it makes."""

from __future__ import annotations

import re

from tests.conftest import REPOSITORY


def test_the_demo_explains_every_report_that_it_makes() -> None:
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    (explained,) = re.findall(r"define DEMO_REPORTS\n(.*?)\nendef", makefile, re.DOTALL)
    (recipe,) = re.findall(r"^demo:.*?\n((?:\t.*\n)+)", makefile, re.MULTILINE)
    made = re.findall(r"--out \$\(OUT\)/(\w+)", recipe)
    named = re.findall(r"\$\(OUT\)/(\w+)/report\.html +\S", explained)
    assert len(made) == len(set(made)) > 10
    assert set(named) == set(made)
    assert named[-1] == "diagnosis" == made[-1]
