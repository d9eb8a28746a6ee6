"""A glTF file as bytes: the GLB chunks or the JSON text, its buffers and its buffer views."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from pathlib import Path

from softshadows.errors import SceneError
from softshadows.scene.load.budget import Budget
from softshadows.scene.load.checked_json import Item, parse_json
from softshadows.scene.load.files import Folder, read_scene_file
from softshadows.scene.load.gltf_compression import decode_meshopt

GLB_MAGIC, JSON_CHUNK, BIN_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
MESHOPT = "EXT_meshopt_compression"

# Vertex data decodes to at most 4 bytes per byte (8-bit to float), compressed data to a few tens.
GEOMETRY_FLOOR_MEBIBYTES, GEOMETRY_FACTOR = 128, 24


@dataclass(frozen=True)
class BufferView:
    """`length` bytes from `offset` of buffer number `buffer`; `stride` 0 means tightly packed."""

    item: Item
    buffer: int
    offset: int
    length: int
    stride: int


@dataclass
class Asset:
    """An opened glTF file: its JSON, the bytes it refers to, what it may still decode, and what was ignored in it."""

    root: Item
    folder: Folder
    buffers: list[memoryview | None]
    views: list[BufferView]
    geometry_budget: Budget
    warnings: list[str] = field(default_factory=list)
    _decoded: dict[int, memoryview] = field(default_factory=dict)

    @property
    def file(self) -> Path:
        return self.root.file

    def warn(self, message: str) -> None:
        """Note, once, something in the file that is ignored or replaced."""
        if message not in self.warnings:
            self.warnings.append(message)

    def view_bytes(self, index: int) -> memoryview:
        """The bytes of buffer view `index`, decompressed."""
        view = self.views[index]
        compression = view.item.extension(MESHOPT)
        if compression is None:
            return self._buffer(view.buffer, view.item)[view.offset : view.offset + view.length]
        if index not in self._decoded:
            self._decoded[index] = self._decompress(view, compression)
        return self._decoded[index]

    def _decompress(self, view: BufferView, compression: Item) -> memoryview:
        buffer = compression.index("buffer", len(self.buffers), "buffer")
        offset, length = compression.integer("byteOffset", 0), compression.integer("byteLength", low=1)
        data = self._buffer(buffer, compression)
        if offset + length > len(data):
            message = f"bytes {offset}..{offset + length} lie outside the buffer of {len(data)} bytes"
            raise compression.error("BUFFER_VIEW_TOO_LONG", message, "byteLength")
        if not self.geometry_budget.spend(view.length):
            raise view.item.error(
                "FILE_TOO_BIG", f"decodes to {view.length} bytes, out of proportion to the file", "byteLength"
            )
        return decode_meshopt(data[offset : offset + length], view.length, compression)

    def _buffer(self, index: int, user: Item) -> memoryview:
        data = self.buffers[index]
        if data is None:
            raise user.error("BUFFER_MISSING", f"buffer {index} has neither a uri nor a GLB chunk", "buffer")
        return data


def open_asset(path: Path) -> Asset:
    """Read `path` (.gltf or .glb), check its version and its buffer views. Raises SceneError."""
    data = read_scene_file(path)
    binary: memoryview | None = None
    if data[:4] == GLB_MAGIC or path.suffix.lower() == ".glb":
        text, binary = _split_glb(data, path)
    else:
        text = data
    root = parse_json(text, path)
    _check_version(root)
    folder = Folder(path)
    buffers = _read_buffers(root, folder, binary)
    size = len(data) + folder.bytes_read
    budget = Budget.for_file(size, floor_mebibytes=GEOMETRY_FLOOR_MEBIBYTES, factor=GEOMETRY_FACTOR)
    return Asset(root, folder, buffers, _buffer_views(root), budget)


def _read_buffers(root: Item, folder: Folder, binary: memoryview | None) -> list[memoryview | None]:
    """The bytes of every buffer; None for one that has none, as the fallback of compressed data may."""
    buffers: list[memoryview | None] = []
    for index, buffer in enumerate(root.objects("buffers")):
        length = buffer.integer("byteLength", low=1)
        data = binary if index == 0 else None
        if "uri" in buffer:
            data = memoryview(folder.read(buffer.string("uri"), f"{buffer.pointer}/uri", missing_code="BUFFER_MISSING"))
        if data is not None and len(data) < length:
            message = f"the buffer declares {length} bytes but has {len(data)}"
            raise buffer.error("BUFFER_BYTE_LENGTH_MISMATCH", message, "byteLength")
        buffers.append(None if data is None else data[:length])
    return buffers


def _split_glb(data: bytes, path: Path) -> tuple[bytes, memoryview | None]:
    """The JSON chunk and the BIN chunk (None where absent) of GLB bytes."""

    def error(code: str, message: str) -> SceneError:
        return SceneError(message, code=code, file=path)

    if len(data) < 12:
        raise error("GLB_UNEXPECTED_END_OF_HEADER", f"a GLB header has 12 bytes, the file has {len(data)}")
    magic, version, length = struct.unpack_from("<4sII", data)
    if magic != GLB_MAGIC:
        raise error("GLB_INVALID_MAGIC", f"a GLB file starts with {GLB_MAGIC!r}, this one with {magic!r}")
    if version != 2:
        raise error("GLB_INVALID_VERSION", f"GLB version 2 is supported, got {version}")
    if length != len(data):
        raise error("GLB_LENGTH_MISMATCH", f"the GLB header declares {length} bytes, the file has {len(data)}")

    chunks: dict[int, memoryview] = {}
    offset, position = 12, 0
    while offset < length:
        if length - offset < 8:
            raise error("GLB_UNEXPECTED_END_OF_CHUNK_HEADER", f"a chunk header has 8 bytes, {length - offset} are left")
        size, kind = struct.unpack_from("<II", data, offset)
        offset += 8
        if size % 4:
            raise error("GLB_CHUNK_LENGTH_UNALIGNED", f"chunk lengths are multiples of 4, got {size}")
        if size > length - offset:
            raise error(
                "GLB_UNEXPECTED_END_OF_CHUNK_DATA", f"a chunk declares {size} bytes, {length - offset} are left"
            )
        if position == 0 and kind != JSON_CHUNK:
            raise error("GLB_UNEXPECTED_FIRST_CHUNK", f"the first chunk must be JSON, got type {kind:#010x}")
        if kind in (JSON_CHUNK, BIN_CHUNK):
            if kind in chunks:
                raise error("GLB_DUPLICATE_CHUNK", f"chunk type {kind:#010x} occurs twice")
            if kind == BIN_CHUNK and position != 1:
                raise error("GLB_UNEXPECTED_BIN_CHUNK", "the BIN chunk must be the second chunk")
            chunks[kind] = memoryview(data)[offset : offset + size]
        offset, position = offset + size, position + 1
    if JSON_CHUNK not in chunks:
        raise error("GLB_UNEXPECTED_FIRST_CHUNK", "the file has no JSON chunk")
    return bytes(chunks[JSON_CHUNK]), chunks.get(BIN_CHUNK)


def _check_version(root: Item) -> None:
    asset = root.required_object("asset")
    for key in ("version", "minVersion"):
        version = asset.string(key, None if key == "version" else "2.0")
        if not re.fullmatch(r"[0-9]{1,9}\.[0-9]{1,9}", version):
            raise asset.error("PATTERN_MISMATCH", f"expected a version such as 2.0, got {version[:60]!r}", key)
        major, minor = (int(part) for part in version.split("."))
        if major != 2:
            raise asset.error("UNKNOWN_ASSET_MAJOR_VERSION", f"glTF 2.0 is supported, got {version}", key)
        if minor > 0 and key == "minVersion":  # a later `version` alone promises to be readable as 2.0
            raise asset.error("UNKNOWN_ASSET_MINOR_VERSION", f"glTF 2.0 is supported, the file needs {version}", key)


def _buffer_views(root: Item) -> list[BufferView]:
    lengths = [buffer.integer("byteLength", low=1) for buffer in root.objects("buffers")]
    views = []
    for item in root.objects("bufferViews"):
        buffer = item.index("buffer", len(lengths), "buffer")
        offset, length = item.integer("byteOffset", 0), item.integer("byteLength", low=1)
        stride = item.integer("byteStride", low=4, high=252) if "byteStride" in item else 0
        if offset + length > lengths[buffer]:
            message = f"bytes {offset}..{offset + length} lie outside the buffer of {lengths[buffer]} bytes"
            raise item.error("BUFFER_VIEW_TOO_LONG", message, "byteLength")
        views.append(BufferView(item, buffer, offset, length, stride))
    return views
