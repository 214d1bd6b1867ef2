"""Finished work, kept where the next run finds it: models, and the parts of models that are not finished.

An entry is a file KEY-HASH.nc (NetCDF). KEY comes from all that determines the result: the request, this
code, the versions of its libraries. HASH comes from the content: damaged and half-written files are
noticed and computed again. The location is a folder, or any other that fsspec knows (memory://, s3://).
Several processes may use one store: nothing is ever changed in place.
"""

import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any
from uuid import uuid4

import joblib
import numpy as np
import xarray as xr
from fsspec import AbstractFileSystem
from fsspec.core import url_to_fs

from femic.work.provenance import code_digest
from geometries.arrays import Array

Arrays = Mapping[str, Array]

log = logging.getLogger(__name__)

LOOKS = 100  # at a file that other processes keep replacing
HASH = 16  # letters of the content's hash in a file's name
CODE = re.compile("[0-9a-f]{12}")  # folders of one version of the code each


@dataclass
class Store:
    """A store; without a location nothing is kept."""

    location: str | Path | None = None
    writable: bool = field(default=True, init=False)  # until writing fails

    def key(self, kind: str, *request: object) -> str:
        """What an entry is found by."""
        return f"{kind}-{joblib.hash((code_digest(), kind, *request))}"

    def get(self, key: str) -> xr.Dataset | None:
        """The entry of a key, None where there is none that is whole."""
        content = self._read(key, ".nc")
        return None if content is None else xr.load_dataset(BytesIO(content), engine="h5netcdf")

    def put(self, key: str, entry: xr.Dataset) -> None:
        """Keep an entry; its parts are not needed any more."""
        self._write(key, ".nc", lambda: bytes(entry.to_netcdf(engine="h5netcdf")))
        self._remove(f"{key}.parts", recursive=True)

    def part(self, key: str, name: str) -> Arrays | None:
        """A part of an entry that was not finished: its arrays by name."""
        content = self._read(f"{key}.parts/{name}", ".npz")
        return None if content is None else dict(np.load(BytesIO(content)))

    def put_part(self, key: str, name: str, values: Arrays) -> None:
        """Keep a part until the entry is finished."""
        self._write(f"{key}.parts/{name}", ".npz", lambda: _npz(values))

    def forget_other_code(self) -> None:
        """Remove what other versions of the code have kept, and nothing else."""
        if self.location is None or not self._has(self._root):
            return
        for path in self._fs.ls(self._root, detail=False):
            name = Path(path).name
            if CODE.fullmatch(name) and name != code_digest():
                self._fs.rm(path, recursive=True)

    @property
    def _fs(self) -> AbstractFileSystem:
        return url_to_fs(str(self.location))[0]

    @property
    def _root(self) -> str:
        return str(url_to_fs(str(self.location))[1]).rstrip("/")

    def _path(self, name: str) -> str:
        return f"{self._root}/{code_digest()}/{name}"

    def _has(self, path: str) -> bool:
        self._fs.invalidate_cache(path)
        return bool(self._fs.exists(path))

    def _versions(self, name: str, ending: str) -> list[str]:
        """Files of one name, whatever their content."""
        start = self._path(name)
        folder, _, stem = start.rpartition("/")
        if not self._has(folder):
            return []
        pattern = re.compile(re.escape(stem) + f"-[0-9a-f]{{{HASH}}}" + re.escape(ending))
        return sorted(p for p in self._fs.ls(folder, detail=False) if pattern.fullmatch(p.rpartition("/")[2]))

    def _read(self, name: str, ending: str) -> bytes | None:
        """The content of a file that is whole."""
        if self.location is None:
            return None
        for _ in range(LOOKS):
            replaced = False
            for path in self._versions(name, ending):
                try:
                    content = self._fs.cat_file(path)
                except FileNotFoundError:  # another process has just replaced it
                    replaced = True
                    continue
                if path.endswith(f"-{_hash(content)}{ending}"):
                    return bytes(content)
                log.warning(f"{path}: damaged; it is computed again")
            if not replaced:
                return None
        return None

    def _write(self, name: str, ending: str, content: Any) -> None:
        """Write under another name, then move: nobody sees half of it."""
        if self.location is None or not self.writable:
            return
        data = content()
        path = self._path(f"{name}-{_hash(data)}{ending}")
        temporary = f"{path}.{uuid4().hex}"
        try:
            self._fs.makedirs(path.rpartition("/")[0], exist_ok=True)
            self._fs.pipe_file(temporary, data)
            others = self._versions(name, ending)
            self._fs.mv(temporary, path)
        except OSError as error:
            self.writable = False
            log.warning(
                f"store {self.location}: {error}: going on without keeping what is finished from here"
            )
            self._remove_file(temporary)
            return
        for other in others:
            if other != path:
                self._remove_file(other)

    def _remove_file(self, path: str) -> None:
        try:
            self._fs.rm_file(path)
        except OSError as error:
            log.debug(f"{path}: {error}")

    def _remove(self, name: str, *, recursive: bool) -> None:
        if self.location is None or not self.writable:
            return
        try:
            if self._has(self._path(name)):
                self._fs.rm(self._path(name), recursive=recursive)
        except OSError as error:  # another process is writing there
            log.debug(f"{name}: {error}")


def _hash(content: bytes) -> str:
    return sha256(content).hexdigest()[:HASH]


def _npz(values: Arrays) -> bytes:
    buffer = BytesIO()
    np.savez(buffer, allow_pickle=False, **values)
    return buffer.getvalue()
