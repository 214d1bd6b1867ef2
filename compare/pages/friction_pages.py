"""The pages of contact with friction, by motion."""

import xarray as xr

from compare.pages.compression import COMPRESSION
from compare.pages.friction import MotionPage, motion_name
from compare.pages.rolling import ROLLING
from compare.pages.transient import TRANSIENT
from compare.report.charts import Chart
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene

PAGES: dict[str, MotionPage] = {"rolling": ROLLING, "transient": TRANSIENT, "compression": COMPRESSION}


def main_chart(dataset: xr.Dataset) -> Chart:
    """Return the main chart of the motion of labelled arrays, for all coefficients of friction."""
    return PAGES[motion_name(dataset)].main_chart(dataset)


def require_page(scene: Scene) -> None:
    """Raise BadScene where the motion of a contact with friction has no page."""
    motion = scene.contact.motion
    if scene.contact.friction and motion not in PAGES:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: no page: register one in {__name__}.PAGES, "
            f"or use one of {', '.join(PAGES)}"
        )
