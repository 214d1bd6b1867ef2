"""Contacts with friction made by hand, so that a measure of a statement has a given value."""

from contextlib import contextmanager
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from compare.validation.statements.components_and_moduli import CONCAVE, CONVEX, moduli
from compare.validation.statements.friction_contacts import FRICTIONS, ICS, LOADS
from femic.contact.estimates import SAFETY
from tests.compare.validation.statements.makers import contacts as fe_contacts

LOAD, SLOPE, ZERO = 100e3, 2e7, -1e-3  # with C
CURVE, PRESSURE, TRACTION, SLIDING = 0.02, 0.01, 0.008, 0.005  # estimates of distances from C
VARIED = {"F_x", "zero_creepage", "slope", "p_max", "sliding_share", "p"}
XI = np.linspace(-2e-3, 2e-3, 9)
ON_GRID = {"friction": list(FRICTIONS), "x": [-1.0, 1.0], "s": [-1.5, -0.5, 0.5, 1.5]}
ATTRS = {"load": LOAD, "equal_force": 0.5, "dx": 2.0, "ds": 1.0, "s_middle": 0.0}


@contextmanager
def without_estimates():
    """Distances have no estimates, four fifths of the work, where only their sizes are asked for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "compare.validation.statements.friction_contacts.estimate_of_difference", lambda *_: 0.0
        )
        yield


def by(friction, ics, size):
    """Numbers by friction and ICs; `size` is a number, or one of both."""
    return [[size(f, name) if callable(size) else size for name in ics] for f in friction]


def with_variations(contacts, sizes):
    """Contacts in which distances from C have estimates of these sizes by name: half by elements, half by C.

    Elements are far off, but with all ICs alike: factors of tractions, offsets of other numbers.
    """
    is_c, varied, factors = contacts.ics == "C", {}, {"p": 1.3, "p_max": 1.3, "slope": 1.0}
    for name in {*contacts.data_vars} & VARIED:
        values, half = contacts[name], 0.5 * sizes.get(name, 0.0)
        coarse = values + half / SAFETY * ~is_c
        alike = factors[name] * coarse if name in factors else coarse + 0.3 * values.max("ics")
        varied[f"larger_{name}"] = alike
        varied[f"change_{name}"] = 0 * values + half * is_c
    varied["larger_p"] = varied["larger_p"].coarsen(x=2, s=2).mean().rename(x="larger_x", s="larger_s")
    return contacts.assign(varied)


def rolling(ics=ICS, *, zero=0.0, force=None, rms=0.0, largest=0.0, p_x=1.0, p_max=1.0, frictions=FRICTIONS):
    """Rolling: `zero` are distances to C's creepage without force, in friction load over slope.

    `force` is F_x over friction load by friction, ICs and creepage, `p_x` a factor of tractions with C.
    """
    ics = [*ics]
    table = {
        name: (("friction", "ics"), by(frictions, ics, size))
        for name, size in {
            "rms": rms,
            "largest": largest,
            "slope": SLOPE,
            "estimate_rms": CURVE,
            "estimate_largest": CURVE,
        }.items()
    }
    load = np.array(frictions)[:, None] * LOAD
    table["zero_creepage"] = ("friction", "ics"), ZERO + np.array(by(frictions, ics, zero)) * load / SLOPE
    linear = force or (lambda f, _, xi: SLOPE * (xi - ZERO) / (f * LOAD))
    forces = [[f * LOAD * linear(f, name, XI) for name in ics] for f in frictions]
    table["F_x"] = ("friction", "ics", "xi"), forces
    table["estimate_F_x"] = ("friction", "ics", "xi"), np.zeros_like(forces)
    for name in ("p_max", "a", "b"):
        table[name] = ("friction", "ics", "xi"), np.stack([by(frictions, ics, p_max)] * len(XI), axis=-1)
    tractions = np.ones((len(frictions), len(ics), 2, 4, 3)) * np.array([1.0, 2.0, 3.0, 4.0])[:, None]
    tractions[..., 0] *= np.array(by(frictions, ics, p_x))[..., None, None]
    coords = ON_GRID | {"friction": list(frictions)}
    dims = "friction", "ics", "x", "s", "direction"
    contacts = (
        xr.Dataset(table | {"p": (dims, tractions)})
        .assign_coords(ics=ics, xi=XI, direction=list("xsn"), **coords)
        .assign_attrs(ATTRS)
    )
    along_x = contacts.p.isel(ics=0, drop=True).sel(direction="n") * (contacts.direction == "x")
    sizes = {"zero_creepage": CURVE * contacts.friction * LOAD / SLOPE, "p_max": PRESSURE}
    return with_variations(contacts, sizes | {"p": TRACTION * along_x})


def compression(ics=ICS, *, p_s=0.0, sliding=0.0, p_max=1.0):
    """Compression: `p_s` are distances of tractions from half of friction times pressure."""
    ics = [*ics]
    friction = np.array(FRICTIONS)[:, None, None, None]
    p_n = np.ones((len(FRICTIONS), len(ics), 2, 4)) * np.array([1.0, 2.0, 3.0, 4.0])
    along_s = friction * p_n * (0.5 + np.array(by(FRICTIONS, ics, p_s))[..., None, None])
    dims, loads = ("friction", "ics", "load"), list(LOADS)
    share = 0.3 + np.array(by(FRICTIONS, ics, sliding))
    table = {"sliding_share": (dims, np.stack([share] * len(loads), axis=-1))}
    table["estimate_sliding_share"] = dims, np.full_like(table["sliding_share"][1], SLIDING)
    for name in ("p_max", "a", "b"):
        table[name] = dims, np.stack([by(FRICTIONS, ics, p_max)] * len(loads), axis=-1)
    table["p"] = ("friction", "ics", "x", "s", "direction"), np.stack([0 * p_n, along_s, p_n], axis=-1)
    contacts = (
        xr.Dataset(table)
        .assign_coords(ics=ics, load=loads, direction=list("xsn"), **ON_GRID)
        .assign_attrs(ATTRS)
    )
    bound = contacts.friction * contacts.p.isel(ics=0, drop=True).sel(direction="n")
    along_s = TRACTION * bound * (contacts.direction == "s")
    return with_variations(contacts, {"sliding_share": SLIDING, "p": along_s})


def runs(name="rolling", **numbers):
    """Runs whose contacts have these numbers; those of other motions, and of ICs by themselves, have none."""
    makers = {"rolling": rolling, "compression": compression}

    @cache  # statements ask for the same contacts again and again
    def made(motion, ics):
        return makers[motion](ics, **(numbers if motion == name else {}))

    def friction(motion, changes, *_):
        return made(motion, tuple(changes["contact"]["ics"]))

    return lambda: SimpleNamespace(friction=friction)


def of(chosen, size, others=0.0):
    """A size of chosen ICs, another of the others, 0 of C."""
    return lambda _, name: size if name in chosen else 0.0 if name == "C" else others


def scaled(chosen, size, others=0.0):
    """1 plus that."""
    return lambda f, name: 1.0 + of(chosen, size, others)(f, name)


def growing(v, base=0.1, one=0.0):
    """A size that changes by the factor v from friction to friction, on top of `one`; 0 of C."""
    return lambda f, name: one + (0.0 if name == "C" else base * v ** round(5 * f - 1))


def from_low(v, base=0.1):
    """v times as large at the least friction."""
    return lambda f, name: 0.0 if name == "C" else base * (v if f == FRICTIONS[0] else 1.0)


def left(v):
    """Curves moved by 0.4 of friction load, and apart by v of the whole distance when they are moved back."""
    more = 0.4 * v / (1 - v)

    def force(f, name, xi):
        at = SLOPE * (xi - ZERO) / (f * LOAD)
        return at if name == "C" else at - 0.4 - more

    return runs(zero=of((), 0.0, 0.4), force=force)


def exchanged(v):
    """Curves apart by v from B-hat's."""
    return runs(force=lambda f, name, xi: SLOPE * (xi - ZERO) / (f * LOAD) + (v if "+" in name else 0.0))


def with_exchange(size, one=0.0):
    """A size of ICs with an exchanged component, on top of `one`."""
    return lambda _, name: one + (size if "+" in name else 0.0)


def softer(number, v, ratio_of_moduli):
    """Distances from C v times as large at this ratio of moduli."""

    @cache
    def made(ics, frictions, factor):
        sizes = {"rms": of((), 0.0, factor)} if number == "rms" else {"p_max": scaled((), 0.0, factor)}
        return rolling(ics, **sizes, frictions=frictions)

    def friction(_, changes, *__):
        contact, unequal = changes["contact"], moduli(ratio_of_moduli)["upper"]
        is_unequal = changes.get("upper", {}).get("E") == unequal
        frictions = tuple(contact.get("friction", FRICTIONS))
        return made(tuple(contact["ics"]), frictions, 0.1 * (v if is_unequal else 1.0))

    return lambda: SimpleNamespace(friction=friction)


def two_contacts(**numbers):
    """Contacts by two operators that are apart by these numbers."""
    return lambda: SimpleNamespace(once=lambda *_: {"B, rolling": SimpleNamespace(**numbers)})


SHIFTED, FIT = ("B", "Bhat"), ("Bhat_prime",)
A_XN = ("Bhat+sn:B+xn:A",)
MADE = {  # the threshold, and runs for a value
    (34, "shift"): (0.10, lambda v: runs(zero=of((), 0.0, v))),
    (34, "as a whole"): (1 / 3, left),
    (34, "restored"): (1 / 3, lambda v: runs(zero=of(FIT, 0.3 * v, 0.3))),
    (34, "close"): (0.10, lambda v: runs(largest=of(FIT, v))),
    (35, "off"): (0.10, lambda v: runs(p_x=scaled(SHIFTED, v))),
    (35, "restored"): (1 / 3, lambda v: runs(p_x=scaled(FIT, 0.3 * v, 0.3))),
    (35, "close"): (0.10, lambda v: runs(p_x=scaled(FIT, v))),
    (36, "curve"): (1.0, lambda v: runs(rms=growing(v))),
    (36, "p_x"): (1.0, lambda v: runs(p_x=growing(v, one=1.0))),
    (37, "B"): (1.0, lambda v: runs("compression", p_s=of(("B",), 0.1 * v, 0.1))),
    (37, "B̂′"): (1.0, lambda v: runs("compression", p_s=of(FIT, 0.1 * v, 0.1))),
    (37, "smaller"): (1.0, lambda v: runs("compression", p_s=from_low(v))),
    (37, "sliding"): (1.0, lambda v: runs("compression", sliding=from_low(v))),
    (38, "curve"): (0.05, exchanged),
    (38, "patch"): (0.05, lambda v: runs(p_max=with_exchange(v, one=1.0))),
    (38, "tractions"): (0.05, lambda v: runs("compression", p_s=with_exchange(v))),
    (38, "pressed patch"): (0.05, lambda v: runs("compression", p_max=with_exchange(v, one=1.0))),
    (39, "curve"): (1.0, lambda v: runs(rms=of(("mix",), 0.1 * v, 0.1))),
    (39, "p_x"): (1.0, lambda v: runs(p_x=scaled(("mix",), 0.1 * v, 0.1))),
    (39, "pressure"): (1.0, lambda v: runs(p_max=scaled(("mix",), 0.1 * v, 0.1))),
    (39, "compression"): (1.0, lambda v: runs("compression", p_s=of(("mix",), 0.1 * v, 0.1))),
    (40, "curve"): (1.0, lambda v: runs(rms=of(A_XN, 0.1 * v, 0.1))),
    (40, "p_x"): (1.0, lambda v: runs(p_x=scaled(A_XN, 0.1 * v, 0.1))),
    (41, "convex curve"): (1.0, lambda v: softer("rms", v, CONVEX)),
    (41, "concave curve"): (1.0, lambda v: softer("rms", v, CONCAVE)),
    (41, "convex pressure"): (1.0, lambda v: softer("p_max", v, CONVEX)),
    (41, "concave pressure"): (1.0, lambda v: softer("p_max", v, CONCAVE)),
    (42, "tractions"): (1e-5, lambda v: two_contacts(tractions=v)),
    (42, "approach"): (1e-5, lambda v: two_contacts(approach=v)),
    (43, "patch"): (0.02, lambda v: fe_contacts(**dict.fromkeys(("a", "b", "angle", "p_max"), v))),
    (43, "approach"): (0.02, lambda v: fe_contacts(approach=v)),
    (45, "tractions"): (1e-4, lambda v: two_contacts(tractions=v)),
    (45, "forces"): (1e-4, lambda v: two_contacts(forces=v)),
    (45, "patch"): (1e-4, lambda v: two_contacts(area=v)),
    (45, "approach"): (1e-5, lambda v: two_contacts(approach=v)),
}
