"""Runs of statements on normal contact, made by hand so that one measure has a given value."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import xarray as xr

from compare.validation.statements.frame import Estimated
from compare.validation.statements.normal_contacts import NAMES, OF_HERTZ, SOURCE_ANGLES, TALL, WIDE
from compare.validation.statements.runs import Runs
from femic.contact.operators.dense import Asymmetry
from femic.contact.pairs.ics import ReferenceICs
from femic.contact.patch import Extent
from femic.results.finite_elements import FE
from femic.scenes.load import load_scene

WITH_C, KNOWN = 10.0, 0.004  # each number with C; the estimate of each error and share of an angle
N_X, N_S, DX, DS = 16, 12, 0.5, 0.2  # a grid whose inner N_X - 8 times N_S - 6 elements are in contact
BY_FE = 0.003  # estimate of approaches by finite elements, of these


class Sum:
    """A sum of operators, each times a factor."""

    def __init__(self, *parts):
        self.parts = parts

    def __call__(self, tractions):
        return sum(factor * operator(tractions) for factor, operator in self.parts)

    def coarsened(self):
        return Sum(*((factor, operator.coarsened()) for factor, operator in self.parts))


def made_c(_, on_grid, __):
    """A little beyond B-hat, as seen from A, and 1 % softer with its estimated error."""
    parts = (1.2, on_grid.operator("Bhat")), (-0.2, on_grid.operator("A"))
    softer = Sum(*((1.01 * factor, operator) for factor, operator in parts))
    return ReferenceICs(Sum(*parts), softer, 0.01, Asymmetry(0.0, "nn"), 1.0, 0.0)


class CoarseSeries(Runs):
    """Contacts under any load on few elements."""

    def _contact_scene(self, name):
        return load_scene(name, {"contact": {"elements": 8}})


@dataclass
class Series:
    """Contacts whose loads are the angles of their patches, with given errors by ICs and number."""

    errors: dict
    of_angle: float = 1.0  # angles over those of the source under its loads
    contacts: dict | None = None  # by load

    def load_at(self, angle):
        return angle

    def numbers(self, _, ics="C"):
        return {name: WITH_C * (1 + self.errors.get((ics, name), 0.0)) for name in NAMES}

    def error(self, _, ics, name):
        return Estimated(self.errors.get((ics, name), 0.0), KNOWN)

    def angle(self, load, _="C"):
        (angles,) = (angles for angles in SOURCE_ANGLES.values() if load in angles)
        return self.of_angle * angles[load]

    def angle_with_c(self, load):
        return Estimated(self.angle(load), KNOWN * self.angle(load))

    def solved(self, load, _="C"):
        return self.contacts[load]

    contact = solved


def runs_of(wide, tall):
    """Both pairs."""
    return lambda: SimpleNamespace(contact_series={WIDE: wide, TALL: tall}.__getitem__)


def errors_of(ics, names, error, tall=None):
    """All of these ICs and numbers off by the same, and by another error on `tall` if one is given."""
    wide, high = (
        Series({(which, name): value for which in ics for name in names})
        for value in (error, error if tall is None else tall)
    )
    return runs_of(wide, high)


def bhat_times(share, *numbers):
    """B off by 0.1 in everything, B-hat by a share of it in some numbers, by pair, by 0.1 in others."""

    def series(pair):
        bhat = {
            ("Bhat", name): -0.1 * (share if (pair, name) in numbers or not numbers else 1) for name in NAMES
        }
        return Series(bhat | {("B", name): 0.1 for name in NAMES})

    return runs_of(series(WIDE), series(TALL))


def angles_off(share):
    return runs_of(Series({}, 1 + share), Series({}, 1 + share))


# --- pressures ------------------------------------------------------------------------------------------


def raised(n, peakedness):
    """n values of 1, the middle two raised so that the largest over the mean is this."""
    values = np.ones(n)
    values[n // 2 - 1 : n // 2 + 1] = peakedness * (n - 2) / (n - 2 * peakedness)
    return values


def contact_of(p, slope=0.0):
    """A contact with pressures on the inner elements; A adds `slope` times their sum to u_n by B-hat, p."""
    inside = np.zeros((N_X, N_S), dtype=bool)
    inside[4:-4, 3:-3] = True
    pressures = np.zeros(inside.shape)
    pressures[4:-4, 3:-3] = p
    patch = Extent(inside, (3.5, N_X - 4.5), (2.5, N_S - 3.5), 0.0, 0.0)
    x, s = (d * (np.arange(n) - (n - 1) / 2) for d, n in ((DX, N_X), (DS, N_S)))
    grid = SimpleNamespace(strips=s, dx=DX, ds=DS, n_x=N_X, n_s=N_S)

    def operator(ics):
        return lambda p: p + (slope * np.sum(p) if ics == "A" else 0.0)

    return SimpleNamespace(
        on_grid=SimpleNamespace(x=x, grid=grid, operator=operator),
        normal=SimpleNamespace(p=pressures, pressures=pressures, patches=[patch]),
    )


def shapes(along_x, along_s):
    """Contacts at the source's loads with peakedness along x and s: the first, and its growth."""
    series = []
    for angles in SOURCE_ANGLES.values():
        contacts = {}
        for k, load in enumerate(angles):
            of_x, of_s = (first * (1 + growth) ** k for first, growth in (along_x, along_s))
            contacts[load] = contact_of(np.outer(raised(N_X - 8, of_x), raised(N_S - 6, of_s)))
        series.append(Series({}, contacts=contacts))
    return runs_of(*series)


def near_hertz(share):
    return shapes((OF_HERTZ * (1 + share), 0.0), (1.2, 0.0))


class AnyLoad(dict):
    """The same contact at all loads."""

    def __missing__(self, _):
        return self[None]


def spread(more=1.0, tall=1.0):
    """The sum of pressures of `wide` over that of `tall`; differences on the patch of `tall` over `wide`.

    The largest pressure is 1 on both.
    """
    flat = np.full((N_X - 8, N_S - 6), 0.1)
    flat[0, 0] = 1.0
    wide = np.where(flat == 1.0, 1.0, (more * flat.sum() - 1.0) / (flat.size - 1))
    contacts = [AnyLoad({None: contact_of(p, slope)}) for p, slope in ((wide, 1e-3), (flat, 1e-3 * tall))]
    return runs_of(*(Series({}, contacts=each) for each in contacts))


# --- approaches -----------------------------------------------------------------------------------------


def approaches(bent=0.1, off=0.3, of_mzz=1.0):
    """Differences of approaches `of_mzz` times M_zz times load, each second one larger by `bent`.

    Approaches with C are such that what the other loads do not foresee is `off` of them, besides what is
    known of finite elements, unless `bent` is 0.
    """

    def dataset(contacts):
        load, mzz = np.array(contacts.loads), 1e-6
        parts = of_mzz * mzz * load * (1 + bent * (np.arange(len(load)) % 2))
        left = [np.delete(np.arange(len(load)), k) for k in range(len(load))]
        foreseen = [np.linalg.lstsq(load[k][:, None], parts[k], rcond=None)[0][0] for k in left]
        with_c = np.abs(parts - foreseen * load) / (off + BY_FE) if bent else np.ones(len(load))
        by_fe = 2 * with_c
        return xr.Dataset(
            {
                "approach": (("case", "ics"), np.stack([with_c, by_fe], axis=-1)),
                "estimate_approach": (("case", "ics"), np.stack([0 * with_c, BY_FE * by_fe], axis=-1)),
                "fe_raw_approach": ("case", with_c + parts),
                "load": ("case", load),
                "rigid_compliance": mzz,
            },
            coords={"ics": ["C", FE]},
        )

    return lambda: SimpleNamespace(fe_contact=dataset)


BOTH = ("B", "Bhat")
EXACT = {  # thresholds, and runs in which the number has a value
    (26, "A"): (0.05, lambda v: errors_of(("A",), NAMES, -v)),
    (27, "tall minus wide"): (0.0, lambda v: errors_of(("A",), NAMES, 0.05, -0.05 - v)),
    (28, "B, B̂"): (0.1, lambda v: errors_of(BOTH, NAMES, v)),
    (29, "better"): (1.0, bhat_times),
    (29, "approach"): (1.0, lambda v: bhat_times(v, (TALL, "approach"))),
    (30, "angles"): (0.1, angles_off),
    (31, "uniform"): (0.0, lambda v: shapes((1.2, 0.0), (1.2, v))),
    (31, "peaked"): (0.0, lambda v: shapes((1.2, 0.0), (1.2, v))),
    (31, "near Hertz"): (0.1, near_hertz),
    (31, "along x"): (0.0, lambda v: shapes((1.2, v), (1.2, 0.0))),
    (32, "spread"): (1.0, lambda v: spread(more=v)),
    (32, "tall"): (1.0, lambda v: spread(tall=v)),
    (33, "proportional"): (0.02, lambda v: approaches(off=v)),
    (33, "rigid"): (0.05, lambda v: approaches(bent=0.0, of_mzz=1 + v)),
}
