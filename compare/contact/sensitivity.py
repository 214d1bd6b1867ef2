"""Maps and sentences of where A and B-hat differ under the pressures of the scenes' contacts."""

from collections.abc import Mapping, Sequence

import numpy as np

from compare.contact.compute import ContactResults
from compare.report.charts import Map
from compare.report.parts import join_words
from compare.report.tables import Cell, Row, Table, number_text, numbers
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


def differences(results: Mapping[str, ContactResults]) -> list[Sensitivity]:
    """Return the differences under the pressures of every scene (row) on the patch of every scene."""
    return list(sensitivities({name: shape_of(contacts) for name, contacts in results.items()}))


def summary(cases: Sequence[Sensitivity]) -> str:
    """Return how far A is off at worst, and which pressures that is under on each patch."""
    worst = max(cases, key=lambda case: case.largest)
    by_patch = {
        patch: max((case for case in cases if case.patch == patch), key=lambda case: case.largest)
        for patch in _patches(cases)
    }
    under = join_words(
        f"on the patch of {patch} under the pressures of {case.pressures}" for patch, case in by_patch.items()
    )
    return (
        f"Displacements with A are off by up to {worst.largest:.1%} of the largest with B̂, "
        f"under the pressures of {worst.pressures} on the patch of {worst.patch}. A is furthest off {under}."
    )


def _patches(cases: Sequence[Sensitivity]) -> list[str]:
    return list(dict.fromkeys(case.patch for case in cases))


def table(cases: Sequence[Sensitivity]) -> Table:
    """Return the range of differences, a row per pressures, a column per patch."""
    patches = _patches(cases)
    ranges = [
        Cell(" ... ".join(number_text(100 * end(case.inside), "+.1f") for end in (np.min, np.max)))
        for case in cases
    ]
    n = len(patches)
    return Table(
        "A over B̂, pressures of",
        numbers(*(f"on the patch of {patch}" for patch in patches), unit="%"),
        [Row(name, ranges[k * n : (k + 1) * n]) for k, name in enumerate(patches)],
    )


def maps(cases: Sequence[Sensitivity]) -> tuple[list[Map], int]:
    """Return the maps, a row per pressures, a column per patch, and the number of columns."""
    largest = 100 * max(case.largest for case in cases)
    return [_map(case, largest) for case in cases], len(_patches(cases))


def _map(case: Sensitivity, largest: float) -> Map:
    x, s = (np.flatnonzero(case.on_patch.any(axis=axis)) for axis in (1, 0))
    shown = np.where(case.on_patch, 100 * case.difference, np.nan)
    return Map(
        f"pressures of {case.pressures} on {case.patch}",
        "x [mm]",
        "s [mm]",
        case.x[x[0] : x[-1] + 1],
        case.s[s[0] : s[-1] + 1],
        shown[x[0] : x[-1] + 1, s[0] : s[-1] + 1],
        "A − B̂, over the largest [%]",
        "diverging",
        (-largest, largest),
    )
