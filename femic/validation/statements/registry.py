"""All statements by number: 1 to 13, 16 to 21, 26 to 33 are from [BVSV], others are about this program.

Thresholds were set before the first run and have not been changed since; `changes` lists the changes of
claims and criteria. Errors are shares of the component itself (docs/theory/errors.md) on the lines of the
scenes. Where scenes are compared, curves are dimensionless.
"""

from collections.abc import Mapping
from itertools import chain
from operator import attrgetter

from femic.validation.statements import (
    bodies,
    choices,
    curvature,
    elements,
    fe_contacts,
    nn,
    normal_contacts,
    pressure_shapes,
    program,
    random_contacts,
    rigid_approaches,
    sn,
    tangential,
    xn,
)
from femic.validation.statements.criteria import Statement

GROUPS = (
    *(nn, tangential, bodies, xn, curvature, sn, choices, program, fe_contacts, elements, random_contacts),
    *(normal_contacts, pressure_shapes, rigid_approaches),
)

STATEMENTS: Mapping[int, Statement] = {
    statement.number: statement
    for statement in sorted(chain(*(group.STATEMENTS for group in GROUPS)), key=attrgetter("number"))
}
