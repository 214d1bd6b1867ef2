"""What the supports of the bodies do to a contact: the same with a nearer far arc, and with flatter flanks.

Contact takes C with the supports of the bodies, of which only the rigid part of the approach is taken away.
How far the far arc is, and how the flanks incline that stand for the rest of a body, is a convention: so its
effect is stated beside the results.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from compare.contact.compute import ContactResults, SolvedContact, c_jobs, nn_operator
from compare.contact.pair_on_grid import Placed
from compare.contact.quantities import numbers
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene
from geometries.contours import Contour
from geometries.errors import Failure

FLATTER_DEG = 5.0  # by which flanks are flatter
SAMPLES = 4001  # arc lengths among which flatter flanks begin
NEARER, FLATTER = "far arc of half the radius", f"flanks {FLATTER_DEG:g} degrees flatter"


def changed_supports(results: ContactResults, options: RunOptions = DEFAULT) -> dict[str, dict[str, float]]:
    """The numbers of the largest contact by C with other supports, by what is other; empty without C.

    C with flatter flanks has to be solved: it is only where the contact is not symmetric, since supports
    hardly matter where it is.
    """
    largest = _largest_by_c(results)
    if largest is None or not results.scene.contact.supports:
        return {}
    return dict(_changed(results.scene, largest, options))


def _largest_by_c(results: ContactResults) -> SolvedContact | None:
    of_c = [contact for (_, ics), contact in results.contacts.items() if ics == "C"]
    return max(of_c, key=lambda contact: contact.normal.load, default=None)


def _changed(
    scene: Scene, contact: SolvedContact, options: RunOptions
) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield what is other about the supports, and the numbers with it."""
    placed = contact.placed
    for name, references, variation in other_supports(scene, placed, options):
        try:
            found = placed.settled(nn_operator(references, placed, variation), contact.case)
        except Failure as failure:
            options.watch.on_stage(f"  left out, {name}: {failure}")
            continue
        yield name, numbers(found.placed, found.normal)


def other_supports(
    scene: Scene, placed: Placed, options: RunOptions
) -> Iterator[tuple[str, Mapping[str, MatrixReference], str]]:
    """Yield what is other about the supports, C of both bodies, and which variation of C has these supports.

    Raises NotConverged as `femic.reference.matrix.reference.matrices`.
    """
    yield NEARER, matrices(c_jobs(scene, placed), options, combined=True), "nearer"
    flatter = None if placed.symmetric else flatter_scene(scene)
    if flatter is not None:
        options.watch.on_stage(f"  C with {FLATTER}")
        yield FLATTER, matrices(c_jobs(flatter, placed), options, combined=True), ""


def flatter_scene(scene: Scene) -> Scene | None:
    """The scene with flatter flanks on both bodies; None where flanks are tangents of given points."""
    contours = {name: body.contour for name, body in scene.bodies.items()}
    if any(np.all(np.isfinite(contour.extent)) for contour in contours.values()):
        return None
    bodies = {
        name: replace(body, contour=with_flatter_flanks(body.contour)) for name, body in scene.bodies.items()
    }
    return replace(scene, bodies=bodies)


def with_flatter_flanks(contour: Contour) -> Contour:
    """The contour with flanks that begin `FLATTER_DEG` earlier, where its core inclines by as much less."""
    s = np.linspace(*contour.limits, SAMPLES)
    delta = contour.inclination(s)
    steepest = np.abs(delta[[0, -1]]) - np.radians(FLATTER_DEG)
    kept = s[(delta >= -max(steepest[0], 0.0)) & (delta <= max(steepest[1], 0.0))]
    return replace(contour, limits=(float(kept[0]), float(kept[-1])))
