"""What finite strains change in a contact: an error that neither finer elements nor a better C show.

Contacts are solved with small strains. The next correction is in proportion to the strain, p_max / E, by a
factor that depends on the shape, and on the law of the material at finite strain, which E and nu do not tell:
that of St. Venant and Kirchhoff softens in compression, that of neo-Hooke stiffens. Changes over p_max / E:

    quantity       same      3D, first law    plane strain, first law    second law
    p_max          load      -1.25 ... -0.97  -0.86 ... -0.18            +0.02 ... +0.47
    p_max          approach  -1.46 ... -1.13  -1.33 ... -0.51            +0.15 ... +0.49
    load           approach  -0.68 ... -0.46  -0.84 ... -0.28            +0.02 ... +0.50

So it is an uncertainty: the largest of these, rounded up. Source of the numbers: tools/calculix (3D) and
benchmarks/finite_strain.py; docs/theory/contact.md.
"""

from geometries.errors import WrongInput

AT_LOAD = 1.3  # share of p_max over p_max / E, at the same load
AT_APPROACH, LOAD_AT_APPROACH = 1.5, 0.9  # shares of p_max and of the load, at the same approach


def finite_strain_shares(p_max: float, E: float, *, load_given: bool = True) -> tuple[float, float]:
    """Return by which shares of themselves finite strains change p_max and load of a contact, at most.

    At a given load that is not changed. `p_max` [MPa] is the largest pressure, `E` [MPa] the least Young's
    modulus of both bodies. `load_given`: at the same load, else at the same approach. Raises WrongInput for
    numbers that are not positive.
    """
    if not (p_max >= 0 and E > 0):
        raise WrongInput(
            f"p_max = {p_max!r}, E = {E!r}: give a pressure of 0 or more and a positive modulus [MPa]"
        )
    strain = p_max / E
    if load_given:
        return AT_LOAD * strain, 0.0
    return AT_APPROACH * strain, LOAD_AT_APPROACH * strain
