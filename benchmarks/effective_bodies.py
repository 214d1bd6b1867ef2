"""Do effective properties help other components, other materials? Those of each body, fitted to its own C.

B-hat-prime corrects xn of both bodies. Here G(r) and nu(r), or K(r), of each body are fitted to C of that
body, once for each set of components in SETS, and the errors of both bodies together are compared with those
of B-hat, at ratios of Young's moduli upper : lower of 0.1, 1 and 10. C of a body goes like 1 / E, so
nothing is solved again for them. For comparison: B-hat and a rigid translation, one compliance along each
axis, fitted to nn, xx and ss of the body at the same points. Takes a minute on 2 cores:

    .venv/bin/python benchmarks/effective_bodies.py [--out FOLDER] [--tolerance 0.01] [--record]
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run
from tables import Record, arguments, keep

from approx.calibration import fit
from approx.effective import EffectiveProperties
from approx.pair import Solid
from femic.cache.store import Store
from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.run_options import RunOptions
from femic.results.calibration import extended, fit_target
from femic.results.ics import Results, compute, reference_ics
from femic.scenes.load import load_scene
from geometries.arrays import Array
from geometries.materials import Material
from geometries.patches import indices

Fits = Mapping[str, EffectiveProperties]  # by body
SCENES, RATIOS, BODIES = ("geometry1", "geometry2"), (0.1, 1.0, 10.0), ("upper", "lower")
SETS = {  # what is fitted to which components
    ("xx", "ss"): ("G", "nu"),
    ("xx", "ss", "xs"): ("G", "nu"),
    ("nn", "xx", "ss", "xs"): ("G", "nu"),
    ("xn",): ("mismatch_k",),
}
COMPONENTS = ["nn", "xx", "ss", "xs", "sn", "xn"]
TRANSLATED = "B̂ + translation"
RECORD = Record(
    "effective_bodies.errors",
    "Effective properties of each body",
    "Largest errors of both bodies together, in % of the component, with effective properties of each "
    "body that are fitted to its own C.",
    "python benchmarks/effective_bodies.py",
)


def main(*, out: Path = Path("out/benchmarks"), tolerance: float = 0.01) -> xr.DataArray:
    """Compute C to estimated errors of `tolerance`, fit, print the errors; returns them."""
    out.mkdir(parents=True, exist_ok=True)
    tables = [errors(*fitted(name, tolerance, Store(out / "store"))) for name in SCENES]
    table = xr.concat(tables, xr.Variable("scene", list(SCENES)))
    for name in SCENES:
        print(f"Worst errors of both bodies, {name}:")
        print(table.sel(scene=name).stack(row=("ratio", "variant")).T.to_pandas().map("{:.1%}".format))
    rows = [
        [name, f"{ratio:g}", variant, *(f"{100 * value:.1f}" for value in table.sel(at).values)]
        for name in SCENES
        for ratio in RATIOS
        for variant in table.variant.values
        for at in [{"scene": name, "ratio": ratio, "variant": variant}]
    ]
    keep(RECORD, ["scene", "ratio of moduli", "ICs", *(f"{c} [%]" for c in COMPONENTS)], rows)
    return table


def fitted(name: str, tolerance: float, store: Store) -> tuple[Results, dict[tuple[str, ...], Fits]]:
    """Return C of a scene's bodies, and effective properties of each for every set of components."""
    calibration = {"bodies": list(BODIES), "properties": ["mismatch_k"], "components": COMPONENTS}
    engine = {"tolerance": tolerance, "check": False}
    scene = load_scene(name, {"calibration": calibration, "engine": engine})
    results = compute(extended(scene), RunOptions(store=store))
    fits = {}
    for components, properties in SETS.items():
        calibration = replace(results.scene.calibration, components=components)
        chosen = replace(results, scene=replace(results.scene, calibration=calibration))
        fits[components] = {body: fit(fit_target(chosen, body), properties).effective for body in BODIES}
    return results, fits


def solid_of(results: Results, body: str, ratio: float, effective: EffectiveProperties | None) -> Solid:
    """Return a body of a Young's modulus that is `ratio` times the scene's, properties scaled likewise."""
    original = results.scene.bodies[body]
    if effective and effective.G:
        effective = replace(effective, G=replace(effective.G, far=ratio * effective.G.far))
    return Solid(Material(ratio * original.material.E, original.material.nu), original.surface, effective)


def approximated(results: Results, variant: str, ratio: float, fits: Fits) -> Array:
    """Return ICs of both bodies per unit load [mm/N] at all points, upper body `ratio` times as stiff."""
    patch, points = results.scene.patch, (results.points.x, results.points.s)
    solids = [solid_of(results, b, ratio if b == "upper" else 1.0, fits.get(b)) for b in BODIES]
    return np.sum([solid.approximate(variant, patch, points) for solid in solids], axis=0) / patch.area


def translated(results: Results, body: str) -> Array:
    """Return the best translation [mm/N] to add to B-hat of a body: Q_I^T diag(t) Q_J, least squares."""
    surface, patch = results.scene.bodies[body].surface, results.scene.patch
    x, s = results.points.x, results.points.s
    observer, load = surface.axes(surface.chart_x(x, s, patch.s), s), surface.axes([0.0], [patch.s])
    parts = np.einsum("iap,ja->aijp", observer, load[..., 0])
    b_hat = solid_of(results, body, 1.0, None).approximate("Bhat", patch, (x, s)) / patch.area
    lack = reference_ics(results, body).ic - b_hat
    points = np.arange(len(x))
    used = np.concatenate([points[part] for name, part in results.lines.items() if name.startswith("fit ")])
    which = [indices(component) for component in ("nn", "xx", "ss")]
    columns = np.array([np.concatenate([part[i, j, used] for i, j in which]) for part in parts]).T
    right = np.concatenate([lack[i, j, used] for i, j in which])
    return np.einsum("a,aijp->ijp", np.linalg.lstsq(columns, right)[0], parts)


def errors(results: Results, fits: Mapping[tuple[str, ...], Fits]) -> xr.DataArray:
    """Return the worst errors on the scene's lines by ratio, variant and component."""
    lines = {name: part for name, part in results.lines.items() if not name.startswith("fit ")}
    variants = {"B̂": ("Bhat", {}), TRANSLATED: ("Bhat", {})} | {
        f"B̂′, {', '.join(SETS[components])} to {', '.join(components)}": ("Bhat_prime", effective)
        for components, effective in fits.items()
    }
    table = np.empty((len(RATIOS), len(variants), len(COMPONENTS)))
    upper, lower = (reference_ics(results, body) for body in BODIES)
    moved = [translated(results, body) for body in BODIES]
    far = far_from(results.scene.patch, results.points.x, results.points.s)
    for r, ratio in enumerate(RATIOS):
        c = upper.ic / ratio + lower.ic
        measure = Measure(c, upper.estimate / ratio + lower.estimate, c[2, 2], lines, far)
        for v, (name, (variant, effective)) in enumerate(variants.items()):
            ics = approximated(results, variant, ratio, effective)
            if name == TRANSLATED:
                ics = ics + moved[0] / ratio + moved[1]
            worst = np.max(list(measure.shares(ics - c).values()), axis=0)
            table[r, v] = [worst[indices(component)] for component in COMPONENTS]
    names = {"ratio": list(RATIOS), "variant": list(variants), "component": COMPONENTS}
    return xr.DataArray(table, names, ("ratio", "variant", "component"))


if __name__ == "__main__":
    arguments()
    run(main, result_action="return_value")
