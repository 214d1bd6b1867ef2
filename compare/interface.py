"""What `femic` hands out of `compare`: figures of labelled results, and scenes with their page.

In notebooks the figures are interactive; `savefig` writes them to files.
"""

from io import BytesIO
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from compare.pages import ics_results as run
from compare.pages.contact_figures import surfaces
from compare.pages.friction_pages import main_chart
from compare.pages.ics_figures import component_chart
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
    """Draw one component of the ICs in a dataset of `compute_ics` along its lines, one row per body.

    ICs are multiplied by Young's modulus and the crown radius of the lower body; lengths are divided by that
    radius. The band about C is its estimated error. Raises WrongInput for an unknown component.
    """
    if component not in COMPONENTS:
        raise WrongInput(f"component = {component!r}: one of {', '.join(COMPONENTS)}")
    return _for_notebooks(component_chart(ics_by_label("ics", ics, component), component))


@with_checked_arguments
def plot_contact(contact: xr.Dataset) -> Figure:
    """Draw the contacts in a dataset of `solve_contact` or `compute_shifts`, with all ICs.

    Without friction: pressures [MPa] on the surface, with the patch edges. Steady rolling: creep-force
    curves. Transient rolling: forces against the rolled distance [mm]. Compression: sliding part of the
    contact area against load [N]. Wheelset: largest pressure [MPa] against shift [mm]. Raises WrongInput for
    other datasets.
    """
    contact = contacts_by_label("contact", contact)
    if "shift" in contact.dims:
        return _for_notebooks(pressures(contact))
    return _for_notebooks((main_chart if "friction" in contact.dims else surfaces)(contact))


@with_checked_arguments
def plot_profile(profile: Profile) -> Figure:
    """Draw a profile as femic reads it: section [mm], residual [µm], inclination [degrees], curvature."""
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

    `scene` comes from `load_scene` and defines accuracy and engine; only workers, store and report of
    `options` have an effect. Raises WrongInput; raises Failure if C does not reach the tolerance.
    """
    return run.run_scene(scene, Path(out), options.run)
