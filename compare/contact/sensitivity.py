"""Maps and sentences of where A and B-hat differ under the pressures of the scenes' contacts."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from compare.contact.compute import ContactResults
from compare.report.styles import RC
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.sensitivity import REFERENCE, Sensitivity, sensitivities
from femic.scenes.scene import Scene


def is_mapped(scene: Scene) -> bool:
    """Return whether the contact of a scene is frictionless and solved with B-hat."""
    return scene.contact.friction is None and REFERENCE in scene.contact.ics


def shape_of(results: ContactResults) -> SolvedContact:
    """Return the contact with B-hat to be mapped: at `contact.shape_load`, or at the largest load."""
    contacts = [contact for (_, ics), contact in results.solved.contacts.items() if ics == REFERENCE]
    shape_load = results.scene.contact.shape_load
    if shape_load is None:
        return max(contacts, key=lambda contact: contact.normal.load)
    return min(contacts, key=lambda contact: abs(contact.normal.load - shape_load))


def _sensitivities(results: Mapping[str, ContactResults]) -> list[Sensitivity]:
    return list(sensitivities({name: shape_of(contacts) for name, contacts in results.items()}))


def summary(results: Mapping[str, ContactResults]) -> str:
    """Return sentences on the range of differences on each patch, and on the pressures with the largest."""
    differences = _sensitivities(results)
    sentences = [
        f"Pressures of {case.pressures} on {case.patch}: A is off by {np.min(case.inside):+.1%} ... "
        f"{np.max(case.inside):+.1%} of the largest displacement with B̂."
        for case in differences
    ]
    for scene in results:
        worst = max((case for case in differences if case.patch == scene), key=lambda case: case.largest)
        sentences.append(
            f"On the patch of {scene} A is furthest off under the pressures of {worst.pressures}."
        )
    return " ".join(sentences)


def maps(results: Mapping[str, ContactResults]) -> Figure:
    """Draw the maps, a row per pressures, a column per patch."""
    drawn = _sensitivities(results)
    n = round(np.sqrt(len(drawn)))
    largest = max(case.largest for case in drawn)
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(4.6 * n, 3.4 * n), layout="constrained")
        for axes, case in zip(figure.subplots(n, n, squeeze=False).ravel(), drawn, strict=True):
            shown = np.ma.masked_where(~case.on_patch, case.difference)
            shades = axes.pcolormesh(
                case.x, case.s, shown.T, cmap="RdBu_r", vmin=-largest, vmax=largest, rasterized=True
            )
            axes.set(xlabel="x [mm]", ylabel="s [mm]", title=f"pressures of {case.pressures} on {case.patch}")
            for limit, place, inside in (
                (axes.set_xlim, case.x, case.on_patch.any(axis=1)),
                (axes.set_ylim, case.s, case.on_patch.any(axis=0)),
            ):
                limit(place[inside].min(), place[inside].max())
        figure.colorbar(shades, ax=figure.axes, label="(u_n with A − u_n with B̂) / max u_n with B̂ [-]")
        return figure
