"""The pages and main figures of contact with friction, by motion."""

from collections.abc import Callable
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from compare.friction.compression_page import sliding, write_compression
from compare.friction.rolling_page import creep_force, write_rolling
from compare.friction.transient_page import growth, write_transient
from femic.contact.motions import MOTIONS
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene

PAGES: dict[str, Callable[[xr.Dataset, Path], Path]] = {
    "rolling": write_rolling,
    "transient": write_transient,
    "compression": write_compression,
}
FIGURES: dict[str, Callable[[xr.Dataset], Figure]] = {
    "rolling": creep_force,
    "transient": growth,
    "compression": sliding,
}


def main_figure(dataset: xr.Dataset) -> Figure:
    """Draw the main figure of the motion whose dimension labelled arrays have."""
    motion = next(name for name in FIGURES if MOTIONS[name].dimension in dataset.dims)
    return FIGURES[motion](dataset)


def require_page(scene: Scene) -> None:
    """Raise BadScene where the motion of a contact with friction has no page."""
    motion = scene.contact.motion
    if scene.contact.friction and motion not in PAGES:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: no page: register one in {__name__}.PAGES, "
            f"or use one of {', '.join(PAGES)}"
        )
