"""What the files of a case call its holes and weights: numbers of a model in their own words.

Part of the room `core.inference`, beside `case`: a shape such as ``hole = 4`` says nothing to who
wrote ``8`` into the log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from footcal_cli.core.inference.problem import Signature


@dataclass(frozen=True)
class Written:
    """The words of the files.

    Parameters
    ----------
    holes
        Number of a hole in `Log.known` -> what the files call it.
    pieces
        Number of a piece, the bit of ``Log.known["pieces"]`` -> its name.
    load_unit, load_n
        Unit of the load column as it was written, and how many newtons one of it is.
    """

    holes: Mapping[int, str] = field(default_factory=dict)
    load_unit: str = "N"
    load_n: float = 1.0
    pieces: Mapping[int, str] = field(default_factory=dict)

    def named(self, signature: Signature) -> str:
        """The hole or the weight that an effect is about; empty for other effects."""
        shape = dict(signature.shape)
        if "hole" in shape:
            return self.holes.get(int(shape["hole"]), "")
        if "piece" in shape:
            return self.pieces.get(int(shape["piece"]), "")
        if "label" in shape:
            return f"written {shape['label'] / self.load_n:.5g} {self.load_unit}"
        return ""
