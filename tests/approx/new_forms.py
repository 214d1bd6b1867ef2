"""Approximations that the program does not have, each registered once."""

import numpy as np

from approx.forms import FORMS, Form, Shares
from approx.variants import MIRRORS, VARIANTS, Variant


def faded(ics, rotation):
    """B with A_sn and A_ns times 1 - |alpha| / pi, which is exact on a cylindrical cavity."""
    a = ics.copy()
    for at in ((1, 2), (2, 1)):
        a[at] *= 1 - rotation.angle / np.pi
    return FORMS["B"].rotate(a, rotation)


def unlike_in_x(ics, _rotation):
    """A with a part of xn in nn."""
    changed = ics.copy()
    changed[2, 2] += ics[0, 2]
    return changed


def not_linear(ics, _rotation):
    """A with the length of the displacement in nn."""
    changed = ics.copy()
    changed[2, 2] = np.linalg.norm(ics[:, 2], axis=0)
    return changed


NEW_FORMS = {
    "Btilde": Form(Shares(observer=2 / 3, load=1 / 3)),
    "Btilde_prime": Form(Shares(observer=2 / 3, load=1 / 3), effective=True),
    "Bfaded": Form(faded),
    "Bprime_or_Bfaded": Form(Shares(observer=0, load=1), effective=True, fallback=Form(faded)),
    "Alength": Form(not_linear),
    "Askew": Form(unlike_in_x),
}


def register(monkeypatch):
    """Register the new forms, and a variant of each, until the test ends."""
    for name, form in NEW_FORMS.items():
        monkeypatch.setitem(FORMS, name, form)
        monkeypatch.setitem(VARIANTS, name, Variant(f"symbol of {name}", "a new one", MIRRORS))
