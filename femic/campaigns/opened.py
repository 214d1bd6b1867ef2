"""Opens the dataset of a campaign."""

from pathlib import Path

import xarray as xr


def file_in(folder: Path) -> Path:
    """The file of the dataset in a campaign's folder."""
    large = folder / "sweep.zarr"
    return large if large.is_dir() else folder / "sweep.nc"


def open_sweep(path: Path) -> xr.Dataset:
    """The dataset of a campaign's folder, or of its file `sweep.nc` or `sweep.zarr`.

    That of a large one is read as it is used. Raises FileNotFoundError where there is none.
    """
    file = path if path.suffix in {".nc", ".zarr"} else file_in(path)
    if file.suffix == ".zarr":
        return xr.open_zarr(file, consolidated=False, chunks=None)
    return xr.load_dataset(file, engine="h5netcdf")
