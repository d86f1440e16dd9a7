"""The records that stand in files of their own, by name."""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.records.diagnosis import DiagnosisRecord, PlanRecord
from footcal_cli.records.files import Versioned
from footcal_cli.records.results import (
    AnswerRecord,
    CopCorrectionsRecord,
    ParametersRecord,
    RmseRecord,
    RunRecord,
    TruthRecord,
)

SCHEMAS: Mapping[str, type[Versioned]] = {
    "parameters": ParametersRecord,
    "rmse": RmseRecord,
    "run": RunRecord,
    "answer": AnswerRecord,
    "truth": TruthRecord,
    "diagnosis": DiagnosisRecord,
    "plan": PlanRecord,
    "cop-correction": CopCorrectionsRecord,
}
"""Name on the command line -> record."""
