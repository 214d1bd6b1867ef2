"""The tool that compares datasets of results notices what differs, and nothing else."""

import compare_results
import numpy as np
import pytest
import xarray as xr

VALUES = np.array([[1.0, -2.0], [0.0, np.nan]])


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
