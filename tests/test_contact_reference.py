"""Reading the reference outputs of CONTACT: made-up text in their layout; theirs are not part of femic."""

import contact_reference as reference
import numpy as np
import pytest

OUTPUT = """ header

 Case     1
 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FY          MZ         ELAST.EN.   FRIC.POWER
     1.000E+05       91.5   2.5E+04   3.8E+04       3.993  -1.055E+04
     FN/G      FX/FSTAT/FN  FY/FSTAT/FN  APPROACH     PMAX
         1.220      0.3048      0.8639   9.089E-02       912.8
         DF/DPEN     DF/DKSI     DF/DETA     DF/DPHI
   FN         0.00        0.00        0.00        0.00

 Case     2
     FN/G       SHIFT X      SHIFT Y     APPROACH     PMAX
     4.598E-02   8.155E-03       0.000   1.998E-02       4.393
"""


def test_numbers_of_each_case_are_read(tmp_path):
    (tmp_path / "some.ref_out").write_text(OUTPUT)
    first, second = reference.printed(tmp_path, "some")
    assert (first["FN"], first["FX"], first["PMAX"], first["APPROACH"]) == (1e5, 91.5, 912.8, 0.09089)
    assert (second["SHIFT_X"], second["PMAX"]) == (8.155e-3, 4.393)


def test_a_table_of_distances_is_read_row_by_row_of_x(tmp_path):
    table = np.arange(39 * 51) / 8
    text = "% Mx=51, ms=39, dx=dy=0.4\n" + "\n".join(map(str, table)) + "\n%    UNRESTRICTED PLANFORM\n 1.0\n"
    (tmp_path / "conformal.inp").write_text(text)
    distance = reference.overlaps(tmp_path)
    assert distance.shape == (39, 51)
    assert distance[1, 2] == pytest.approx((51 + 2) / 8)


def test_stresses_below_a_square_are_compared_at_the_points_of_the_file(tmp_path):
    """Far below, a square of 1 mm is a point load, whose field below it Boussinesq gave."""
    z, G, nu = 50.0, 1.0, 0.28
    u_z = (2 * (1 - nu) + 1) / (4 * np.pi * G * z)
    sigma = -3 / (2 * np.pi * z**2)
    row = [1e-4, 2e-4, z, 0, 0, u_z, 0, 0, 0, 0, 0, 0, 0, sigma]
    (tmp_path / "subsurf.ref_subs").write_text(
        "% NX NY NZ\n 1 1 1 0 0 0 0 0 0 0 0 0 0 0\n" + " ".join(map(str, row))
    )
    ours = {name.split(",")[0]: value for _, name, _, value in reference.below_a_square(tmp_path)}
    assert ours["UZ"] == pytest.approx(u_z, rel=1e-3)
    assert ours["SIGZZ"] == pytest.approx(sigma, rel=1e-3)
