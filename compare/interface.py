"""What `femic` hands out of `compare`: figures of labelled results, and scenes with their page.

Notebooks show figures to be explored, and `savefig` writes them.
"""

from io import BytesIO
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from compare.pages import ics_results as run
from compare.pages.contact_figures import surfaces
from compare.pages.friction_pages import main_chart
from compare.pages.ics import component_chart
from compare.pages.profiles import all_panels
from compare.pages.shift_figures import pressures
from compare.report import static
from compare.report.charts import Chart
from compare.report.static import in_a_frame
from femic.interface.arguments import with_checked_arguments
from femic.interface.labels import contacts_by_label, ics_by_label
from femic.interface.options import DEFAULT, Options, in_turn
from femic.interface.profiles import Profile
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS

# --- figures --------------------------------------------------------------------------------------------


@with_checked_arguments
def plot_ics(ics: xr.Dataset, component: str = "nn") -> Figure:
    """Draw a component of ICs, of a dataset of `compute_ics`, along its lines: a row per body.

    ICs are multiplied by Young's modulus of the lower body and its crown radius, lengths divided by that
    radius. C has a band, its estimated error. Raises WrongInput for an unknown component.
    """
    if component not in COMPONENTS:
        raise WrongInput(f"component = {component!r}: one of {', '.join(COMPONENTS)}")
    return _for_notebooks(component_chart(ics_by_label("ics", ics, component), component))


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
    return _for_notebooks(all_panels(profile.data))


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


# --- scenes ---------------------------------------------------------------------------------------------


@with_checked_arguments
@in_turn
def run_scene(scene: Scene, out: str | Path, options: Options = DEFAULT) -> Path:
    """Compute the ICs of a scene as `femic run` does, and write them with a report; return its path.

    `scene` comes from `load_scene`, with its own accuracy and engine: of `options` only workers, store and
    report count. Raises WrongInput, and Failure where the tolerance cannot be met.
    """
    return run.run_scene(scene, Path(out), options.run)
