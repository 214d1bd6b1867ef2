"""Figures of labelled results, which notebooks show and `savefig` writes."""

from io import BytesIO

import xarray as xr
from matplotlib.figure import Figure

from compare.contact.figures import surfaces
from compare.friction.pages import main_figure
from compare.ics.curves import curves_in
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS


def plot_ics(ics: xr.Dataset, component: str = "nn") -> Figure:
    """Draw a component of ICs, of a dataset of `compute_ics`, along its lines: a row per body.

    ICs are multiplied by Young's modulus of the lower body and its crown radius, lengths divided by that
    radius. C has a band, its estimated error. Raises WrongInput for an unknown component.
    """
    if component not in COMPONENTS:
        raise WrongInput(f"component = {component!r}: one of {', '.join(COMPONENTS)}")
    return _for_notebooks(curves_in(ics, component))


def plot_contact(contact: xr.Dataset) -> Figure:
    """Draw contacts with all ICs, of a dataset of `solve_contact`.

    Without friction: pressures [MPa] on the surface, with the edges of patches. Of steady rolling:
    creep-force curves; of transient rolling: forces over the rolled distance [mm]. Of compression: the share
    of the contact area that slides, over the load [N].
    """
    return _for_notebooks((main_figure if "friction" in contact.dims else surfaces)(contact))


def _for_notebooks(figure: Figure) -> Figure:
    """The figure, which notebooks show even where `matplotlib.pyplot` was never imported."""

    def png() -> bytes:
        picture = BytesIO()
        figure.savefig(picture, format="png")
        return picture.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]  # notebooks ask objects for this method
    return figure
