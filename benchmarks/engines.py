"""Benchmark of both engines side by side: print the table of docs/harmonic-engine.md as Markdown.

    python benchmarks/engines.py [tolerance of the harmonic engine ...]

Both geometries, all six components of both bodies with estimates: wall seconds of all models in two
processes, the largest model, the worst estimate, and how far the harmonic engine is from the solid one.
"""

import sys
from time import perf_counter

import numpy as np

from compare.pipeline import Results, compute, scales_of
from compare.scenes import load_scene
from femic.accuracy import component_of

BODIES = ("lower", "upper")


def run(name: str, engine: str, tolerance: float) -> tuple[Results, float]:
    scene = load_scene(name, {"engine": {"kind": engine, "tolerance": tolerance}})
    start = perf_counter()
    results = compute(scene, workers=2)
    return results, perf_counter() - start


def worst_share(results: Results, off: dict[str, np.ndarray]) -> float:
    """Largest share of a line's scale over both bodies, lines and components."""
    shares = []
    for body in BODIES:
        for line, part in results.lines.items():
            share = np.max(np.abs(off[body][..., part]), axis=-1) / scales_of(results, body)[line]
            shares += [component_of(share, c) for c in results.scene.components]
    return max(shares)


HEAD = (
    "scene",
    "engine",
    "tolerance",
    "seconds",
    "unknowns, finest model",
    "estimate",
    "from the solid engine",
)


def main() -> None:
    tolerances = [float(value) for value in sys.argv[1:]] or [0.01, 0.002]
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name in ("geometry1", "geometry2"):
        solid, took = run(name, "solid", 0.01)
        row([name, "solid", "0.01"], took, solid, "")
        for tolerance in tolerances:
            found, took = run(name, "harmonic", tolerance)
            off = {b: found.references[b].c.ic - solid.references[b].c.ic for b in BODIES}
            row([name, "harmonic", f"{tolerance:g}"], took, found, f"{worst_share(solid, off):.2%}")


def row(what: list[str], took: float, results: Results, apart: str) -> None:
    unknowns = max(results.references[body].models["fine"].unknowns for body in BODIES)
    estimate = worst_share(results, {body: results.references[body].c.estimate for body in BODIES})
    print(f"| {' | '.join([*what, f'{took:.0f}', f'{unknowns:,}', f'{estimate:.2%}', apart])} |", flush=True)


if __name__ == "__main__":
    main()
