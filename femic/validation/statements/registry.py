"""All statements by number: 1 to 13 and 16 to 21 are those of [BVSV], all others about this program.

Thresholds were set before the first run and have not been changed since; `changes` lists what was changed
in claims and criteria. The report says where a number misses its threshold. Errors are shares of the
component itself (docs/theory/errors.md). Lines are those of the scenes. Where scenes are compared, curves are
dimensionless.
"""

from collections.abc import Mapping

from femic.validation.statements import (
    bodies,
    choices,
    curvature,
    elements,
    fe_contacts,
    nn,
    program,
    random_contacts,
    sn,
    tangential,
    xn,
)
from femic.validation.statements.criteria import Statement

GROUPS = (nn, tangential, bodies, xn, curvature, sn, choices, program, fe_contacts, elements, random_contacts)

STATEMENTS: Mapping[int, Statement] = {
    statement.number: statement
    for statement in sorted(
        (of_group for group in GROUPS for of_group in group.STATEMENTS), key=lambda of_group: of_group.number
    )
}
