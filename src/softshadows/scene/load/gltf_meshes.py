"""glTF mesh primitives as Mesh objects: one per primitive, decoded once and shared by all nodes that place it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from softshadows.scene.load.accessors import Accessor, Accessors, finite_floats
from softshadows.scene.load.budget import Budget
from softshadows.scene.load.checked_json import Item
from softshadows.scene.load.gltf_compression import DRACO, decode_draco, draco_available
from softshadows.scene.load.gltf_container import Asset
from softshadows.scene.load.gltf_materials import Materials
from softshadows.scene.model import Mesh

TRIANGLES, STRIP, FAN = 4, 5, 6

ATTRIBUTES = {
    "POSITION": (3,),
    "NORMAL": (3,),
    "TEXCOORD_0": (2,),
    "TEXCOORD_1": (2,),
    "COLOR_0": (3, 4),
}
"""The attributes that are read, with their legal numbers of components."""


MESH_WORK_BYTES = 2**31
"""Bytes of vertices and triangles that all meshes together may refer to, however often they share them."""


@dataclass(frozen=True)
class _Geometry:
    """What Mesh takes from a primitive, but for its material; shared by primitives that name the same accessors."""

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None
    texcoords: np.ndarray | None
    colors: np.ndarray | None


@dataclass
class Meshes:
    """The meshes of an asset; `at` decodes."""

    asset: Asset
    accessors: Accessors
    materials: Materials
    items: list[Item]
    _decoded: dict[int, list[Mesh]] = field(default_factory=dict)
    _geometries: dict[tuple, _Geometry] = field(default_factory=dict)
    _work: Budget = field(default_factory=lambda: Budget(MESH_WORK_BYTES))

    @classmethod
    def of(cls, asset: Asset, accessors: Accessors, materials: Materials) -> Meshes:
        return cls(asset, accessors, materials, asset.root.objects("meshes"))

    def __len__(self) -> int:
        return len(self.items)

    def at(self, index: int) -> list[Mesh]:
        """One Mesh per primitive of triangles in glTF mesh `index`."""
        if index not in self._decoded:
            self._decoded[index] = self._decode(self.items[index])
        return self._decoded[index]

    def _decode(self, item: Item) -> list[Mesh]:
        name = item.string("name", "")
        primitives = item.objects("primitives")
        if not primitives:
            raise item.error("EMPTY_ENTITY", "a mesh needs at least one primitive", "primitives")
        meshes = []
        for primitive in primitives:
            if primitive.objects("targets"):
                self.asset.warn("morph targets are ignored: meshes keep their base shape")
            mode = primitive.integer("mode", TRIANGLES, high=6)
            attributes = primitive.required_object("attributes")
            if mode < TRIANGLES:
                self.asset.warn(f"mesh {name!r}: points and lines are skipped")
            elif "POSITION" not in attributes:
                self.asset.warn(f"mesh {name!r}: a primitive without positions is skipped")
            else:
                meshes.append(self._mesh(primitive, attributes, mode, name))
        return meshes

    def _mesh(self, primitive: Item, attributes: Item, mode: int, name: str) -> Mesh:
        used = {semantic: self._attribute(attributes, semantic) for semantic in ATTRIBUTES if semantic in attributes}
        indices, draco = self._index_accessor(primitive), primitive.extension(DRACO)
        key = (mode, indices, tuple(used.items()), None if draco is None else draco.pointer)
        if key not in self._geometries:
            self._geometries[key] = self._geometry(primitive, attributes, used, indices, mode, name)
        geometry = self._geometries[key]
        if not self._work.spend(geometry.positions.nbytes + geometry.triangles.nbytes):
            raise primitive.error("FILE_TOO_BIG", f"the meshes take more than {MESH_WORK_BYTES} bytes")
        return Mesh(
            positions=geometry.positions,
            triangles=geometry.triangles,
            normals=geometry.normals,
            texcoords=geometry.texcoords,
            colors=geometry.colors,
            material=self.materials.of_primitive(primitive),
            name=name,
        )

    def _geometry(
        self, primitive: Item, attributes: Item, used: dict[str, int], index_accessor: int | None, mode: int, name: str
    ) -> _Geometry:
        vertices, indices = self._vertices_and_indices(primitive, attributes, used, index_accessor)
        if mode == TRIANGLES and len(indices) % 3:
            self.asset.warn(f"mesh {name!r}: indices that do not fill a last triangle are dropped")
        if not self.asset.geometry_budget.spend(12 * len(indices) // (3 if mode == TRIANGLES else 1)):
            raise primitive.error("FILE_TOO_BIG", "the triangles take more memory than a file of this size may ask for")
        vertices, triangles = _used_only(vertices, _triangles(indices, mode))
        return _Geometry(
            positions=vertices["POSITION"],
            triangles=triangles.astype(np.uint32),
            normals=vertices.get("NORMAL"),
            texcoords=_texcoords(vertices),
            colors=_colors(vertices),
        )

    def _vertices_and_indices(
        self, primitive: Item, attributes: Item, used: dict[str, int], index_accessor: int | None
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """The read attributes (vertices, components) float32 by semantic, and the indices (n,) into them."""
        counts = {self.accessors.table[index].count for index in used.values()}
        if len(counts) != 1:
            message = f"all attributes need the same count, got {sorted(counts)}"
            raise attributes.error("MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", message)
        vertex_count = counts.pop()
        draco = primitive.extension(DRACO)
        if draco is not None and (draco_available() or self.accessors.table[used["POSITION"]].view is None):
            return self._decompress(draco, used, vertex_count, index_accessor)
        vertices = {semantic: self.accessors.floats(index) for semantic, index in used.items()}
        if index_accessor is None:
            return vertices, np.arange(vertex_count, dtype=np.uint32)
        indices = self.accessors.raw(index_accessor)[:, 0]
        _check_indices(indices, vertex_count, self.accessors.table[index_accessor].item)
        return vertices, indices

    def _attribute(self, attributes: Item, semantic: str) -> int:
        index = attributes.index(semantic, len(self.accessors), "accessor")
        accessor = self.accessors.table[index]
        if accessor.columns != 1 or accessor.rows not in ATTRIBUTES[semantic]:
            message = (
                f"{semantic} needs {' or '.join(map(str, ATTRIBUTES[semantic]))} components, got {accessor.components}"
            )
            raise attributes.error("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", message, semantic)
        if accessor.dtype == np.uint32:
            message = f"{semantic} cannot hold 32-bit integers"
            raise attributes.error("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", message, semantic)
        if semantic in ("NORMAL", "COLOR_0") and accessor.dtype.kind != "f" and not accessor.normalized:
            message = f"{semantic} needs floats or normalized integers"
            raise attributes.error("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", message, semantic)
        return index

    def _index_accessor(self, primitive: Item) -> int | None:
        if "indices" not in primitive:
            return None
        index = primitive.index("indices", len(self.accessors), "accessor")
        accessor = self.accessors.table[index]
        if accessor.components != 1 or accessor.dtype.kind != "u" or accessor.normalized:
            message = "indices need scalar unsigned integers that are not normalized"
            raise primitive.error("MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT", message, "indices")
        return index

    def _decompress(
        self, draco: Item, used: dict[str, int], vertex_count: int, index_accessor: int | None
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        if index_accessor is None:
            raise draco.error("UNSATISFIED_DEPENDENCY", "Draco compression needs indices")
        index_count = self.accessors.table[index_accessor].count
        table = self.accessors.table
        size = 4 * (index_count + vertex_count * sum(table[index].components for index in used.values()))
        if not self.asset.geometry_budget.spend(size):
            raise draco.error("FILE_TOO_BIG", f"decodes to {size} bytes, out of proportion to the file's size")
        view = draco.index("bufferView", len(self.asset.views), "buffer view")
        indices, streams = decode_draco(self.asset.view_bytes(view), draco, index_count, vertex_count)
        vertices = {}
        for semantic, index in used.items():
            if semantic in streams:
                vertices[semantic] = _like_accessor(streams[semantic], table[index])
            else:  # an attribute may stay uncompressed beside the stream
                vertices[semantic] = self.accessors.floats(index)
        _check_indices(indices, vertex_count, draco)
        return vertices, indices


def _like_accessor(values: np.ndarray, accessor: Accessor) -> np.ndarray:
    if values.shape[1] != accessor.components:
        message = f"the stream has {values.shape[1]} components, the accessor {accessor.components}"
        raise accessor.item.error("DRACO_COUNT_MISMATCH", message)
    return finite_floats(values, accessor)


def _check_indices(indices: np.ndarray, vertex_count: int, item: Item) -> None:
    highest = int(indices.max())
    if indices.dtype.itemsize < 4 and highest == np.iinfo(indices.dtype).max:
        raise item.error("ACCESSOR_INDEX_PRIMITIVE_RESTART", f"index {highest} is the primitive restart value")
    if highest >= vertex_count:
        raise item.error("ACCESSOR_INDEX_OOB", f"index {highest} is outside the {vertex_count} vertices")


def _triangles(indices: np.ndarray, mode: int) -> np.ndarray:
    """(m, 3) uint32 triangles, counter-clockwise, of a list, strip or fan of indices."""
    if mode == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3).astype(np.uint32)
    first = np.arange(max(len(indices) - 2, 0))
    if mode == FAN:
        corners = np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)
    else:
        odd = first % 2  # every other triangle of a strip winds the other way
        corners = np.stack([first, first + 1 + odd, first + 2 - odd], axis=1)
    return indices[corners].astype(np.uint32)


def _used_only(vertices: dict[str, np.ndarray], triangles: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Drop unused vertices where most are: many exporters let hundreds of primitives share one big vertex buffer."""
    if 2 * triangles.size > len(vertices["POSITION"]):
        return vertices, triangles
    kept, renumbered = np.unique(triangles, return_inverse=True)
    return {semantic: values[kept] for semantic, values in vertices.items()}, renumbered.reshape(-1, 3)


def _texcoords(vertices: dict[str, np.ndarray]) -> np.ndarray | None:
    sets = [vertices.get(f"TEXCOORD_{number}") for number in (0, 1)]
    if all(values is None for values in sets):
        return None
    absent = np.zeros((len(vertices["POSITION"]), 2), np.float32)
    return np.stack([absent if values is None else values for values in sets])


def _colors(vertices: dict[str, np.ndarray]) -> np.ndarray | None:
    colors = vertices.get("COLOR_0")
    if colors is None or colors.shape[1] == 4:
        return colors
    return np.hstack([colors, np.ones((len(colors), 1), np.float32)])
