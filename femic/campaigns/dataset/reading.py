"""Open the dataset of a campaign."""

from pathlib import Path

import xarray as xr

FILE, ZARR = "sweep.nc", "sweep.zarr"


def file_in(folder: Path) -> Path:
    """Return the path of the dataset in a campaign's folder."""
    large = folder / ZARR
    return large if large.is_dir() else folder / FILE


def open_sweep(path: Path) -> xr.Dataset:
    """Open the dataset in a campaign's folder, or its file `sweep.nc` or `sweep.zarr`.

    A large one is read as it is used. Raises FileNotFoundError where there is none.
    """
    file = path if path.suffix in {".nc", ".zarr"} else file_in(path)
    if file.suffix == ".zarr":
        return xr.open_zarr(file, consolidated=False, chunks=None)
    return xr.load_dataset(file, engine="h5netcdf")
