"""The pages of contact with friction, by motion."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import xarray as xr

from compare.friction.compression_page import write_compression
from compare.friction.rolling_page import write_rolling

PAGES: Mapping[str, Callable[[xr.Dataset, Path], Path]] = MappingProxyType(
    {"rolling": write_rolling, "compression": write_compression}
)
