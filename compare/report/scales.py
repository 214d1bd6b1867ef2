"""Round levels of contours and the colours between them, by Matplotlib."""

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from matplotlib.ticker import MaxNLocator

from geometries.arrays import Array


def round_levels(low: float, high: float, most: int) -> Array:
    """Return round values in at most so many equal steps, (n + 1,), that enclose two values."""
    return np.asarray(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))


def shades(name: str, count: int) -> list[str]:
    """Return colours of a colour map at equal distances, as hexadecimal numbers."""
    return [to_hex(colour) for colour in colormaps[name](np.linspace(0.0, 1.0, count))]
