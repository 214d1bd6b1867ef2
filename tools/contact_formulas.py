"""How Hertz's numbers differ in conformal contact: contacts by C, and formulas fitted to them.

    python tools/contact_formulas.py [--compute]

A wheel with an arc as its section lies on a prismatic arc that fits closely into it. With --compute, contacts
without friction are solved by C at many ratios of the radii, aspect ratios and loads, with the exact
distance, and kept in docs/numbers/formulas.json: one set to fit, another at random to judge. Then the
formulas are fitted, and written into the same file, which docs/decide/formulas.md shows.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.special import elliprd

import femic
from compare.report.looks import FURTHER
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.contact.exact.hertz import PointContact, combined_modulus
from geometries.errors import Failure

ROOT = Path(__file__).parents[1]
NUMBERS = ROOT / "docs" / "numbers" / "formulas.json"
RADIUS = 10.0  # of the lower section [mm]: all lengths are relative to it
N, DS = 40, 0.45  # elements along x and s, width of strips [mm]: sections up to 51 degrees
RATIOS = (1.003, 1.01, 1.03, 1.08, 1.2, 1.6)  # radius of the upper section over that of the lower one
ASPECTS = (0.25, 0.6, 1.0, 2.5, 8.0)  # a / b of Hertz's ellipse
ANGLES = np.linspace(0.2, 0.72, 14)  # b of Hertz's ellipse over RADIUS [rad]
HELD_OUT, SEED = 12, 20261128
LARGEST = 0.8 * N / 2 * DS / RADIUS  # half-angle of contacts that are kept [rad]


@dataclass(frozen=True)
class Case:
    """A pair: ratio of the radii, aspect ratio of Hertz's ellipse, Poisson's ratio, flanks [deg]."""

    ratio: float
    aspect: float
    nu: float = 0.3
    flank: float = 70.0

    @property
    def rolling_radius(self) -> float:
        """The radius [mm] that gives the aspect ratio."""
        slender = 1 / self.aspect
        curvature_x = self.curvature_s * elliprd(0, slender**2, 1) / elliprd(0, 1, slender**2)
        return float(1 / curvature_x)

    @property
    def curvature_s(self) -> float:
        """Relative curvature of the sections [1/mm]."""
        return (1 - 1 / self.ratio) / RADIUS

    @property
    def material(self) -> femic.Material:
        """Both bodies are of it."""
        return femic.Material(E=210e3, nu=self.nu)

    def pair(self, rolling_radius: float | None = None) -> femic.Pair:
        """Return the bodies; the upper one prismatic without a rolling radius."""
        upper = femic.arc(self.ratio * RADIUS, self.flank)
        wheel = (
            femic.Body(upper, self.material, rolling_radius=rolling_radius)
            if rolling_radius
            else femic.Body(upper, self.material)
        )
        return femic.Pair(wheel, femic.Body(femic.arc(RADIUS, self.flank), self.material))

    def contacts(self, angles: Any, store: str) -> list[dict[str, float]]:
        """Return Hertz's numbers and those by C, for angles of Hertz's ellipse [rad]."""
        modulus = combined_modulus(self.material, self.material)
        hertz = PointContact(1 / self.rolling_radius, self.curvature_s, modulus)
        per_load = hertz.at_load(1.0)
        loads = [float((angle * RADIUS / per_load.b) ** 3) for angle in angles]
        grid = femic.Grid(N, N, self.aspect * DS, DS)
        options = femic.Options(tolerance=0.02, store=store)
        c = femic.compute_matrix(self.pair(), grid, "C", options)
        setup, rows = femic.ContactSetup(gap="exact"), []
        for load in loads:
            try:
                found = femic.solve_contact(
                    self.pair(self.rolling_radius), femic.Frictionless([load]), [c, "A"], setup, options
                ).squeeze()
            except (Failure, femic.WrongInput) as failure:
                sys.stderr.write(f"{self}, {load:g} N: {failure}\n")
                break
            if np.radians(float(found.angle[0])) / 2 > LARGEST:
                break
            of = hertz.at_load(load)
            own = {"p_max": of.p_max, "approach": of.approach, "a": of.a, "b": of.b}
            row = {"ratio": self.ratio, "aspect": self.aspect, "nu": self.nu, "flank": self.flank}
            row |= {"theta": of.b / RADIUS, "angle": float(found.angle[0])}
            for name, value in own.items():
                row[name] = float(found[name][0]) / value
                row[f"A_{name}"] = float(found[name][1]) / value
                row[f"estimate_{name}"] = float(found[f"estimate_{name}"][0]) / value
            rows.append(row)
        sys.stdout.write(f"{self}: {len(rows)} contacts\n")
        sys.stdout.flush()
        return rows


def cases() -> tuple[list[Case], list[Case]]:
    """Return the pairs to fit, and those at random to judge."""
    random = np.random.default_rng(SEED)
    others = [
        Case(
            ratio=1 + float(np.exp(random.uniform(np.log(0.004), np.log(0.5)))),
            aspect=float(np.exp(random.uniform(np.log(0.3), np.log(6.0)))),
            nu=float(random.uniform(0.25, 0.35)),
            flank=float(random.uniform(60.0, 80.0)),
        )
        for _ in range(HELD_OUT)
    ]
    return [Case(ratio, aspect) for ratio in RATIOS for aspect in ASPECTS], others


def contacts_by_c(store: str) -> dict[str, Any]:
    """Return all contacts."""
    fitted, others = cases()
    random = np.random.default_rng(SEED + 1)
    return {
        "judged": [
            row for case in others for row in case.contacts(np.sort(random.uniform(0.2, 0.7, 8)), store)
        ],
        "fitted": [row for case in fitted for row in case.contacts(ANGLES, store)],
    }


# --- formulas -------------------------------------------------------------------------------------------

QUANTITIES = ("p_max", "approach", "a", "b")
TERMS = {  # powers of t = (b / R_1)^2 of Hertz's ellipse, c = 1 - R_1 / R_2, w = b / (a + b)
    "t": (1, 0, 0),
    "t*c": (1, 1, 0),
    "t*w": (1, 0, 1),
    "t*c*w": (1, 1, 1),
    "t*w*w": (1, 0, 2),
    "t*c*w*w": (1, 1, 2),
    "t*t": (2, 0, 0),
    "t*t*w": (2, 0, 1),
}
WITHIN = 0.95


def columns(rows: list[dict[str, float]]) -> dict[str, Any]:
    """Return the values of contacts by name."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def matrix(values: dict[str, Any]) -> Any:
    """Return the terms of contacts, (n, terms): logarithms of ratios are sums of these."""
    variables = np.stack([values["theta"] ** 2, 1 - 1 / values["ratio"], 1 / (1 + values["aspect"])], axis=-1)
    return np.stack([np.prod(variables**powers, axis=-1) for powers in TERMS.values()], axis=-1)


def rounded(value: float, digits: int = 5) -> float:
    """Return a number with so many digits, which are the same on every computer."""
    return float(f"{value:.{digits}g}")


def fit(contacts: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    """Return coefficients of each quantity, and errors on the contacts that judge."""
    fitted, judged = columns(contacts["fitted"]), columns(contacts["judged"])
    found = {}
    for name in QUANTITIES:
        coefficients = np.linalg.lstsq(matrix(fitted), np.log(fitted[name]), rcond=None)[0]
        published = [rounded(value, 3) for value in coefficients]
        errors = {
            "formula": np.exp(matrix(judged) @ published) / judged[name] - 1,
            "fitted": np.exp(matrix(fitted) @ published) / fitted[name] - 1,
            "hertz": 1 / judged[name] - 1,
            "A": judged[f"A_{name}"] / judged[name] - 1,
        }
        found[name] = {
            "coefficients": published,
            "estimate": rounded(np.quantile(judged[f"estimate_{name}"] / judged[name], WITHIN)),
            "errors": {
                what: {
                    "within": rounded(np.quantile(np.abs(values), WITHIN)),
                    "least": rounded(values.min()),
                    "largest": rounded(values.max()),
                }
                for what, values in errors.items()
            },
        }
    return found


def numbers(contacts: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    """Return what the page shows, with the contacts, whose numbers have five digits."""
    contacts = {
        kind: [{name: rounded(value) for name, value in row.items()} for row in rows]
        for kind, rows in contacts.items()
    }
    both = columns([*contacts["fitted"], *contacts["judged"]])
    return {
        "code": results_digest(*STUDY_FOLDERS),
        "versions": versions(),
        "terms": list(TERMS),
        "numbers": fit(contacts),
        "counts": {name: len(rows) for name, rows in contacts.items()},
        "range": {name: float(both[name].max()) for name in ("theta", "angle")},
        "contacts": contacts,
    }


def draw(values: dict[str, Any]) -> Figure:
    """Return the figure: p_max by C over Hertz's, and the formula, at some ratios of the radii."""
    rows, coefficients = columns(values["contacts"]["fitted"]), values["numbers"]["p_max"]["coefficients"]
    figure = Figure((8.4, 3.6), layout="constrained")
    for axes, aspect in zip(figure.subplots(1, 2, sharey=True), (1.0, 8.0), strict=True):
        for ratio, look in zip(RATIOS, FURTHER, strict=True):
            own = (rows["ratio"] == ratio) & (rows["aspect"] == aspect)
            theta = np.linspace(0, rows["theta"].max(), 61)
            line = {"theta": theta, "ratio": np.full(61, ratio), "aspect": np.full(61, aspect)}
            axes.plot(theta, np.exp(matrix(line) @ coefficients), color=look.colour, label=f"{ratio:g}")
            axes.plot(rows["theta"][own], rows["p_max"][own], ".", color=look.colour)
        axes.set_title(f"a/b of Hertz's ellipse: {aspect:g}")
        axes.set_xlabel("θ = b/R₁ of Hertz's ellipse [rad]")
        axes.grid(visible=True, alpha=0.3)
    figure.axes[0].set_ylabel("p_max over that of Hertz [-]")
    figure.axes[0].legend(title="R₂/R₁")
    return figure


def compute() -> dict[str, Any]:
    """Return the numbers of the page; models of C are kept in out/formulas."""
    folder = ROOT / "out" / "formulas"
    folder.mkdir(parents=True, exist_ok=True)
    return numbers(contacts_by_c(str(folder / "store")))


def save(values: dict[str, Any]) -> None:
    """Save the numbers of the page, and its picture."""
    NUMBERS.write_text(json.dumps(values, ensure_ascii=False) + "\n", encoding="utf-8")
    draw(values).savefig(ROOT / "docs" / "images" / "formulas.png", dpi=130)


if __name__ == "__main__":
    stored = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {}
    values = compute() if "--compute" in sys.argv[1:] else numbers(stored["contacts"])
    if "--compute" not in sys.argv[1:]:
        values |= {name: stored[name] for name in ("code", "versions")}
    save(values)
