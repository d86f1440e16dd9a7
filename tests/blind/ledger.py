"""The sealed truth: kept apart from the logs, committed to before anything is diagnosed.

A commitment is ``SHA-256(secret + truth)``. The commitments lie beside the logs, the truth and the
secret lie in another folder; opening checks every truth against its commitment.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Stream = Literal["development", "sealed"]


class BrokenSealError(ValueError):
    """A truth does not match what was committed to."""


@dataclass(frozen=True)
class Ledger:
    """The truth's side of a run.

    Parameters
    ----------
    folder
        Never below, above or beside the logs that are diagnosed.
    stream
        Development seeds set thresholds; sealed seeds are scored once with them.
    secret
        Known for development, drawn for a sealed run.
    """

    folder: Path
    stream: Stream
    secret: bytes

    def seed(self, trial: str) -> int:
        """Seed of a trial of the plan; the two streams never meet."""
        return int.from_bytes(self._digest(f"seed {trial}")[:8], "big")

    def name(self, trial: str) -> str:
        """Name of a trial's folder; says nothing of its place in the plan."""
        return self._digest(f"name {trial}").hex()[:16]

    def commitment(self, truth: Mapping[str, Any]) -> str:
        """``SHA-256(secret + truth)`` as hexadecimal digits."""
        return hashlib.sha256(self.secret + canonical(truth)).hexdigest()

    def write(self, name: str, truth: Mapping[str, Any]) -> str:
        """Keep a truth; returns the commitment."""
        (self.folder / f"{name}.json").write_bytes(canonical(truth))
        return self.commitment(truth)

    def open(self, commitments: Mapping[str, str]) -> dict[str, dict[str, Any]]:
        """All truths by trial, checked.

        Raises
        ------
        BrokenSealError
            A truth is missing or is not what was committed to.
        """
        truths = {}
        for name, committed in commitments.items():
            path = self.folder / f"{name}.json"
            if not path.is_file():
                raise BrokenSealError(f"{name}: the truth is gone")
            truth = json.loads(path.read_bytes())
            if self.commitment(truth) != committed:
                raise BrokenSealError(f"{name}: the truth was changed after it was sealed")
            truths[name] = truth
        return truths

    def _digest(self, message: str) -> bytes:
        return hmac.new(self.secret, f"{self.stream} {message}".encode(), hashlib.sha256).digest()


def open_ledger(folder: Path, stream: Stream) -> Ledger:
    """The ledger in a folder; a sealed one draws its secret when it is first opened."""
    folder.mkdir(parents=True, exist_ok=True)
    if stream == "development":
        return Ledger(folder, stream, b"development seeds are no secret")
    path = folder / "secret.hex"
    if not path.is_file():
        path.write_text(secrets.token_hex(32), encoding="ascii")
        path.chmod(0o600)
    return Ledger(folder, stream, bytes.fromhex(path.read_text(encoding="ascii")))


def canonical(truth: Mapping[str, Any]) -> bytes:
    """One spelling of a truth as bytes."""
    return json.dumps(truth, sort_keys=True, ensure_ascii=False, allow_nan=False).encode()
