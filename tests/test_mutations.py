"""What the mutation run changes and what it leaves alone."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "tools"))
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


def changes():
    return {(changed_lines(CODE, mutated(CODE, name, n))) for name, n, _ in places(CODE)}


def test_what_the_code_does_is_changed():
    found = changes()
    expected = {
        "if x > LIMIT:": {"if x >= LIMIT:", "if x < LIMIT:", "if not x > LIMIT:"},
        "return np.max(pooled(x) * 4)": {
            "return np.min(pooled(x) * 4)",
            "return (pooled(x) * 4)",
            "return np.max((x) * 4)",
            "return np.max(pooled(x) / 4)",
            "return np.max(pooled(x) + 4)",
            "return np.max(pooled(x) * 5)",
            "return np.max(pooled(x) * 3)",
        },
    }
    for line, becomes in expected.items():
        assert {after.replace("  ", " ") for before, after in found if before == line} == becomes


def test_words_types_and_texts_are_not():
    lines = {before for before, _ in changes()}
    assert lines == {
        'LIMIT: tuple[int, "a | b"] = 3  # of all',
        "def f(x: int | float = 2) -> int | None:",
        "if x > LIMIT:",
        "return np.max(pooled(x) * 4)",
    }


def test_mutants_that_cannot_matter_are_counted_apart():
    def tried(line, outcome):
        return Trial(Mutant("m.py", "op", 0, 1, line, "b"), outcome, 2.0)

    outcomes = [tried("1", "caught"), tried("2", "late"), tried("3", "survived"), tried("4", "survived")]
    harmless = [
        {"module": "m.py", "line": "3", "becomes": "b", "why": "the same"},
        {"module": "m.py", "line": "4", "becomes": "c", "why": "another mutant"},
    ]
    found = record(outcomes, harmless)
    (row,) = found["rows"]
    assert (row["mutants"], row["caught"], row["harmless"], row["survived"]) == (4, 2, 1, 1)
    assert found["summary"].startswith("2 of 3 mutants")
    assert [one["why"] for one in found["survived"]] == ["the same", ""]


def test_a_sample_is_the_same_each_time_and_all_of_it_differs_from_the_code():
    one, again = (sample("femic/reference/accuracy.py", 8) for _ in range(2))
    assert one == again
    assert len({(m.operator, m.occurrence) for m in one}) == 8
    assert all(m.line != m.becomes for m in one)


def test_every_module_and_test_of_the_table_exists():
    table = mutations.tomllib.loads(mutations.TABLE.read_text(encoding="utf-8"))
    for module, tests in table["modules"].items():
        assert (ROOT / module).is_file()
        assert all((ROOT / test).is_file() for test in tests)
