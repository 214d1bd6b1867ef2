"""Tools beside the product: all start; comparison of results, outputs of CONTACT, numbers of stresses."""

import runpy
import subprocess
import sys
from pathlib import Path

import compare_results
import contact_reference as reference
import numpy as np
import pytest
import stress_numbers
import xarray as xr

ROOT = Path(__file__).parents[1]
PROGRAMS = sorted(
    path
    for folder in ("tools", "benchmarks")
    for path in (ROOT / folder).glob("*.py")
    if '"__main__"' in path.read_text(encoding="utf-8")
)
VALUES = np.array([[1.0, -2.0], [0.0, np.nan]])


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_programs_can_be_imported(program, monkeypatch):
    monkeypatch.syspath_prepend(str(program.parent))
    assert runpy.run_path(str(program), run_name="not_main")["__name__"] == "not_main"


@pytest.mark.parametrize("folder", ["attack", "calculix"])
def test_folders_of_programs_start(folder):
    command = [sys.executable, str(ROOT / "tools" / folder), "--help"]
    assert "usage" in subprocess.run(command, check=True, capture_output=True, text=True).stdout


def write(folder, values=VALUES, name="ics.nc", **more):
    folder.mkdir(exist_ok=True)
    arrays = {"ic": (("i", "j"), values), "unit": "mm/N", "seconds": 1.0} | more
    xr.Dataset(arrays).to_netcdf(folder / name, engine="h5netcdf")


@pytest.fixture
def code(tmp_path, monkeypatch):
    """The exit code of a comparison of two folders, of which the first is written."""
    write(tmp_path / "a")

    def compared(*further):
        monkeypatch.setattr("sys.argv", ["compare", str(tmp_path / "a"), str(tmp_path / "b"), *further])
        return compare_results.main()

    return compared


def test_rounding_and_seconds_are_ignored(tmp_path, code):
    write(tmp_path / "b", VALUES * (1 + 1e-12), seconds=2.0)
    assert code() == 0
    assert code("--tolerance", "1e-13") == 1


@pytest.mark.parametrize(
    "change",
    [
        {"values": np.add(VALUES, [[0.0, 0.0], [1e-6, 0.0]])},
        {"values": np.nan_to_num(VALUES)},
        {"values": VALUES[:1]},
        {"unit": "mm/MPa"},
        {"further": 1.0},
        {"name": "others.nc"},
    ],
    ids=str,
)
def test_differences_are_detected(tmp_path, code, change):
    write(tmp_path / "b", **change)
    assert code() == 1


def test_files_with_another_name_are_compared(tmp_path, code, capsys):
    write(tmp_path / "b", name="new.nc")
    assert code("--rename", "ics.nc=new.nc") == 0
    assert "2 arrays" in capsys.readouterr().out


# --- outputs of CONTACT: made-up text in their layout; theirs are not part of femic --------------------


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


# --- from which angle on half-spaces are off inside the bodies -----------------------------------------


def rows(*errors):
    """Rows at 20, 40, 60 ... degrees, whose half-spaces are off by these in both numbers."""
    return [
        {"angle": 20.0 * (k + 1), "bodies": {"upper": {"half_space": error, "section": abs(error)}}}
        for k, error in enumerate(errors)
    ]


def first(off, *errors):
    angles = stress_numbers._first_angles(rows(*errors), off)
    assert angles["upper, half_space"] == angles["upper, section"]
    return angles["upper, section"]


def test_errors_pass_a_limit_between_the_loads_around_it():
    assert first(0.05, 0.01, -0.03, -0.07, -0.2) == pytest.approx(50.0)
    assert first(0.05, 0.1, 0.2) == pytest.approx(10.0)  # errors are 0 where the patch is a point
    assert first(0.05, 0.0, 0.09, 0.01, 0.2) == pytest.approx(20 + 20 * 5 / 9)  # the first of several


def test_errors_that_stay_below_pass_nowhere():
    assert first(0.05, 0.01, -0.05) is None
