"""C by both engines at their extremes: on planes against A, elsewhere against a tighter C."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from compare.results.compute import Results, compute, ics_of, reference_of, refinement_shares_of
from compare.scenes.errors import BadScene
from compare.scenes.load import load_scene
from compare.studies.extremes.drawing import drawing
from compare.studies.extremes.found import HARMONIC, SOLID, Beyond, Parameter, Reached
from femic.accuracy import component_of
from femic.means import Means

SIX = ("nn", "ss", "xx", "xs", "xn", "sn")
TOLERANCE = {HARMONIC: 0.01, SOLID: 0.1}
TIGHTER = 0.001  # tolerance of the C against which errors are measured where no closed form exists
FINER = {"growth": 0.2, "far_radius": 3000.0}  # its cells and domain: less than half, more than twice
EXAMPLES = 40  # plane scenes drawn
ROUNDING = 1e-9  # share of the scale of refinement
POINTS = 102  # of a line: none on the outline of the patch, which is a row of its own
Changes = Mapping[str, Any]


@dataclass(frozen=True)
class Engines:
    """How cases are computed."""

    means: Means

    def parameters(self, engine: str) -> list[Parameter]:
        """All rows of the column of an engine."""
        return self._harmonic() if engine == HARMONIC else self._solid()

    def _harmonic(self) -> list[Parameter]:
        at = [
            ("ν", "0 … 0.4999", [flat(nu=0.0), flat(nu=0.4999)], [flat(nu=0.49995)]),
            ("patch aspect a/b", "0.01 … 100", [flat(aspect=0.01), flat(aspect=100.0)], [flat(aspect=0.005)]),
            ("distance / half-side", "0 … 1000", [flat(distance=1000.0)], [flat(distance=3300.0)]),
            ("flank inclination", "0 … 85°", [curved(flank=0.0), curved(flank=85.0)], [curved(flank=86.0)]),
            ("R_roll [mm]", "20 … ∞", [wheel(20.0), wheel(1e6)], [wheel(19.0)]),
            ("R_w / R_r − 1", "≥ 0", [ratio(1.0), ratio(10.0)], []),
            ("modulus ratio", "1e-6 … 1e6", [moduli(1e-6), moduli(1e6)], []),
            ("observer", "anywhere", [on_outline()], []),
        ]
        rows = [self._row(HARMONIC, *row) for row in at]
        drawn = Parameter(
            HARMONIC, "all of a plane at once", "ν, a/b 0.1 … 10, 0.1 … 1 mm", [self._drawn_planes]
        )
        return [*rows, drawn]

    def _solid(self) -> list[Parameter]:
        at = [
            ("ν", "0 … 0.49", [flat(nu=0.0), flat(nu=0.49)], [flat(nu=0.495)]),
            ("patch aspect a/b", "0.1 … 10", [flat(aspect=0.1), flat(aspect=10.0)], [flat(aspect=0.05)]),
            ("distance / half-side", "0 … 200", [flat(distance=200.0)], [flat(distance=820.0)]),
            ("flank inclination", "0 … 75°", [curved(flank=0.0), curved(flank=75.0)], [curved(flank=76.0)]),
            ("R_roll [mm]", "50 … ∞", [wheel(50.0), wheel(1e6)], [wheel(49.0)]),
            ("R_w / R_r − 1", "≥ 0", [ratio(10.0)], []),
            ("modulus ratio", "1e-6 … 1e6", [moduli(1e-6), moduli(1e6)], []),
            ("observer", "anywhere", [on_outline()], []),
        ]
        return [self._row(SOLID, *row) for row in at]

    def _row(
        self, engine: str, name: str, allowed: str, within: Sequence["Asked"], beyond: Sequence["Asked"]
    ) -> Parameter:
        return Parameter(
            engine,
            name,
            allowed,
            [self._reach(engine, asked) for asked in within],
            [_refuse(engine, asked) for asked in beyond],
        )

    def _reach(self, engine: str, asked: "Asked") -> Callable[[], Reached]:
        def case() -> Reached:
            results = self._solved(asked, engine, {"tolerance": TOLERANCE[engine]})
            seconds = sum(sum(cost.seconds.values()) for cost in results.models.values())
            if asked.base == "flat":
                return Reached(asked.label, *compared(results, None), "A", seconds)
            finer = self._solved(asked, HARMONIC, FINER | {"tolerance": TIGHTER})
            return Reached(asked.label, *compared(results, finer), "a finer C", seconds)

        return case

    def _solved(self, asked: "Asked", engine: str, settings_of: Changes) -> Results:
        table = {"kind": engine, "check": False, **settings_of}
        scene = load_scene(asked.base, {**asked.changes, "engine": table})
        return compute(scene, self.means)

    def _drawn_planes(self) -> Reached:
        """Plane scenes that hypothesis draws: the one in which errors use up most of their estimates."""
        found: list[Reached] = []
        shares: list[float] = []

        @drawing(EXAMPLES)
        @given(
            st.floats(0, 0.49),
            st.floats(-1, 1),
            st.floats(-1, 0),
            st.floats(0.5, 8),
            st.sampled_from([0.1, 0.01, 0.001]),
        )
        def draw(nu: float, aspect: float, size: float, beside: float, tolerance: float) -> None:
            asked = flat(nu=nu, aspect=10**aspect, size=10**size, beside=beside)
            results = self._solved(asked, HARMONIC, {"tolerance": tolerance})
            seconds = sum(sum(cost.seconds.values()) for cost in results.models.values())
            found.append(Reached(asked.label, *compared(results, None), "A", seconds))
            shares.extend(used for _, _, used in each(results, None))

        draw()
        held = sum(used <= 1 for used in shares)
        note = (
            f"{len(found)} scenes: {held} of {len(shares)} errors (of components on lines) within estimates"
        )
        return replace(max(found, key=lambda one: one.used or 0.0), note=note)


@dataclass(frozen=True)
class Asked:
    """A scene: a built-in one with changes."""

    label: str
    base: str
    changes: Changes


def flat(
    *, nu: float = 0.28, aspect: float = 1.0, size: float = 0.2, distance: float = 25.0, beside: float = 4.0
) -> Asked:
    """Half-spaces: one body, lines through and beside the patch, and across at a distance in half-sides."""
    b, a = size, size * aspect
    given = {"ν": (nu, 0.28), "a/b": (aspect, 1.0), "distance / half-side": (distance, 25.0)}
    label = ", ".join(f"{name} = {value:.5g}" for name, (value, usual) in given.items() if value != usual)
    longest = max(a, b)
    lines = [
        {"along": "x", "s": beside * b, "reach": 25 * longest, "points": POINTS},
        {"along": "x", "s": 0.0, "reach": 25 * longest, "points": POINTS},
        {"along": "s", "x": distance * min(a, b), "reach": 25 * longest, "points": POINTS},
    ]
    material = {"nu": nu}
    return Asked(
        label,
        "flat",
        {
            "bodies": ["lower"],
            "components": list(SIX),
            "variants": ["A"],
            "lower": material,
            "upper": material,
            "patch": {"a": a, "b": b},
            "lines": lines,
        },
    )


def on_outline() -> Asked:
    """Half-spaces, with points on the outline of the patch."""
    one = flat()
    patch = one.changes["patch"]
    lines = [
        {"along": "x", "s": 0.0, "reach": 5 * patch["a"], "points": 11},
        {"along": "s", "x": 0.0, "reach": 5 * patch["b"], "points": 11},
    ]
    return Asked("on the outline of the patch", one.base, {**one.changes, "lines": lines})


def _lines(reach: float = 25.0) -> list[dict[str, Any]]:
    return [
        {"along": "x", "s": 1.6, "reach": reach, "points": 101},
        {"along": "x", "s": 0.0, "reach": reach, "points": 101},
        {"along": "s", "x": 1.6, "reach": reach, "points": 101},
    ]


def _of_geometry1(label: str, changes: Changes, body: str = "lower", reach: float = 25.0) -> Asked:
    usual = {"bodies": [body], "components": list(SIX), "variants": ["A"], "lines": _lines(reach)}
    return Asked(label, "geometry1", {**usual, **changes})


def _arc(flank: float, radius: float = 10.0) -> Changes:
    return {"contour": {"kind": "arc", "radius": radius, "flank_inclination_deg": flank}}


def curved(flank: float) -> Asked:
    """The lower body of Geometry 1 with other flanks."""
    both = {"lower": _arc(flank), "upper": _arc(flank)}
    return _of_geometry1(f"{flank:g}°", both)


def wheel(rolling_radius: float) -> Asked:
    """The upper body of Geometry 1, revolved."""
    reach = min(25.0, rolling_radius / 5)
    return _of_geometry1(
        f"{rolling_radius:g} mm", {"upper": {"rolling_radius": rolling_radius}}, "upper", reach
    )


def ratio(over: float) -> Asked:
    """Geometry 1 with a wider arc of the upper body."""
    return _of_geometry1(f"{over - 1:g}", {"upper": _arc(25.5, 10.0 * over)}, "combined")


def moduli(over: float) -> Asked:
    """Half-spaces of unlike stiffness."""
    one = flat()
    changes = {**one.changes, "bodies": ["combined"], "upper": {"E": 210e3 * over}}
    return Asked(f"{over:g}", one.base, changes)


def compared(results: Results, finer: Results | None) -> tuple[float, float, float]:
    """Largest error over lines and components, largest estimate, largest error over its estimate."""
    errors, estimates, used = zip(*each(results, finer), strict=True)
    return max(errors), max(estimates), max(used)


def each(results: Results, finer: Results | None) -> Iterator[tuple[float, float, float]]:
    """Error, estimate, and error over estimate, of every component on every line; against A or a finer C.

    Of C itself, so on the scale of refinement, which the tolerance is for.
    What vanishes by symmetry has an error of rounding and no estimate: it counts from `ROUNDING` on.
    """
    body = results.scene.compared[0]
    c = reference_of(results, body)
    truth = ics_of(results, "A", body) if finer is None else reference_of(finer, body).ic
    off, known = (refinement_shares_of(results, body, of) for of in (c.ic - truth, c.estimate))
    for line in off:
        for name in SIX:
            error, estimate = component_of(off[line], name), component_of(known[line], name)
            yield error, estimate, error / max(estimate, ROUNDING)


def _refuse(engine: str, asked: Asked) -> Callable[[], Beyond]:
    def case() -> Beyond:
        try:
            load_scene(asked.base, {**asked.changes, "engine": {"kind": engine, "check": False}})
        except BadScene as error:
            return Beyond(asked.label, str(error).split("\n")[-1].strip())
        return Beyond(asked.label, "")

    return case
