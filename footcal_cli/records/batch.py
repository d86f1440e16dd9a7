"""One session of a batch as it is kept: what went in, how it ended, what was found."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from footcal_cli.records.files import Versioned
from footcal_cli.records.results import ParameterRecord, VerdictRecord

SessionOutcome = Literal["done", "gate not met", "refused"]


class SessionRecord(Versioned):
    """``rows/<session>.json``: a finished session.

    `digest` is of all that the result depends on: logs, recipe, starting calibration, command, seed
    and version; a session with the same digest is not run again. `reason` is the one line of a
    refusal or the gate that was not met; `attempts` counts workers that died over it, too.
    """

    schema_name: Literal["footcal.session"] = Field(default="footcal.session", alias="schema")
    session: str
    robot: str
    date: str | None
    operator: str
    command: str
    logs: tuple[str, ...]
    outcome: SessionOutcome
    exit_code: int
    reason: str
    digest: str
    attempts: int
    seconds: float
    rows: int
    verdict: VerdictRecord | None = None
    findings: tuple[str, ...] = ()
    parameters: dict[str, ParameterRecord] = Field(default_factory=dict)
    rmse: dict[str, float] = Field(default_factory=dict)
