"""A calibration that was made from the logs under test is no baseline: the one before it is.

Room: session; called by diagnose. What `static-init` could take up of a fault it has taken up, and
how sure it is afterwards rests on the same samples. The calibration that it began with is known
from other data.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from footcal_cli.core.quality import Finding
from footcal_cli.records.results import ParametersRecord
from footcal_cli.session.request import read_calibration
from footcal_cli.tables.logfiles import digest

if TYPE_CHECKING:
    from footcal_cli.recipe.options import DiagnoseOptions
    from footcal_cli.session.session import Session

_REFIT = ("static-init", "online-replay")
"""Commands that go on from a calibration by what a robot does on its feet."""


def digests_of_logs(session: Session[DiagnoseOptions]) -> Iterator[str]:
    """SHA-256 of every file that this run may read, each as it is asked for."""
    return (digest(path) for path in session.input_paths() if path.is_file())


def begin_before(session: Session[DiagnoseOptions]) -> None:
    """Take the calibration that the given one began with, where that one was made from these logs.

    It is looked for where it lay then, and beside the given one's folder; the same file only.
    """
    record, given = session.parameters, session.request.parameters
    if record is None or given is None or record.command not in _REFIT:
        return
    begun = {name: sum_ for name, sum_ in record.inputs.items() if name.endswith(".json")}
    logs = set(record.inputs.values()) - set(begun.values())
    if len(begun) != 1 or not logs.issubset(digests_of_logs(session)):
        return
    (name, known), mine = *begun.items(), digest(given)
    places = (Path(name), given.parent / name, given.parent.parent / name)
    path = next((p for p in places if p.is_file() and digest(p) == known != mine), None)
    if path is None:
        return
    session.parameters = read_calibration(path, rejected=session.options.takes_rejected)
    session.inputs[str(path)] = known
    session.note([_said(given, path, record)])


def _said(given: Path, path: Path, record: ParametersRecord) -> Finding:
    return Finding(
        "calibrated_by_itself", "note", given.name,
        f"{record.command} made {given} from these very logs, and took up what it could of any "
        f"fault in them: the diagnosis begins with {path}, as that command did",
        "give --parameters of a calibration made from other logs",
    )  # fmt: skip
