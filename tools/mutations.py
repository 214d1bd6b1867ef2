"""Change the code in small ways and see whether the tests notice: `make mutations`.

    python tools/mutations.py [--sample N] [--workers N] [--modules femic/reference/result.py ...]

A seeded sample of N mutants of each module in tools/mutations.toml is tested in copies of the tree, each with
the tests that protect it (without slow ones, up to a time limit). Names of types, words, error texts and log
messages are not changed. Trials are stored in out/mutations.jsonl and are not repeated with the same
code and tests.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import Queue
from threading import Lock
from time import perf_counter
from typing import Any

from mutants import ROOT, Mutant, mutated, sample

from femic.cache.digests import folders_digest, versions

CODE = ("geometries", "approx", "femic", "compare", "tests")
COPIED = (*CODE, "examples", "docs", "tools", "pyproject.toml", "README.md")
TABLE = ROOT / "tools" / "mutations.toml"
TRIALS = ROOT / "out" / "mutations.jsonl"
LIMIT, LEAST = 4.0, 30.0  # times the seconds of the tests without a mutant; seconds
GOAL = 0.95


@dataclass(frozen=True)
class Trial:
    """A mutant and its outcome: caught, late (the tests did not end in time) or survived."""

    mutant: Mutant
    outcome: str
    seconds: float


def main() -> None:
    options = arguments()
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    tests = {module: table["modules"][module] for module in options.modules or table["modules"]}
    chosen = [mutant for module in tests for mutant in sample(module, options.sample)]
    trials = outcomes(chosen, tests, options.workers)
    summary, survived = record([trials[mutant] for mutant in chosen], table.get("harmless", []))
    sys.stdout.write(f"{summary}\n")
    for mutant in survived:
        place, change = f"{mutant['module']}:{mutant['number']}", f"{mutant['line']}  ->  {mutant['becomes']}"
        sys.stdout.write(f"{place}: {change}  {mutant['why']}\n")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=10, help="mutants of each module")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--modules", nargs="*", help="default: all of tools/mutations.toml")
    return parser.parse_args()


# --- trials ------------------------------------------------------------


def outcomes(chosen: Sequence[Mutant], tests: dict[str, list[str]], workers: int) -> dict[Mutant, Trial]:
    """Return all trials with this code and these tests, of this run and of earlier ones.

    Workers try mutants side by side, each in a copy of the tree.
    """
    key = folders_digest(CODE, versions())
    trials = stored_trials(key)
    todo = [mutant for mutant in chosen if mutant not in trials]
    by_tests: dict[tuple[str, ...], list[Mutant]] = {}
    for mutant in todo:
        by_tests.setdefault(tuple(tests[mutant.module]), []).append(mutant)

    def attempt(chosen_tests: tuple[str, ...]) -> None:
        with borrowed(trees) as tree:
            limit = max(LEAST, LIMIT * baseline(tree, chosen_tests))
            for mutant in by_tests[chosen_tests]:
                trial = trial_in(tree, mutant, chosen_tests, limit)
                with lock:
                    trials[mutant] = trial
                    store(key, trial)
                    done = sum(mutant in trials for mutant in todo)
                    place = f"{mutant.module}:{mutant.number}"
                    sys.stderr.write(f"{done}/{len(todo)} {trial.outcome} {place}\n")

    lock = Lock()
    with copies(workers) as trees, ThreadPoolExecutor(workers) as pool:
        list(pool.map(attempt, by_tests))  # raises what attempts raise
    return trials


@contextmanager
def copies(workers: int) -> Iterator[Queue[Path]]:
    """Yield a queue of copies of the tree, one for each worker."""
    free: Queue[Path] = Queue()
    with tempfile.TemporaryDirectory() as folder:
        for worker in range(workers):
            tree = Path(folder) / str(worker)
            tree.mkdir()
            for name in COPIED:
                if (ROOT / name).is_dir():
                    shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
                else:
                    shutil.copy(ROOT / name, tree)
            free.put(tree)
        yield free


@contextmanager
def borrowed(trees: Queue[Path]) -> Iterator[Path]:
    tree = trees.get()
    try:
        yield tree
    finally:
        trees.put(tree)


def baseline(tree: Path, tests: tuple[str, ...]) -> float:
    """Return seconds of some tests, which must pass as the code is."""
    start = perf_counter()
    if run_tests(tree, tests, None) != 0:
        raise SystemExit(f"{' '.join(tests)}: these fail without any mutant")
    return perf_counter() - start


def trial_in(tree: Path, mutant: Mutant, tests: tuple[str, ...], limit: float) -> Trial:
    """Return the trial of a mutant: whether the tests notice it."""
    path, start = tree / mutant.module, perf_counter()
    code = path.read_text(encoding="utf-8")
    try:
        path.write_text(mutated(code, mutant.operator, mutant.occurrence), encoding="utf-8")
        exit_code = run_tests(tree, tests, limit)
    finally:
        path.write_text(code, encoding="utf-8")
    outcome = "late" if exit_code is None else "caught" if exit_code else "survived"
    return Trial(mutant, outcome, round(perf_counter() - start, 1))


def run_tests(tree: Path, tests: tuple[str, ...], limit: float | None) -> int | None:
    """Return exit code of pytest, 0: all passed; None where it did not end in time."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *tests]
    process = subprocess.Popen(
        command,
        cwd=tree,
        env=os.environ | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(limit)
    except subprocess.TimeoutExpired:
        return None
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


# --- results ------------------------------------------------------------


def stored_trials(key: str) -> dict[Mutant, Trial]:
    """Return the trials of earlier runs with the same code and tests."""
    lines = TRIALS.read_text(encoding="utf-8").splitlines() if TRIALS.exists() else []
    entries = [entry for line in lines if (entry := json.loads(line))["key"] == key]
    result = [Trial(Mutant(**entry["mutant"]), entry["outcome"], entry["seconds"]) for entry in entries]
    return {trial.mutant: trial for trial in result}


def store(key: str, trial: Trial) -> None:
    TRIALS.parent.mkdir(exist_ok=True)
    with TRIALS.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps({"key": key} | asdict(trial), ensure_ascii=False) + "\n")


def record(trials: Sequence[Trial], harmless: Sequence[dict[str, str]]) -> tuple[str, list[dict[str, Any]]]:
    """Return how many mutants that can matter are caught, in words, and those that survived, with reasons."""
    reasons = {(entry["module"], entry["line"], entry["becomes"]): entry["why"] for entry in harmless}
    survived = [
        asdict(mutant) | {"why": reasons.get((mutant.module, mutant.line, mutant.becomes), "")}
        for mutant in (trial.mutant for trial in trials if trial.outcome == "survived")
    ]
    caught = len(trials) - len(survived)
    matter = caught + sum(not mutant["why"] for mutant in survived)
    share = caught / max(matter, 1)
    return f"{caught} of {matter} mutants that can matter are caught ({share:.1%}, goal {GOAL:.0%})", survived


if __name__ == "__main__":
    main()
