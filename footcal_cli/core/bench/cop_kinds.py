"""Which corrections of a CoP there are, simple ones first, and how many numbers each of them fits.

Room: core/bench; `cop_models` fits them, studies and sheets name them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

TERMS = {"none": 0, "affine": 3, "quadratic": 6, "full": 6}
"""Polynomial terms of the empirical corrections in the order 1, x, y, x², xy, y²."""


@dataclass(frozen=True)
class CopModel:
    """One way of turning cell forces into CoP and vertical force.

    Parameters
    ----------
    name
        ``none affine quadratic full``, ``cell positions``, ``crosstalk and cell positions``,
        ``crosstalk, cell positions and biases``; with gains ``cell gains and positions``, ``cell
        gains, positions and biases``.
    physical
        Whether it corrects cells instead of the CoP.
    with_forces
        Empirical: the forces enter (eq. (4), second part). Physical: the shares s_i are free.
    with_bias
        Physical: the offsets f and m are free.
    with_gains
        Physical: the shares s_i are gains of the cells, not a crosstalk between them.
    places_known
        With gains: all cells are where they are believed, ``q_i = s_i p_i``. Of four cells under a
        rigid plate, whose forces follow the two coordinates of the load, only that distinguishes
        a gain from places.
    single
        With gains: only that of the one cell which explains most.
    """

    name: str
    physical: bool = False
    with_forces: bool = False
    with_bias: bool = False
    with_gains: bool = False
    places_known: bool = False
    single: bool = False

    def terms(self, cells: tuple[str, ...]) -> tuple[str, ...]:
        """Names of the empirical terms in the order of the coefficients."""
        names = ("1", "x", "y", "x²", "xy", "y²")[: TERMS.get(self.name, 0)]
        return (*names, *(cells if self.with_forces else ()))

    @property
    def needs_cells(self) -> bool:
        """Whether it looks at the cells' forces and not at the CoP alone."""
        return self.physical or self.with_forces

    def coefficients(self, cells: int) -> int:
        """How many numbers it fits."""
        if not self.physical:
            return 2 * (TERMS[self.name] + (cells if self.with_forces else 0))
        if self.places_known:
            return 1 if self.single else cells
        return 2 * cells + (cells if self.with_forces else 0) + 3 * self.with_bias


NONE = CopModel("none")
AFFINE = CopModel("affine")
QUADRATIC = CopModel("quadratic")
FULL = CopModel("full", with_forces=True)
POSITIONS = CopModel("cell positions", physical=True)
CROSSTALK = CopModel("crosstalk and cell positions", physical=True, with_forces=True)
BIASED = CopModel(
    "crosstalk, cell positions and biases", physical=True, with_forces=True, with_bias=True
)
MODELS = (NONE, AFFINE, POSITIONS, QUADRATIC, CROSSTALK, BIASED, FULL)
"""All alternatives, simple ones first (for a foot of four cells)."""
_GAINS = {
    CROSSTALK: replace(CROSSTALK, name="cell gains and positions", with_gains=True),
    BIASED: replace(BIASED, name="cell gains, positions and biases", with_gains=True),
}
ONE_GAIN = CopModel("gain of one cell", physical=True, with_forces=True, with_gains=True,
                    places_known=True, single=True)  # fmt: skip
GAINS = replace(ONE_GAIN, name="cell gains", single=False)
GAINS_AND_PLACES = _GAINS[CROSSTALK]
GAIN_MODELS = (NONE, ONE_GAIN, GAINS, *(_GAINS.get(model, model) for model in MODELS[1:]))
"""The same of cells whose scales no weights measured."""
