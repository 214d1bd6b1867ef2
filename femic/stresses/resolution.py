"""How finely sections and waves are resolved."""

from dataclasses import dataclass, replace

from geometries.errors import WrongInput

CELLS = 32.0
GROWTH = 0.5
COARSEST, FINEST = 0.1, 10.0  # fineness
FEWER_WAVES = 1.5  # factor on the spacing of wavenumbers, and on the largest one, of coarser resolution


@dataclass(frozen=True)
class Resolution:
    """Cells across the loaded width and their growth away from it; spacing and largest k over the default."""

    cells: float
    growth: float
    spacing: float
    largest: float

    @classmethod
    def at_fineness(cls, fineness: float) -> "Resolution":
        """The default at a fineness of 1; raises WrongInput for a fineness out of range."""
        if not COARSEST <= fineness <= FINEST:
            raise WrongInput(
                f"fineness = {fineness!r}: must lie in {COARSEST:g} ... {FINEST:g}; 1 is the default"
            )
        return cls(CELLS * fineness, GROWTH / max(1.0, fineness) ** 0.5, 1 / fineness, min(1.0, fineness))

    @property
    def coarser(self) -> "Resolution":
        """Cells of twice the size, fewer wavenumbers."""
        return replace(
            self, cells=self.cells / 2, spacing=FEWER_WAVES * self.spacing, largest=self.largest / FEWER_WAVES
        )
