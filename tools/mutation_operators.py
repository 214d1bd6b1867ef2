"""Small changes of code that tests must notice: cosmic-ray's operators, and two of our own.

Of cosmic-ray's those are taken whose mutants run: `x << 2.0` is an error wherever it is reached, and says
nothing about the tests.
"""

import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import parso
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator, operator_names

TAKEN = re.compile(
    "core/(NumberReplacer|AddNot|ReplaceTrueWithFalse|ReplaceFalseWithTrue|ReplaceAndWithOr|ReplaceOrWithAnd"
    "|ReplaceUnaryOperator_(USub_UAdd|Delete_USub|Delete_Not|Delete_Invert)"
    "|ReplaceBinaryOperator_(Add_Sub|Sub_Add|Mul_Div|Div_Mul|Mul_Add|Pow_Mul|FloorDiv_Div|BitAnd_BitOr|BitOr_BitAnd"
    "|Mod_Mul)"
    "|ReplaceComparisonOperator_(Lt_LtE|Lt_Gt|LtE_Lt|LtE_GtE|Gt_GtE|Gt_Lt|GtE_Gt|GtE_LtE|Eq_NotEq|NotEq_Eq"
    "|Is_IsNot|IsNot_Is))"
)
PAIRS = (
    ("max", "min"),
    ("maximum", "minimum"),
    ("fmax", "fmin"),
    ("argmax", "argmin"),
    ("any", "all"),
    ("sin", "cos"),
    ("sinh", "cosh"),
    ("floor", "ceil"),
    ("append", "insert"),
    ("sum", "max"),
    ("mean", "max"),
)
EXCHANGED = dict(PAIRS) | {second: first for first, second in PAIRS[:8]}
# calls that change nothing, or whose argument does not run in their place
ALIKE = re.compile("float|asarray|ascontiguousarray|array|list|tuple|dict|set|str|bool|len")


class ExchangeName(Operator):  # type: ignore[misc]
    """`np.max(x)` becomes `np.min(x)`."""

    def mutation_positions(self, node: Any) -> Iterator[tuple[Any, Any]]:
        """Yield start and end where it can be done."""
        if node.type == "name" and node.value in EXCHANGED and _is_called(node):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """Return the changed node."""
        del index
        node.value = EXCHANGED[node.value]
        return node

    @classmethod
    def examples(cls) -> tuple[()]:
        """Return no examples: tests have them."""
        return ()


class Unwrap(Operator):  # type: ignore[misc]
    """`pooled(x)` becomes `(x)`: what the function does is left out."""

    def mutation_positions(self, node: Any) -> Iterator[tuple[Any, Any]]:
        """Yield start and end of calls by name, or as `np.abs`, with one argument."""
        if _argument(node) is not None:
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """Return the argument in place of the call."""
        del index
        inside = parso.parse(f"({_argument(node).get_code()})").children[0]
        inside.get_first_leaf().prefix = node.get_first_leaf().prefix
        return inside

    @classmethod
    def examples(cls) -> tuple[()]:
        """Return no examples: tests have them."""
        return ()


def _is_called(name: Any) -> bool:
    after = name.get_next_leaf()
    return after is not None and after.value == "("


def _argument(node: Any) -> Any:
    """Return the only argument of a call, by name or of a module's function."""
    if node.type not in ("power", "atom_expr") or node.children[0].type != "name":
        return None
    call = node.children[-1]
    if call.type != "trailer" or call.children[0].value != "(" or len(call.children) != 3:
        return None
    dotted = node.children[1:-1]
    name = dotted[-1].children[-1].value if dotted else node.children[0].value
    if not name.islower() or ALIKE.fullmatch(name):
        return None
    if any(part.type != "trailer" or part.children[0].value != "." for part in dotted):
        return None
    inside = call.children[1]
    return None if inside.type in ("arglist", "argument") else inside


@cache
def operators() -> dict[str, Operator]:
    """Return all operators by name, in an order that does not change."""
    taken = {name: get_operator(name)() for name in sorted(operator_names()) if TAKEN.fullmatch(name)}
    return taken | {"femic/ExchangeName": ExchangeName(), "femic/Unwrap": Unwrap()}
