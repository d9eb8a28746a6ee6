"""The two compressed geometry formats of glTF, decoded by optional native libraries.

KHR_draco_mesh_compression needs DracoPy (`pip install softshadows[draco]`), EXT_meshopt_compression needs meshoptimizer
(`pip install softshadows[meshopt]`). What a stream declares is compared with the glTF file before the decoder runs, so
that a small stream cannot make the decoder allocate gigabytes.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from types import ModuleType

import numpy as np

from softshadows.scene.load.checked_json import Item

DRACO = "KHR_draco_mesh_compression"
DRACO_HEADER_BYTES = 11
SEQUENTIAL, EDGEBREAKER, HAS_METADATA = 0, 1, 0x8000
"""Draco's two encodings of triangles, and the header flag that says metadata follows."""


def _decoder(module: str, extra: str, what: str, item: Item) -> ModuleType:
    try:
        return importlib.import_module(module)
    except (ImportError, OSError):  # OSError: a native library that does not load
        message = f"this file is compressed with {what}; its decoder is optional: pip install softshadows[{extra}]"
        raise item.error("DECODER_MISSING", message) from None


def draco_available() -> bool:
    """True where Draco streams can be decoded."""
    return importlib.util.find_spec("DracoPy") is not None


def decode_meshopt(data: memoryview, length: int, item: Item) -> memoryview:
    """The `length` bytes that `data` decodes to, by the EXT_meshopt_compression object `item`. Raises SceneError."""
    count, stride = item.integer("count", low=1), item.integer("byteStride", low=1, high=256)
    mode = item.string("mode", among=("ATTRIBUTES", "TRIANGLES", "INDICES"))
    filter_name = item.string("filter", "NONE", among=("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"))
    if count * stride != length:
        message = f"{count} elements of {stride} bytes are not the buffer view's {length} bytes"
        raise item.error("MESHOPT_LENGTH_MISMATCH", message, "count")
    legal_strides = range(4, 257, 4) if mode == "ATTRIBUTES" else (2, 4)
    if stride not in legal_strides:
        raise item.error("VALUE_NOT_IN_LIST", f"mode {mode} cannot have elements of {stride} bytes", "byteStride")
    _check_filter(filter_name, mode, stride, item)

    meshopt = _decoder("meshoptimizer", "meshopt", "EXT_meshopt_compression", item)
    source = np.frombuffer(data, np.uint8)
    try:
        if mode == "ATTRIBUTES":
            decoded = meshopt.decode_vertex_buffer(count, stride, source, dtype=np.dtype(f"V{stride}"))
            return memoryview(_filters(meshopt)[filter_name](decoded, count, stride).tobytes())
        decode = meshopt.decode_index_buffer if mode == "TRIANGLES" else meshopt.decode_index_sequence
        indices = decode(count, 4, source)  # the library's two-byte output is laid out wrongly
        return memoryview(indices.astype(f"<u{stride}").tobytes())
    except (RuntimeError, ValueError) as error:
        raise item.error("MESHOPT_INVALID_STREAM", f"the compressed data is corrupt: {error}") from None


def _check_filter(filter_name: str, mode: str, stride: int, item: Item) -> None:
    legal_strides = {"OCTAHEDRAL": (4, 8), "QUATERNION": (8,)}
    if filter_name != "NONE" and (mode != "ATTRIBUTES" or stride not in legal_strides.get(filter_name, (stride,))):
        message = f"filter {filter_name} does not apply to mode {mode} with elements of {stride} bytes"
        raise item.error("VALUE_NOT_IN_LIST", message, "filter")


def _filters(meshopt: ModuleType) -> dict[str, Callable[[np.ndarray, int, int], np.ndarray]]:
    return {
        "NONE": lambda values, count, stride: values,
        "OCTAHEDRAL": meshopt.decode_filter_oct,
        "QUATERNION": meshopt.decode_filter_quat,
        "EXPONENTIAL": meshopt.decode_filter_exp,
    }


def decode_draco(
    data: memoryview, item: Item, index_count: int, vertex_count: int
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Triangles and attributes of a Draco stream, which must be as many as the glTF accessors declare.

    Returns indices (index_count,) uint32 and, by glTF semantic, arrays (vertex_count, components) in the stream's own
    type.
    Raises SceneError.
    """
    faces, vertices = _declared_counts(bytes(data), item)
    if 3 * faces != index_count or (vertices is not None and vertices != vertex_count):
        message = f"the stream holds {faces} triangles, the accessors declare {index_count} indices"
        raise item.error("DRACO_COUNT_MISMATCH", message)
    draco = _decoder("DracoPy", "draco", DRACO, item)
    attribute_ids = item.required_object("attributes")
    try:
        mesh = draco.decode(bytes(data))
    except Exception as error:  # DracoPy raises its own classes, derived from Exception itself
        raise item.error("DRACO_INVALID_STREAM", f"the compressed data is corrupt: {error}") from None
    by_id = {attribute["unique_id"]: np.asarray(attribute["data"]) for attribute in mesh.attributes}
    attributes = {}
    for semantic in attribute_ids.data:
        values = by_id.get(attribute_ids.integer(semantic))
        if values is None or values.ndim != 2 or len(values) != vertex_count:
            message = f"the stream has no attribute {semantic} for {vertex_count} vertices"
            raise attribute_ids.error("DRACO_COUNT_MISMATCH", message, semantic)
        attributes[semantic] = values
    indices = np.asarray(mesh.faces, np.uint32).reshape(-1)
    if len(indices) != index_count:
        raise item.error("DRACO_COUNT_MISMATCH", f"the stream holds {len(indices)} indices, expected {index_count}")
    return indices, attributes


def _declared_counts(data: bytes, item: Item) -> tuple[int, int | None]:
    """Faces and, where the header says it, vertices of a Draco 2.2 triangle mesh, read without decoding it."""
    try:
        if data[:5] != b"DRACO" or data[5:7] != b"\x02\x02" or data[7] != 1 or data[8] not in (SEQUENTIAL, EDGEBREAKER):
            raise item.error("DRACO_INVALID_STREAM", "expected a Draco triangle mesh of bitstream version 2.2")
        offset = DRACO_HEADER_BYTES
        if int.from_bytes(data[9:11], "little") & HAS_METADATA:
            offset = _skip_draco_metadata(data, offset)
        if data[8] == SEQUENTIAL:
            faces, offset = _varint(data, offset)
            return faces, _varint(data, offset)[0]
        _, offset = _varint(data, offset + 1)  # after the traversal type: vertices before seams are split
        return _varint(data, offset)[0], None
    except IndexError:
        raise item.error("DRACO_INVALID_STREAM", "the compressed data ends too early") from None


def _skip_draco_metadata(data: bytes, offset: int) -> int:
    """The offset behind the metadata: per attribute an id and a tree of named entries, then the mesh's tree."""
    attribute_trees, offset = _varint(data, offset)
    for tree in range(min(attribute_trees, len(data)) + 1):
        if tree < attribute_trees:
            _, offset = _varint(data, offset)
        open_nodes, is_root = 1, True
        while open_nodes:
            if not is_root:
                offset += 1 + data[offset]  # its name
            entries, offset = _varint(data, offset)
            for _ in range(min(entries, len(data))):
                offset += 1 + data[offset]
                size, offset = _varint(data, offset)
                offset += size
            children, offset = _varint(data, offset)
            open_nodes, is_root = open_nodes + children - 1, False
    return offset


def _varint(data: bytes, offset: int) -> tuple[int, int]:
    """An unsigned LEB128 number and the offset behind it. Raises IndexError at the end of `data`."""
    value = shift = 0
    while True:
        byte = data[offset]
        value, shift, offset = value | (byte & 0x7F) << shift, shift + 7, offset + 1
        if byte < 0x80 or shift > 63:
            return value, offset
