"""The store of finished models and of the parts of unfinished ones, for the next run.

An entry is a file KEY.nc (NetCDF). KEY is derived from everything that determines the result: the request,
this code, the versions of its libraries. Each file ends with the SHA-256 digest of its name and content:
damaged, half-written and exchanged files are recognised, and their content is computed again. The location is
a folder, or a URL of any kind that fsspec knows (memory://, s3://). Several processes may use one store: a
file is written under a temporary name and then moved.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import TypeVar
from uuid import uuid4

import numpy as np

from femic.cache.digests import code_digest
from femic.cache.files import compact_netcdf, read_netcdf
from femic.lazy import lazy_imports
from geometries.arrays import Array

with lazy_imports():
    import fsspec
    import joblib
    import xarray as xr

Arrays = Mapping[str, Array]
Content = TypeVar("Content")

log = logging.getLogger(__name__)

DIGEST_SIZE = 32  # bytes of the digest at the end of a file
CODE_FOLDER = re.compile("[0-9a-f]{12}")  # name of the folder of a version of the code


@dataclass
class Store:
    """A store at a location; without a location nothing is stored."""

    location: str | Path | None = None
    problem: str = field(default="", init=False)  # why nothing more can be written

    @property
    def writable(self) -> bool:
        """Whether everything so far could be stored."""
        return not self.problem

    def key(self, kind: str, *request: object) -> str:
        """Return the key of the entry of a request."""
        return f"{kind}-{joblib.hash((code_digest(), kind, *request))}"

    def get(self, key: str) -> xr.Dataset | None:
        """Return the entry of a key, None where there is no undamaged one."""
        return self._read(f"{key}.nc", lambda content: read_netcdf(content.getvalue()))

    def put(self, key: str, entry: xr.Dataset) -> None:
        """Store an entry, and remove its parts, which are no longer needed."""
        self._write(f"{key}.nc", lambda: compact_netcdf(entry))
        self._remove(f"{key}.parts")

    def part(self, key: str, name: str) -> Arrays | None:
        """Return the arrays of a part of an unfinished entry, None where there is no undamaged one."""
        return self._read(f"{key}.parts/{name}.npz", lambda content: dict(np.load(content)))

    def part_names(self, key: str) -> list[str]:
        """Return the names of the stored parts of a key."""
        if self.location is None:
            return []
        try:
            self._fs.invalidate_cache(self._path(f"{key}.parts"))
            paths = self._fs.ls(self._path(f"{key}.parts"), detail=False)
        except FileNotFoundError:
            return []
        return sorted(Path(path).stem for path in paths if str(path).endswith(".npz"))

    def put_part(self, key: str, name: str, values: Arrays) -> None:
        """Store a part until the entry is finished."""
        buffer = BytesIO()
        np.savez(buffer, allow_pickle=False, **values)
        self._write(f"{key}.parts/{name}.npz", buffer.getvalue)

    def remove_other_code(self) -> None:
        """Remove the entries of other versions of the code, and nothing else."""
        if self.location is None or not self._fs.exists(self._root):
            return
        for path in self._fs.ls(self._root, detail=False):
            name = Path(path).name
            if CODE_FOLDER.fullmatch(name) and name != code_digest():
                self._fs.rm(path, recursive=True)

    @property
    def _fs(self) -> fsspec.AbstractFileSystem:
        """The file system of the location."""
        return fsspec.url_to_fs(str(self.location))[0]

    @property
    def _root(self) -> str:
        """The path of the location in its file system."""
        return str(fsspec.url_to_fs(str(self.location))[1]).rstrip("/")

    def _path(self, name: str) -> str:
        """The path of a file of this version of the code."""
        return f"{self._root}/{code_digest()}/{name}"

    def _read(self, name: str, parse: Callable[[BytesIO], Content]) -> Content | None:
        """Return the content of an undamaged file of this name, None where there is none."""
        if self.location is None:
            return None
        path = self._path(name)
        try:
            stored = bytes(self._fs.cat_file(path))
        except FileNotFoundError:
            return None
        except OSError as error:  # a folder, a place below a file, or nothing that may be read
            log.warning(f"{path}: {error.strerror or error}; it is computed again")
            return None
        content, digest = stored[:-DIGEST_SIZE], stored[-DIGEST_SIZE:]
        if digest != _digest(name, content):
            log.warning(f"{path}: damaged, or a different entry; it will be computed again")
            return None
        try:
            return parse(BytesIO(content))
        except Exception as error:  # each library has its own
            log.warning(f"{path}: cannot be read ({error}); it is computed again")
            return None

    def _write(self, name: str, content: Callable[[], bytes]) -> None:
        """Write under a temporary name, then move: no process sees a half-written file."""
        if self.location is None or not self.writable:
            return
        data, path = content(), self._path(name)
        temporary = f"{path}.{uuid4().hex}"
        try:
            folder = path.rpartition("/")[0]
            if "file" in self._fs.protocol:  # others do not tell files from folders
                if self._fs.isfile(folder):  # in the place of the folder of parts
                    self._fs.rm(folder)
                if self._fs.isdir(path):  # in the place of an entry
                    self._fs.rm(path, recursive=True)
            self._fs.makedirs(folder, exist_ok=True)
            self._fs.pipe_file(temporary, data + _digest(name, data))
            self._fs.mv(temporary, path)
        except OSError as error:
            self.problem = str(error) or type(error).__name__
            log.warning(f"store {self.location}: {error}; femic continues without storing further models")
            self._remove(f"{name}{temporary.removeprefix(path)}")

    def _remove(self, name: str) -> None:
        """Remove a file or folder of this version of the code, if it exists; failures are only logged."""
        if self.location is None:
            return
        try:
            self._fs.rm(self._path(name), recursive=True)
        except OSError as error:  # there is none, or another process is writing there
            log.debug(f"{name}: {error}")


def _digest(name: str, content: bytes) -> bytes:
    """Return the digest of an entry of this version of the code, which includes its name."""
    return sha256(f"{code_digest()}/{name}\n".encode() + content).digest()
