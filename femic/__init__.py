"""femic: influence coefficients of non-planar elastic solids, their approximations, and contact.

The names below are the public interface; docs/how-to/python.md shows examples. Everything else is private and
may change without notice. Units are mm, N, MPa and rad; names ending in `_deg` are angles in degrees. Each
name is loaded when you first use it, so `import femic` is fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compare.interface import plot_contact as plot_contact
    from compare.interface import plot_ics as plot_ics
    from compare.interface import plot_profile as plot_profile
    from compare.interface import run_scene as run_scene
    from femic.interface.bodies import Body as Body
    from femic.interface.bodies import Pair as Pair
    from femic.interface.bodies import arc as arc
    from femic.interface.bodies import ellipse as ellipse
    from femic.interface.bodies import load_pair as load_pair
    from femic.interface.bodies import plane as plane
    from femic.interface.bodies import through_points as through_points
    from femic.interface.contact import Compression as Compression
    from femic.interface.contact import ContactSetup as ContactSetup
    from femic.interface.contact import Frictionless as Frictionless
    from femic.interface.contact import Rolling as Rolling
    from femic.interface.contact import TransientRolling as TransientRolling
    from femic.interface.contact import solve_contact as solve_contact
    from femic.interface.ics import FittedPair as FittedPair
    from femic.interface.ics import compare_ics as compare_ics
    from femic.interface.ics import compute_ics as compute_ics
    from femic.interface.ics import fit_bhat_prime as fit_bhat_prime
    from femic.interface.ics import line_along_s as line_along_s
    from femic.interface.ics import line_along_x as line_along_x
    from femic.interface.ics import points as points
    from femic.interface.matrices import compute_matrix as compute_matrix
    from femic.interface.matrices import label_matrix as label_matrix
    from femic.interface.matrices import write_for_contact as write_for_contact
    from femic.interface.options import Options as Options
    from femic.interface.profiles import Profile as Profile
    from femic.interface.profiles import compute_shifts as compute_shifts
    from femic.interface.profiles import write_profile as write_profile
    from femic.interface.solver import ContactSolver as ContactSolver
    from femic.interface.solver import SolvedContact as SolvedContact
    from femic.interface.tables import compute_table as compute_table
    from femic.interface.tables import read_table as read_table
    from femic.interface.tables import write_table as write_table
    from femic.scenes.load import load_scene as load_scene
    from geometries.errors import Failure as Failure
    from geometries.errors import WrongInput as WrongInput
    from geometries.materials import Material as Material
    from geometries.patches import Grid as Grid
    from geometries.patches import Patch as Patch

_MODULES = {
    "femic.interface.bodies": ("Body", "Pair", "arc", "ellipse", "load_pair", "plane", "through_points"),
    "femic.interface.contact": (
        "Compression",
        "ContactSetup",
        "Frictionless",
        "Rolling",
        "TransientRolling",
        "solve_contact",
    ),
    "compare.interface": ("plot_contact", "plot_ics", "plot_profile", "run_scene"),
    "femic.interface.ics": (
        "FittedPair",
        "compare_ics",
        "compute_ics",
        "fit_bhat_prime",
        "line_along_s",
        "line_along_x",
        "points",
    ),
    "femic.interface.matrices": ("compute_matrix", "label_matrix", "write_for_contact"),
    "femic.interface.options": ("Options",),
    "femic.interface.profiles": ("Profile", "compute_shifts", "write_profile"),
    "femic.interface.solver": ("ContactSolver", "SolvedContact"),
    "femic.interface.tables": ("compute_table", "read_table", "write_table"),
    "femic.scenes.load": ("load_scene",),
    "geometries.errors": ("Failure", "WrongInput"),
    "geometries.materials": ("Material",),
    "geometries.patches": ("Grid", "Patch"),
}
_PLACES = {name: module for module, names in _MODULES.items() for name in names}

__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    """Return a public name, which is imported now."""
    if name not in _PLACES:
        raise AttributeError(f"module 'femic' has no public name {name!r}: {', '.join(sorted(_PLACES))}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(_PLACES)
