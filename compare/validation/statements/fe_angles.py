"""Statement 43: contact with C and contact of two meshed bodies at angles from 39 to 109 degrees.

The contacts of statements 22 and 33, which are solved for these. `wide` under 18 000 kN, where the linearised
distance decides (statement 30), is not among them.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from compare.pages.finite_elements import deviations
from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements import fe_contacts
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.fe_contacts import (
    AGREES,
    AT_ALL_ANGLES,
    CENTRED,
    deviations_beyond_estimate,
)
from compare.validation.statements.runs import Runs
from femic.results.contact import case_names
from femic.results.finite_elements import APPROACH, FE, OF_PATCH

ALL_CONTACTS = (AT_ALL_ANGLES, CENTRED)


def beyond_estimate_everywhere(names: Sequence[str]) -> Numbers:
    """Measure deviations of numbers with C from finite elements beyond their estimate, of all contacts."""

    def measure(runs: Runs) -> Mapping[str, float]:
        return {
            f"{contacts.scene}, {case}": value
            for contacts in ALL_CONTACTS
            for case, value in deviations_beyond_estimate(contacts, names)(runs).items()
        }

    return Numbers(measure)


def _details(runs: Runs) -> Mapping[str, float]:
    """Return deviations of all ICs, the angle by finite elements, and how much an edge off by 1 % turns.

    On a sharply curved part of a contour a small error of the edge is a large one of the angle: the last
    number is the relative change of the angle over that of the half-length b.
    """
    details: dict[str, float] = {}
    for contacts in ALL_CONTACTS:
        of_these = fe_contacts.details(contacts, runs)
        details |= {f"{contacts.scene}, {case}": value for case, value in of_these.items()}
        dataset = runs.fe_contact(contacts)
        for k, case in enumerate(case_names(dataset)):
            angle, b = (dataset[name].isel(case=k) for name in ("angle", "b"))
            details[f"{contacts.scene}, {case}: Δδ by FE [rad]"] = float(angle.sel(ics=FE))
            turned, moved = (float(one.sel(ics="C") / one.sel(ics=FE)) - 1 for one in (angle, b))
            details[f"{contacts.scene}, {case}: relative deviation of Δδ over that of b, C"] = turned / moved
    return details


def _panels(runs: Runs) -> list[Panel]:
    """Return deviations of p_max over the angle, and pressures across the patches."""
    pressures = [panel for contacts in ALL_CONTACTS for panel in fe_contacts.panels(contacts, runs)]
    return [*(_over_angle(runs, scene) for scene in ("tall", "wide")), *pressures]


def _over_angle(runs: Runs, scene: str) -> Panel:
    """Return deviations of p_max of a pair from finite elements over the angle by these."""
    points = []
    for contacts in ALL_CONTACTS:
        if contacts.scene == scene:
            dataset = runs.fe_contact(contacts)
            angle = dataset["angle"].sel(ics=FE)
            points.append(deviations(dataset, "p_max").assign_coords(angle=("case", angle.values)))
    by_ics = {
        symbol_of(ics): np.concatenate([one.sel(ics=ics).values for one in points])
        for ics in map(str, points[0].ics.values)
    }
    angles = [float(value) for one in points for value in one.angle.values]
    return Panel(
        scene,
        "Δδ by finite elements [rad]",
        "p_max over that by finite elements, less 1 [-]",
        curves_of(angles, by_ics),
    )


STATEMENTS = (
    Statement(
        43,
        "Contact with C agrees with contact of two meshed bodies at all angles, on both pairs.",
        (
            beyond_estimate_everywhere(OF_PATCH).below(
                AGREES,
                "patch",
                "a, b, Δδ, p_max with C: deviation from finite elements minus their estimate",
            ),
            beyond_estimate_everywhere((APPROACH,)).below(
                AGREES, "approach", "approach with C, likewise; without M_zz of both bodies"
            ),
        ),
        _panels,
        _details,
    ),
)
