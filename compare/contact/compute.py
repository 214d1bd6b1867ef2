"""Frictionless contact of a scene with several ICs, solved by `femic.contact`; which scenes are refused."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from approx.variants import needs_effective
from femic.contact.pairs import given_ics
from femic.contact.pairs.feasibility import impossible, without_operator
from femic.contact.pairs.frictionless import FrictionlessContacts, solve_frictionless
from femic.contact.pairs.given_ics import NONE_GIVEN, C, NormalICs
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.grid import grid_misfits
from femic.scenes.ic_names import is_map
from femic.scenes.lines import single_load_misfits
from femic.scenes.scene import Scene


@dataclass(frozen=True, eq=False)
class ContactResults:
    """The frictionless contacts of a scene."""

    scene: Scene
    solved: FrictionlessContacts


def require_solvable(scene: Scene, given: Collection[str] = ()) -> None:
    """Raise BadScene where the contact of a scene cannot be solved, before any work; `given` name ICs."""
    specification = scene.contact
    if not specification.loadings:
        raise BadScene(f"{scene.name}: [contact]: give loads = [...] in N, or approaches = [...] in mm")
    approximations = [
        name for name in specification.ics if name != C and name not in given and not is_map(name)
    ]
    if needs_effective(*approximations) and not scene.pair.has_effective("combined"):
        raise BadScene(
            f"{scene.name}: contact.ics: Bhat_prime needs effective properties of both bodies: "
            "`femic calibrate` fits them"
        )
    if (maps := map_names(specification.ics)) and specification.friction:
        raise BadScene(
            f"{scene.name}: contact.ics: {maps[0]}: maps of C have nn only, for contact without friction; "
            "use C"
        )
    c_misfits = () if C in given else _c_misfits(scene)
    problem = scene.contact_problem
    require_none(scene.name, [*c_misfits, *without_operator(problem, approximations), *impossible(problem)])


def _c_misfits(scene: Scene) -> Iterator[str]:
    """Yield misfits of the engine of C, and of the grid if the scene gives one."""
    if C in scene.contact.ics:
        yield from single_load_misfits(scene)
        yield from matrix_engine_misfits(scene)
        if not scene.contact.automatic:
            yield from grid_misfits(scene)


def map_names(ics: Sequence[str]) -> list[str]:
    """Return the names of maps of C among names of ICs."""
    return [name for name in ics if is_map(name)]


def reference_name(ics: Sequence[str]) -> str:
    """Return the ICs that others are compared with: C, or else a map of it, B-hat, or the last."""
    return given_ics.reference_name(ics, map_names(ics))


def compute_contact(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> ContactResults:
    """Solve all frictionless contacts of a scene; `given` are ICs by name, such as its maps of C.

    Raises BadScene for what cannot be solved, and Failure as `femic.contact`.
    """
    require_solvable(scene, given)
    return ContactResults(scene, solve_frictionless(scene.contact_problem, options, given))
