"""Effects of a user's own as they stand in a recipe (``[[effect]]``) and in a calibration."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from footcal_cli.core.log import ExperimentName as ExperimentName
from footcal_cli.records.models import Frozen


class OwnShape(Frozen):
    """A number of the formula that only shapes the effect, tried at some values."""

    unit: str
    values: tuple[float, ...] = Field(min_length=1)


class OwnEffect(Frozen):
    """An effect of the user's own: ``y = x + adds``, x the load of a cell or of an axis.

    `adds` is a formula of recorded signals and of `size`, the number that says how large the effect
    is; it adds nothing where that is zero. `usual` is the size met in practice, `bounds` what is
    physically possible, `per` who has a size of its own, `experiments` whose logs show it (all that
    know its signals where absent).
    """

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=60)
    adds: str
    unit: str
    usual: float = Field(gt=0)
    remedy: str = Field(min_length=1)
    size: str = Field(default="k", pattern=r"^[A-Za-z][A-Za-z0-9_]*$")
    bounds: tuple[float, float] | None = None
    per: Literal["cell", "foot", "leg", "robot"] = "cell"
    experiments: tuple[ExperimentName, ...] = ()
    shapes: dict[str, OwnShape] = Field(default_factory=dict)
    source: str = "the user's recipe"
