"""All statements by number: 1 to 13, 16 to 21 and 26 to 41 are from [BVSV], all others are on this program.

Thresholds were set before the first run and have not been changed since; `changes` lists the changes of
claims and criteria. Errors are shares of the component itself (docs/theory/errors.md) on the lines of the
scenes. Where scenes are compared, curves are dimensionless.
"""

from collections.abc import Mapping
from itertools import chain
from operator import attrgetter

from compare.validation.statements import (
    bodies,
    choices,
    closed_forms,
    compressions,
    creep_forces,
    curvature,
    elements,
    exchanged_components,
    fast_operators,
    fe_angles,
    fe_contacts,
    nn,
    normal_contacts,
    pressure_shapes,
    program,
    random_contacts,
    rigid_approaches,
    rigid_motions,
    sn,
    softer_bodies,
    tangential,
    wheels,
    xn,
)
from compare.validation.statements.criteria import Statement

ON_ICS = (nn, tangential, bodies, xn, curvature, sn, choices)
ON_NORMAL_CONTACT = (normal_contacts, pressure_shapes, rigid_approaches)
ON_FRICTION = (creep_forces, compressions, exchanged_components, softer_bodies)
ON_PROGRAM = (
    *(program, fe_contacts, elements, random_contacts),
    *(fast_operators, fe_angles, closed_forms, rigid_motions),
    wheels,
)
GROUPS = (*ON_ICS, *ON_NORMAL_CONTACT, *ON_FRICTION, *ON_PROGRAM)

STATEMENTS: Mapping[int, Statement] = {
    statement.number: statement
    for statement in sorted(chain(*(group.STATEMENTS for group in GROUPS)), key=attrgetter("number"))
}
