"""A scene on the GPU: geometry, materials and textures, uploaded once and patched when nodes move."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, I32, U32, Struct, Vec3f, Vec4f, dtype, pack
from softshadows.gpu.program import Resource
from softshadows.gpu.texture_pages import TextureRecord, build_pages
from softshadows.scene.clusters import cluster_boxes
from softshadows.scene.geometry import Geometry
from softshadows.scene.model import Material, Texture

_USAGE = wgpu.BufferUsage
FEWEST_BOXES = 8
"""So many fill the smallest buffer: shaders take a buffer's size for their number."""
NOWHERE = 1e30
NO_NORMAL = np.uint32(0xFFFFFFFF)


class VertexAttributes(Struct):
    """What the shading needs of a vertex; its position is in a buffer of its own, which shadow maps read alone."""

    texcoords: Vec4f
    normal: U32  # octahedral, snorm 2×16; 0xffffffff where the mesh has none
    color_rg: U32  # unorm 2×16
    color_ba: U32
    unused: U32


class MaterialRecord(Struct):
    """A Material; textures are indices of TextureRecords, -1 for none; alpha_cutoff is negative for opaque ones."""

    base_color: Vec4f
    emission: Vec3f
    alpha_cutoff: F32
    metallic: F32
    roughness: F32
    double_sided: U32
    base_color_texture: I32
    metallic_roughness_texture: I32
    emission_texture: I32


class MaskedTriangle(Struct):
    """All that says where the surface of a triangle with an alpha mask exists (visibility/rays/masked.wgsl), by corner.

    `base_alpha` is the material's. The texture's record stands here once more, so that rays need no buffer of records.
    """

    texcoords_a: Vec4f
    texcoords_b: Vec4f
    texcoords_c: Vec4f
    alphas: Vec3f
    cutoff: F32
    texture: TextureRecord
    base_alpha: F32
    is_textured: U32


class SceneBuffers:
    """GPU copies of a Geometry.

    positions: array<f32>, three per vertex, world space, also a vertex buffer; indices: array<u32>, also an index
    buffer; attributes: array<VertexAttributes>; faces: array<vec4f> (unit normal by winding, material index as a
    float); occluder_boxes: low and high corner of clusters of triangles;
    materials, textures: records; masked: array<MaskedTriangle>, the triangles behind the opaque ones; pages: rgba8unorm
    2-d array texture.
    """

    def __init__(self, gpu: Gpu, geometry: Geometry) -> None:
        self.gpu, self.geometry = gpu, geometry
        self.triangle_count = len(geometry.triangles)
        self.opaque_count = geometry.opaque_count
        self.solid_count = geometry.solid_count
        self.diagonal = geometry.diagonal
        self.bytes = 0
        self.tree: Any = None  # of the triangles, once somebody asks for rays (visibility/rays/tree.py)
        vertex, index = _USAGE.STORAGE | _USAGE.VERTEX, _USAGE.STORAGE | _USAGE.INDEX
        self.positions = self._buffer(geometry.positions, vertex, "the vertex positions")
        self.indices = self._buffer(geometry.triangles, index, "the triangles")
        self.attributes = self._buffer(_attributes(geometry), _USAGE.STORAGE, "the vertex attributes")
        self.faces = self._buffer(_faces(geometry), _USAGE.STORAGE, "the face normals")

        textures = list({id(t): t for m in geometry.materials for t in _slots(m) if t is not None}.values())
        index_of = {id(texture): position for position, texture in enumerate(textures)}
        materials = [_material_record(material, index_of) for material in geometry.materials]
        pages, records, self.warnings = build_pages(textures, gpu.limit("max-texture-dimension-2d"))
        self.materials = self._buffer(
            np.frombuffer(pack(*materials) if materials else bytes(64), np.uint8), _USAGE.STORAGE, "the materials"
        )
        packed = np.frombuffer(
            pack(*records) if records else bytes(dtype(TextureRecord).itemsize), dtype(TextureRecord)
        )
        self.textures = self._buffer(packed.view(np.uint8), _USAGE.STORAGE, "the records of textures")
        masked = _masked_triangles(geometry, index_of, packed).view(np.uint8)
        self.masked = self._buffer(masked, _USAGE.STORAGE, "the triangles with alpha masks")
        self.pages = self._pages(pages)
        self.pages_view = self.pages.create_view(dimension="2d-array")
        self.occluder_boxes = self._buffer(_box_records(geometry), _USAGE.STORAGE, "the occluders' boxes")

    def move(self, geometry: Geometry) -> None:
        """Replace positions, normals and face normals after nodes moved; of the counts only solid_count may change."""
        self.geometry, self.diagonal, self.solid_count = geometry, geometry.diagonal, geometry.solid_count
        for buffer, array in (
            (self.positions, geometry.positions),
            (self.indices, geometry.triangles),
            (self.attributes, _attributes(geometry)),
            (self.faces, _faces(geometry)),
            (self.occluder_boxes, _box_records(geometry)),
        ):
            self.gpu.write(buffer, 0, array, what="scene")

    @property
    def resources(self) -> dict[str, Resource]:
        """What scene.wgsl declares."""
        return {
            "vertex_positions_ws": self.positions,
            "triangle_indices": self.indices,
            "vertex_attributes": self.attributes,
            "faces": self.faces,
            "materials": self.materials,
            "texture_records": self.textures,
            "texture_pages": self.pages_view,
        }

    @property
    def masked_resources(self) -> dict[str, Resource]:
        """What visibility/rays/masked.wgsl declares."""
        return {
            "masked_triangles": self.masked,
            "texture_pages": self.pages_view,
        }

    def _buffer(self, array: np.ndarray, usage: int, what: str) -> wgpu.GPUBuffer:
        size = max(-(-array.nbytes // 16) * 16, 256)
        self.bytes += size
        buffer = self.gpu.buffer(size, usage, what)
        if array.nbytes:
            self.gpu.write(buffer, 0, np.ascontiguousarray(array), what="scene")
        return buffer

    def _pages(self, pages: np.ndarray) -> wgpu.GPUTexture:
        count, size = pages.shape[:2]
        self.bytes += pages.nbytes
        usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
        texture = self.gpu.layered_texture((size, size), count, "rgba8unorm", usage, "the scene's textures")
        for layer in range(count):  # one by one: a single copy would double a large scene's memory
            self.gpu.write_texture(texture, layer, pages[layer])
        return texture


def _box_records(geometry: Geometry) -> np.ndarray:
    boxes = cluster_boxes(geometry)
    if len(boxes) < FEWEST_BOXES:  # of the others, nothing meets any
        nothing = np.array([[[NOWHERE] * 3, [-NOWHERE] * 3]])
        boxes = np.concatenate([boxes, np.repeat(nothing, FEWEST_BOXES - len(boxes), axis=0)])
    return np.pad(boxes, ((0, 0), (0, 0), (0, 1))).astype(np.float32)  # vec3f members are 16 bytes apart


def _slots(material: Material) -> list[Texture | None]:
    return [material.base_color_texture, material.metallic_roughness_texture, material.emission_texture]


def _masked_triangles(
    geometry: Geometry, index_of: dict[int, int], textures: npt.NDArray[np.void]
) -> npt.NDArray[np.void]:
    """(k,) MaskedTriangles; `textures` are the packed records of all textures."""
    corners = geometry.triangles[geometry.opaque_count :]
    used = geometry.material_index[geometry.opaque_count :]
    records = np.zeros(len(corners), dtype(MaskedTriangle))
    for corner, name in enumerate("abc"):
        records[f"texcoords_{name}"] = geometry.texcoords[corners[:, corner]]
    records["alphas"] = _unorm16(geometry.colors[corners, 3]) / np.float32(65535.0)
    for index in np.unique(used):
        material, of_it = geometry.materials[index], used == index
        texture = material.base_color_texture
        records["cutoff"][of_it] = material.alpha_cutoff
        records["base_alpha"][of_it] = material.base_color[3]
        if texture is not None:
            records["texture"][of_it] = textures[index_of[id(texture)]]
            records["is_textured"][of_it] = 1
    return records


def _unorm16(values: np.ndarray) -> np.ndarray:
    return np.round(np.clip(values, 0.0, 1.0) * 65535.0).astype(np.uint32)


def _material_record(material: Material, index_of: dict[int, int]) -> MaterialRecord:
    base, metallic_roughness, emission = (-1 if slot is None else index_of[id(slot)] for slot in _slots(material))
    return MaterialRecord(
        base_color=material.base_color,
        emission=material.emission,
        alpha_cutoff=-1.0 if material.alpha_cutoff is None else material.alpha_cutoff,
        metallic=material.metallic,
        roughness=material.roughness,
        double_sided=int(material.double_sided),
        base_color_texture=base,
        metallic_roughness_texture=metallic_roughness,
        emission_texture=emission,
    )


def _faces(geometry: Geometry) -> np.ndarray:
    return np.hstack([geometry.face_normals, geometry.material_index[:, None].astype(np.float32)]).astype(np.float32)


def _attributes(geometry: Geometry) -> np.ndarray:
    attributes = np.zeros(len(geometry.positions), dtype(VertexAttributes))
    attributes["texcoords"] = geometry.texcoords
    attributes["normal"] = _octahedral(geometry.normals)
    color = _unorm16(geometry.colors)
    attributes["color_rg"] = color[:, 0] | color[:, 1] << 16
    attributes["color_ba"] = color[:, 2] | color[:, 3] << 16
    return attributes


def _octahedral(normals: np.ndarray) -> np.ndarray:
    """(n,) uint32: the octahedral map (Cigolle et al. 2014) as two snorm16; 0xffffffff for zero normals."""
    length = np.abs(normals).sum(axis=1, keepdims=True)
    n = np.divide(normals, length, out=np.zeros_like(normals, dtype=np.float64), where=length > 0.0)
    folded = (1.0 - np.abs(n[:, 1::-1])) * np.where(n[:, :2] >= 0.0, 1.0, -1.0)
    xy = np.where(n[:, 2:] < 0.0, folded, n[:, :2])
    bits = np.round(np.clip(xy, -1.0, 1.0) * 32767.0).astype(np.int64) & 0xFFFF
    packed = (bits[:, 0] | bits[:, 1] << 16).astype(np.uint32)
    packed = np.where(packed == NO_NORMAL, np.uint32(0), packed)  # the one direction that would read as "none"
    return np.where(length[:, 0] > 0.0, packed, NO_NORMAL)
