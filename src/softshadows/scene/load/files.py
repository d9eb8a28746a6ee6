"""The only place where a scene file's bytes, and the files it names, are opened.

A file named inside another one must lie in the folder of that other one (or deeper), after links are followed; nothing
is ever fetched from a network.
"""

from __future__ import annotations

import base64
import binascii
import os
import re
import stat
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote_to_bytes

from softshadows.errors import SceneError

MAX_FILE_BYTES = 4 * 2**30
"""Largest file that is opened; a GLB file cannot be larger."""


def read_scene_file(path: Path) -> bytes:
    """All bytes of the file the user named. Raises SceneError where it is missing, a folder, a device or unreadable."""
    try:
        return _read_regular_file(path)
    except FileNotFoundError:
        raise SceneError("there is no such file", code="FILE_MISSING", file=path) from None
    except (OSError, ValueError) as error:
        raise SceneError(f"cannot be read: {_reason(error)}", code="FILE_UNREADABLE", file=path) from None


def _read_regular_file(path: Path) -> bytes:
    # Without O_NONBLOCK, opening a named pipe would wait for ever for a writer.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError("it is not a regular file")
        if status.st_size > MAX_FILE_BYTES:
            raise OSError(f"{status.st_size} bytes exceed the limit of {MAX_FILE_BYTES}")
        return file.read()


def _reason(error: Exception) -> str:
    return (isinstance(error, OSError) and error.strerror) or str(error)


@dataclass
class Folder:
    """The folder of `scene_file`, from which the files that it names are read, each once."""

    scene_file: Path
    _cache: dict[Path, bytes] = field(default_factory=dict)

    @property
    def bytes_read(self) -> int:
        """Bytes of the separate files read so far."""
        return sum(len(data) for data in self._cache.values())

    def read(self, uri: str, pointer: str | None, missing_code: str) -> bytes:
        """The bytes behind a glTF `uri`: a data URI or a percent-encoded path relative to the scene file.

        Raises SceneError: URI_SCHEME for any other scheme, URI_OUTSIDE_FOLDER for a path that leaves the folder,
        INVALID_URI for what is not a URI, `missing_code` for a file that cannot be read.
        """
        if uri[:5].lower() == "data:":
            return self._decode_data_uri(uri, pointer)
        try:
            name = unquote_to_bytes(uri.encode("utf-8")).decode("utf-8")
        except UnicodeError:
            raise self._error("INVALID_URI", "the URI is not UTF-8 text", pointer) from None
        return self.read_path(name, pointer, missing_code)

    def read_path(self, name: str, pointer: str | None, missing_code: str) -> bytes:
        """The bytes of the file `name`, a path relative to the scene file. Raises as `read`."""
        path = self._contained(name, pointer)
        if path not in self._cache:
            try:
                self._cache[path] = _read_regular_file(path)
            except (OSError, ValueError) as error:
                raise self._error(missing_code, f"cannot read {name[:200]!r}: {_reason(error)}", pointer) from None
        return self._cache[path]

    def _contained(self, name: str, pointer: str | None) -> Path:
        if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:", name):
            message = f"only data URIs and paths relative to the scene file are read, got {name[:60]!r}"
            raise self._error("URI_SCHEME", message, pointer)
        # A backslash and a colon separate folders and drives on Windows; refusing them everywhere keeps scenes
        # portable.
        if not name or "\\" in name or ":" in name or "\0" in name or name.startswith("/") or ".." in name.split("/"):
            message = f"the path must lie in the scene file's folder, got {name[:60]!r}"
            raise self._error("URI_OUTSIDE_FOLDER", message, pointer)
        try:
            folder = self.scene_file.parent.resolve()
            path = (folder / name).resolve()
        except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name that is too long
            raise self._error("INVALID_URI", f"cannot follow {name[:60]!r}: {_reason(error)}", pointer) from None
        if not path.is_relative_to(folder):
            raise self._error(
                "URI_OUTSIDE_FOLDER", f"{name[:60]!r} links to a place outside the scene file's folder", pointer
            )
        return path

    def _decode_data_uri(self, uri: str, pointer: str | None) -> bytes:
        header, comma, body = uri.partition(",")
        if not comma:
            raise self._error("INVALID_URI", "the data URI has no comma", pointer)
        data = unquote_to_bytes(body.encode("utf-8", "surrogatepass"))
        if not header.lower().endswith(";base64"):
            return data
        try:
            return base64.b64decode(data, validate=True)
        except binascii.Error as error:
            raise self._error("INVALID_URI", f"the data URI is not base64: {error}", pointer) from None

    def _error(self, code: str, message: str, pointer: str | None) -> SceneError:
        return SceneError(message, code=code, file=self.scene_file, pointer=pointer)
