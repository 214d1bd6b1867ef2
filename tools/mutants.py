"""Which small changes there are of a module: everything but words."""

import ast
import difflib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from mutation_operators import operators

ROOT = Path(__file__).parents[1]
SEED = 18
WORDS = ("log", "warnings")  # objects whose calls only say something
MESSAGES = ("_too_expensive", "_not_solved")  # functions that make texts


@dataclass(frozen=True)
class Mutant:
    """A changed line of a module."""

    module: str
    operator: str
    occurrence: int
    number: int  # of the line
    line: str
    becomes: str


def sample(module: str, most: int) -> list[Mutant]:
    """Return the same mutants of a module each time."""
    code = (ROOT / module).read_text(encoding="utf-8")
    changes = places(code)
    Random(f"{SEED} {module}").shuffle(changes)
    chosen: list[Mutant] = []
    for name, occurrence, number in changes:
        changed = changed_lines(code, mutated(code, name, occurrence))
        if changed and len(chosen) < most:
            chosen.append(Mutant(module, name, occurrence, number, *changed))
        if len(chosen) == most:
            break
    return chosen


def places(code: str) -> list[tuple[str, int, int]]:
    """Return operators, their occurrences and lines where what they change is no word."""
    left_out, nodes = spans_of_words(code), list(ast_nodes(get_ast(code)))
    changes = []
    for name, operator in operators().items():
        spans = (place for node in nodes for place in operator.mutation_positions(node))
        changes += [
            (name, occurrence, start[0])
            for occurrence, (start, _) in enumerate(spans)
            if not any(low <= start < high for low, high in left_out)
        ]
    return changes


def mutated(code: str, operator: str, occurrence: int) -> str:
    return str(mutate_code(code, operators()[operator], occurrence))


def changed_lines(before: str, after: str) -> tuple[str, str] | None:
    """Return the lines that differ, before and after; None if none does."""
    matching = difflib.SequenceMatcher(None, before.splitlines(), after.splitlines(), autojunk=False)
    apart = [code for code in matching.get_opcodes() if code[0] != "equal"]
    if not apart:
        return None
    (_, a, b, _, _), (_, _, _, c, d) = apart[0], apart[-1]
    old, new = before.splitlines()[a:b], after.splitlines()[c:d]
    return " ".join(line.strip() for line in old), " ".join(line.strip() for line in new)


def spans_of_words(code: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the spans of code without effect on results: types, docstrings, texts, errors, logs."""
    spans = []
    for node in ast.walk(ast.parse(code)):
        for part in _words(node):
            end = part.end_lineno, part.end_col_offset
            spans.append(((part.lineno, part.col_offset), end))
    return spans


def _words(node: ast.AST) -> Iterator[Any]:
    match node:
        case ast.AnnAssign(annotation=annotation) | ast.arg(annotation=ast.expr() as annotation):
            yield annotation
        case ast.FunctionDef(name=name) if name in MESSAGES:
            yield node
        case ast.FunctionDef(returns=ast.expr() as annotation):
            yield annotation
        case ast.Raise() | ast.JoinedStr() | ast.Import() | ast.ImportFrom() | ast.Assert():
            yield node
        case ast.Expr(value=ast.Constant()):
            yield node
        case ast.Call(func=ast.Attribute(value=ast.Name(id=name))) if name in WORDS:
            yield node
        case ast.Call(func=ast.Name(id="TypeVar" | "Literal")):
            yield node
    yield from getattr(node, "decorator_list", [])
