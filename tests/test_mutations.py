"""What the mutation run changes and what it leaves alone."""

import mutations
from mutants import ROOT, Mutant, changed_lines, mutated, places, sample
from mutations import Trial, record

CODE = '''"""Words of 1 module."""

import numpy as np

LIMIT: tuple[int, "a | b"] = 3  # of all


@np.vectorize(otypes=[1])
def f(x: int | float = 2) -> int | None:
    """More 1 words."""
    if x > LIMIT:
        raise ValueError(f"{x + 1} is above" + "it" * 2)
    log.info("x", x + 1)
    return np.max(pooled(x) * 4)


def _too_expensive(x):
    return f"{x - 1}" + str(x - 1)
'''


def test_operators_change_what_code_does_and_neither_docstrings_nor_messages():
    becomes = {}
    for name, number, _ in places(CODE):
        before, after = changed_lines(CODE, mutated(CODE, name, number))
        becomes.setdefault(before, set()).add(after.replace("  ", " "))
    assert becomes.keys() == {
        'LIMIT: tuple[int, "a | b"] = 3  # of all',
        "def f(x: int | float = 2) -> int | None:",
        "if x > LIMIT:",
        "return np.max(pooled(x) * 4)",
    }
    assert becomes["if x > LIMIT:"] == {"if x >= LIMIT:", "if x < LIMIT:", "if not x > LIMIT:"}
    assert becomes["return np.max(pooled(x) * 4)"] == {
        *("return np.min(pooled(x) * 4)", "return (pooled(x) * 4)", "return np.max((x) * 4)"),
        *(f"return np.max(pooled(x) {rest})" for rest in ("/ 4", "+ 4", "* 5", "* 3")),
    }


def test_harmless_mutants_are_counted_separately():
    def tried(line, outcome):
        return Trial(Mutant("m.py", "op", 0, 1, line, "b"), outcome, 2.0)

    outcomes = [tried("1", "caught"), tried("2", "late"), tried("3", "survived"), tried("4", "survived")]
    harmless = [
        {"module": "m.py", "line": "3", "becomes": "b", "why": "the same"},
        {"module": "m.py", "line": "4", "becomes": "c", "why": "another mutant"},
    ]
    summary, survived = record(outcomes, harmless)
    assert summary.startswith("2 of 3 mutants")
    assert [mutant["why"] for mutant in survived] == ["the same", ""]


def test_sample_is_repeatable_and_changes_code():
    first, again = (sample("femic/reference/job.py", 8) for _ in range(2))
    assert first == again
    assert len({(m.operator, m.occurrence) for m in first}) == 8
    assert all(m.line != m.becomes for m in first)


def test_modules_and_tests_of_the_table_exist():
    table = mutations.tomllib.loads(mutations.TABLE.read_text(encoding="utf-8"))
    for module, tests in table["modules"].items():
        assert (ROOT / module).is_file()
        assert all((ROOT / test).is_file() for test in tests)
