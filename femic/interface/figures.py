"""Figures of labelled results, which notebooks show to be explored, and `savefig` writes."""

from io import BytesIO

import xarray as xr
from matplotlib.figure import Figure

from compare.contact.figures import surfaces
from compare.friction.pages import main_chart
from compare.ics.curves import chart_in
from compare.profiles.figures import all_panels
from compare.report import static
from compare.report.charts import Chart
from compare.report.notebooks import in_a_frame
from compare.shifts.figures import pressures
from femic.interface.arguments import with_checked_arguments
from femic.interface.labels import contacts_by_label, ics_by_label
from femic.interface.profiles import Profile
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS


@with_checked_arguments
def plot_ics(ics: xr.Dataset, component: str = "nn") -> Figure:
    """Draw a component of ICs, of a dataset of `compute_ics`, along its lines: a row per body.

    ICs are multiplied by Young's modulus of the lower body and its crown radius, lengths divided by that
    radius. C has a band, its estimated error. Raises WrongInput for an unknown component.
    """
    if component not in COMPONENTS:
        raise WrongInput(f"component = {component!r}: one of {', '.join(COMPONENTS)}")
    return _for_notebooks(chart_in(ics_by_label("ics", ics, component), component))


@with_checked_arguments
def plot_contact(contact: xr.Dataset) -> Figure:
    """Draw contacts with all ICs, of a dataset of `solve_contact` or `compute_shifts`.

    Without friction: pressures [MPa] on the surface, with the edges of patches. Of steady rolling:
    creep-force curves; of transient rolling: forces over the rolled distance [mm]. Of compression: the share
    of the contact area that slides, over the load [N]. Of a wheelset at several shifts: largest pressures
    [MPa] over the shift [mm]. Raises WrongInput for other datasets.
    """
    contact = contacts_by_label("contact", contact)
    if "shift" in contact.dims:
        return _for_notebooks(pressures(contact))
    return _for_notebooks((main_chart if "friction" in contact.dims else surfaces)(contact))


@with_checked_arguments
def plot_profile(profile: Profile) -> Figure:
    """Draw how a profile was understood: section [mm], residual [µm], inclination [degrees], curvature."""
    return _for_notebooks(all_panels(profile.understood))


def _for_notebooks(chart: Chart) -> Figure:
    """Return the figure of a chart; notebooks show the chart to be explored, or else a picture."""
    figure = static.picture(chart)

    def png() -> bytes:
        picture = BytesIO()
        figure.savefig(picture, format="png")
        return picture.getvalue()

    figure._repr_png_ = png  # type: ignore[attr-defined]  # notebooks ask objects for these methods
    figure._repr_html_ = lambda: in_a_frame(chart)  # type: ignore[method-assign]
    return figure
