"""glTF accessors as numpy arrays: interleaved, sparse, normalized and quantized ones included."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from softshadows.scene.load.checked_json import Item
from softshadows.scene.load.gltf_container import Asset

COMPONENT_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
SHAPES = {
    "SCALAR": (1, 1),
    "VEC2": (1, 2),
    "VEC3": (1, 3),
    "VEC4": (1, 4),
    "MAT2": (2, 2),
    "MAT3": (3, 3),
    "MAT4": (4, 4),
}
"""Columns and rows of each type."""


@dataclass(frozen=True)
class Accessor:
    """What the JSON says of `count` elements of `columns` × `rows` components; checked against its buffer view."""

    item: Item
    count: int
    dtype: np.dtype
    columns: int
    rows: int
    normalized: bool
    view: int | None
    offset: int

    @property
    def components(self) -> int:
        return self.columns * self.rows

    @property
    def element_bytes(self) -> int:
        """Bytes of one element; the columns of a matrix start at multiples of four bytes."""
        column = self.rows * self.dtype.itemsize
        return column if self.columns == 1 else self.columns * (column + -column % 4)


@dataclass
class Accessors:
    """The accessors of an asset, each decoded once."""

    asset: Asset
    table: list[Accessor]
    _raw: dict[int, np.ndarray] = field(default_factory=dict)
    _floats: dict[int, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, asset: Asset) -> Accessors:
        return cls(asset, [_parse(item, asset) for item in asset.root.objects("accessors")])

    def __len__(self) -> int:
        return len(self.table)

    def floats(self, index: int) -> np.ndarray:
        """Accessor `index` as (count, components) float32, finite; normalized integers in [0, 1] or [−1, 1]."""
        if index not in self._floats:
            accessor = self.table[index]
            self._floats[index] = finite_floats(self.raw(index), accessor)
        return self._floats[index]

    def raw(self, index: int) -> np.ndarray:
        """Accessor `index` as (count, components) in its own component type; a view of the buffer where it can be."""
        if index not in self._raw:
            self._raw[index] = self._decode(self.table[index])
        return self._raw[index]

    def _decode(self, accessor: Accessor) -> np.ndarray:
        # Charged as the float32 copy that callers will make of it.
        if not self.asset.geometry_budget.spend(accessor.count * accessor.components * 4):
            message = f"{accessor.count} elements decode to more memory than a file of this size may ask for"
            raise accessor.item.error("FILE_TOO_BIG", message, "count")
        if accessor.view is None:
            values = np.zeros((accessor.count, accessor.components), accessor.dtype)
        else:
            values = self._strided(accessor.view, accessor.offset, accessor)
        sparse = accessor.item.object("sparse")
        return values if sparse is None else self._with_substitutes(values, sparse, accessor)

    def _strided(self, view: int, offset: int, accessor: Accessor) -> np.ndarray:
        stride = self.asset.views[view].stride or accessor.element_bytes
        return np.ndarray(
            (accessor.count, accessor.components),
            accessor.dtype,
            buffer=self.asset.view_bytes(view),
            offset=offset,
            strides=(stride, accessor.dtype.itemsize),
        )

    def _with_substitutes(self, values: np.ndarray, sparse: Item, accessor: Accessor) -> np.ndarray:
        """A copy of `values` with the elements that `sparse` names replaced."""
        count = sparse.integer("count", low=1, high=accessor.count)
        where = sparse.required_object("indices")
        dtype = np.dtype(COMPONENT_TYPES[_component_type(where, unsigned=True)])
        indices = self._packed(where, count, dtype, 1)[:, 0].astype(np.int64)
        if indices.max() >= accessor.count:
            message = f"index {indices.max()} is outside the accessor's {accessor.count} elements"
            raise where.error("ACCESSOR_SPARSE_INDEX_OOB", message)
        if (np.diff(indices) <= 0).any():
            raise where.error("ACCESSOR_SPARSE_INDICES_NON_INCREASING", "sparse indices must increase strictly")
        result = values.copy()
        result[indices] = self._packed(sparse.required_object("values"), count, accessor.dtype, accessor.components)
        return result

    def _packed(self, item: Item, count: int, dtype: np.dtype, components: int) -> np.ndarray:
        view = item.index("bufferView", len(self.asset.views), "buffer view")
        offset, size = item.integer("byteOffset", 0), count * components * dtype.itemsize
        length = self.asset.views[view].length
        if offset + size > length:
            raise item.error(
                "ACCESSOR_TOO_LONG", f"bytes {offset}..{offset + size} lie outside the buffer view of {length}"
            )
        return np.ndarray((count, components), dtype, buffer=self.asset.view_bytes(view), offset=offset)


def finite_floats(values: np.ndarray, accessor: Accessor) -> np.ndarray:
    """`values` of `accessor` as contiguous float32, normalized where it says so. Raises SceneError for NaN and Inf."""
    result = np.ascontiguousarray(values, np.float32)
    if values.dtype.kind == "f":
        if not np.isfinite(result).all():
            raise accessor.item.error("ACCESSOR_INVALID_FLOAT", "the data holds NaN or infinite values")
    elif accessor.normalized:
        result = np.maximum(result / np.float32(np.iinfo(values.dtype).max), np.float32(-1.0))
    return result


def _component_type(item: Item, *, unsigned: bool = False) -> int:
    legal = (5121, 5123, 5125) if unsigned else tuple(COMPONENT_TYPES)
    value = item.integer("componentType")
    if value not in legal:
        raise item.error(
            "VALUE_NOT_IN_LIST", f"expected one of {', '.join(map(str, legal))}, got {value}", "componentType"
        )
    return value


def _parse(item: Item, asset: Asset) -> Accessor:
    component_type = _component_type(item)
    columns, rows = SHAPES[item.string("type", among=tuple(SHAPES))]
    normalized = item.boolean("normalized")
    if normalized and component_type in (5125, 5126):
        raise item.error(
            "ACCESSOR_NORMALIZED_INVALID", "only 8-bit and 16-bit integers can be normalized", "normalized"
        )
    view = item.index("bufferView", len(asset.views), "buffer view") if "bufferView" in item else None
    if view is None and "byteOffset" in item:
        raise item.error("UNSATISFIED_DEPENDENCY", "byteOffset needs a bufferView", "byteOffset")
    accessor = Accessor(
        item=item,
        count=item.integer("count", low=1),
        dtype=np.dtype(COMPONENT_TYPES[component_type]),
        columns=columns,
        rows=rows,
        normalized=normalized,
        view=view,
        offset=item.integer("byteOffset", 0),
    )
    if view is not None:
        _check_extent(accessor, asset.views[view].length, asset.views[view].stride or accessor.element_bytes)
    return accessor


def _check_extent(accessor: Accessor, length: int, stride: int) -> None:
    if stride < accessor.element_bytes:
        message = f"elements of {accessor.element_bytes} bytes overlap at a stride of {stride}"
        raise accessor.item.error("ACCESSOR_SMALL_BYTESTRIDE", message)
    end = accessor.offset + stride * (accessor.count - 1) + accessor.element_bytes
    if end > length:
        message = f"{accessor.count} elements end at byte {end} of a buffer view of {length} bytes"
        raise accessor.item.error("ACCESSOR_TOO_LONG", message, "count")
