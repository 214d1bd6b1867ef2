"""The pages of contact with friction, by motion."""

from collections.abc import Callable
from pathlib import Path

import xarray as xr

from compare.friction.compression_page import write_compression
from compare.friction.rolling_page import write_rolling
from compare.friction.transient_page import write_transient
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene

PAGES: dict[str, Callable[[xr.Dataset, Path], Path]] = {
    "rolling": write_rolling,
    "transient": write_transient,
    "compression": write_compression,
}


def require_page(scene: Scene) -> None:
    """Raise BadScene where the motion of a contact with friction has no page."""
    motion = scene.contact.motion
    if scene.contact.friction and motion not in PAGES:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: no page: register one in {__name__}.PAGES, "
            f"or use one of {', '.join(PAGES)}"
        )
