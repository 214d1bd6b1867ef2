"""Opens the dataset of a campaign."""

from pathlib import Path

import xarray as xr


def open_sweep(path: Path) -> xr.Dataset:
    """The dataset of a campaign's folder, or of its file `sweep.nc` or `sweep.zarr`.

    That of a large one is read as it is used. Raises FileNotFoundError where there is none.
    """
    zarr_path, file = path / "sweep.zarr", path / "sweep.nc"
    if path.suffix == ".zarr" or (path.suffix != ".nc" and zarr_path.is_dir()):
        return xr.open_zarr(path if path.suffix == ".zarr" else zarr_path, consolidated=False, chunks=None)
    return xr.load_dataset(path if path.suffix == ".nc" else file, engine="h5netcdf")
