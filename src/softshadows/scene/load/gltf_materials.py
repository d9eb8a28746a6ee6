"""glTF materials, textures and samplers.

Metallic-roughness with base colour, emission and alpha mask. Blended materials become masks at 0.5, since a shadow map
holds one depth; normal and occlusion maps are not used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.load.checked_json import Item
from softshadows.scene.load.gltf_container import Asset
from softshadows.scene.load.images import TOLERATED_CODES, EncodedImage, Pixels, decode_images
from softshadows.scene.model import Material, Texture, Wrap

WRAPS: dict[int, Wrap] = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
NEAREST, LINEAR = 9728, 9729
BLEND_CUTOFF = 0.5


@dataclass
class Materials:
    """The materials of an asset, in file order, and the default one for primitives without."""

    all: list[Material]
    default: Material = field(
        default_factory=lambda: Material(base_color=(1.0, 1.0, 1.0, 1.0), metallic=1.0, roughness=1.0)
    )

    @classmethod
    def of(cls, asset: Asset, on_missing: str) -> Materials:
        """Read all materials; images decode here. `on_missing="warn"` drops textures whose image cannot be read."""
        items = asset.root.objects("materials")
        textures = _Textures(asset)
        textures.decode([info for item in items for info in _used_infos(item)], on_missing)
        return cls([_material(item, index, textures) for index, item in enumerate(items)])

    def of_primitive(self, primitive: Item) -> Material:
        if "material" not in primitive:
            return self.default
        return self.all[primitive.index("material", len(self.all), "material")]


def _used_infos(material: Item) -> list[Item]:
    """The textureInfo objects that are read from `material`."""
    surface = material.object("pbrMetallicRoughness")
    infos = [material.object("emissiveTexture")]
    if surface is not None:
        infos += [surface.object("baseColorTexture"), surface.object("metallicRoughnessTexture")]
    return [info for info in infos if info is not None]


def _material(item: Item, index: int, textures: _Textures) -> Material:
    name = item.string("name", "")
    label = name or f"number {index}"
    for unused in ("normalTexture", "occlusionTexture"):
        info = item.object(unused)
        if info is not None:
            info.index("index", len(textures.items), "texture")
    if item.extension("KHR_materials_unlit") is not None:
        textures.asset.warn(f"material {label}: KHR_materials_unlit is ignored, it is lit as any other")
    surface = item.object("pbrMetallicRoughness") or Item({}, item.file, f"{item.pointer}/pbrMetallicRoughness")
    strength = item.extension("KHR_materials_emissive_strength")
    scale = 1.0 if strength is None else strength.number("emissiveStrength", 1.0, low=0.0)
    red, green, blue = (scale * value for value in item.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0), low=0.0))
    if not math.isfinite(red + green + blue):
        raise item.error("VALUE_NOT_IN_RANGE", "emissive factor times strength is not finite", "emissiveFactor")
    return Material(
        name=name,
        base_color=_four(surface.numbers("baseColorFactor", 4, (1.0, 1.0, 1.0, 1.0), low=0.0, high=1.0)),
        base_color_texture=textures.at(surface.object("baseColorTexture")),
        metallic=surface.number("metallicFactor", 1.0, low=0.0, high=1.0),
        roughness=surface.number("roughnessFactor", 1.0, low=0.0, high=1.0),
        metallic_roughness_texture=textures.at(surface.object("metallicRoughnessTexture")),
        emission=(red, green, blue),
        emission_texture=textures.at(item.object("emissiveTexture")),
        alpha_cutoff=_alpha_cutoff(item, label, textures.asset),
        double_sided=item.boolean("doubleSided"),
    )


def _four(values: tuple[float, ...]) -> tuple[float, float, float, float]:
    red, green, blue, alpha = values
    return (red, green, blue, alpha)


def _alpha_cutoff(item: Item, label: str, asset: Asset) -> float | None:
    mode = item.string("alphaMode", "OPAQUE", among=("OPAQUE", "MASK", "BLEND"))
    cutoff = item.number("alphaCutoff", 0.5, low=0.0)
    if mode == "BLEND":
        asset.warn(f"material {label}: alpha blending is replaced by a mask with cutoff {BLEND_CUTOFF}")
        return BLEND_CUTOFF
    return cutoff if mode == "MASK" else None


class _Textures:
    """The textures of an asset: image, sampler and transform put together, equal ones shared."""

    def __init__(self, asset: Asset) -> None:
        self.asset = asset
        self.items = asset.root.objects("textures")
        self.images = asset.root.objects("images")
        self.samplers = asset.root.objects("samplers")
        self._pixels: dict[int, Pixels | None] = {}
        self._shared: dict[tuple, Texture] = {}

    def decode(self, infos: list[Item], on_missing: str) -> None:
        """Decode the images behind `infos`, several at a time."""
        indices = sorted({self._image_index(self._texture(info)) for info in infos} - {-1})
        encoded: dict[int, EncodedImage] = {}
        failed: list[tuple[int, SceneError]] = []
        for index in indices:
            try:
                encoded[index] = self._encoded(self.images[index])
            except SceneError as error:
                failed.append((index, error))
        for index, result in zip(encoded, decode_images(list(encoded.values()), on_missing), strict=True):
            if isinstance(result, SceneError):
                failed.append((index, result))
            else:
                self._pixels[index] = result
        for index, error in sorted(failed, key=lambda pair: pair[0]):
            if on_missing == "error" or error.code not in TOLERATED_CODES:
                raise error
            self.asset.warn(f"a texture is left out: {error}")
            self._pixels[index] = None

    def at(self, info: Item | None) -> Texture | None:
        """The texture a textureInfo object names, or None where it names none or its image was left out."""
        if info is None:
            return None
        item = self._texture(info)
        pixels = self._pixels.get(self._image_index(item))
        texcoord, transform = _placement(info)
        if texcoord > 1:
            self.asset.warn(f"a texture is left out: it uses texture coordinate set {texcoord}, sets 0 and 1 are read")
            return None
        if pixels is None:
            return None
        key = (item.pointer, texcoord, transform.tobytes())
        if key not in self._shared:
            self._shared[key] = self._sampled(item, pixels, texcoord, transform)
        return self._shared[key]

    def _texture(self, info: Item) -> Item:
        return self.items[info.index("index", len(self.items), "texture")]

    def _image_index(self, texture: Item) -> int:
        """The image of `texture`; −1 where it has none that can be read."""
        source = texture.extension("EXT_texture_webp") or texture
        if "source" not in source:
            self.asset.warn("a texture is left out: it has no PNG, JPEG or WebP image")
            return -1
        return source.index("source", len(self.images), "image")

    def _encoded(self, image: Item) -> EncodedImage:
        if ("uri" in image) == ("bufferView" in image):
            raise image.error("ONE_OF_MISMATCH", "an image needs either a uri or a bufferView")
        if "uri" in image:
            pointer = f"{image.pointer}/uri"
            data = self.asset.folder.read(image.string("uri"), pointer, missing_code="IMAGE_MISSING")
        else:
            pointer = f"{image.pointer}/bufferView"
            data = self.asset.view_bytes(image.index("bufferView", len(self.asset.views), "buffer view"))
        return EncodedImage(bytes(data), str(self.asset.file), pointer)

    def _sampled(self, item: Item, pixels: Pixels, texcoord: int, transform: np.ndarray) -> Texture:
        sampler = Item({}, item.file)
        if "sampler" in item:
            sampler = self.samplers[item.index("sampler", len(self.samplers), "sampler")]
        return Texture(
            pixels=pixels,
            wrap_u=_wrap(sampler, "wrapS"),
            wrap_v=_wrap(sampler, "wrapT"),
            nearest=_magnification(sampler) == NEAREST,
            transform=transform,
            texcoord=texcoord,
            name=item.string("name", ""),
        )


def _wrap(sampler: Item, key: str) -> Wrap:
    value = sampler.integer(key, 10497)
    if value not in WRAPS:
        raise sampler.error("VALUE_NOT_IN_LIST", f"expected one of {', '.join(map(str, WRAPS))}, got {value}", key)
    return WRAPS[value]


def _magnification(sampler: Item) -> int:
    value = sampler.integer("magFilter", LINEAR)
    if value not in (NEAREST, LINEAR):
        raise sampler.error("VALUE_NOT_IN_LIST", f"expected {NEAREST} or {LINEAR}, got {value}", "magFilter")
    return value


def _placement(info: Item) -> tuple[int, np.ndarray]:
    """The texture coordinate set and the (2, 3) float32 matrix of KHR_texture_transform (identity without it).

    offset × rotation × scale. The extension's text and its example, a quarter turn that shows the lower left quadrant,
    fix the sign: u' = cos·u + sin·v with v pointing down.
    """
    texcoord = info.integer("texCoord", 0)
    item = info.extension("KHR_texture_transform")
    if item is None:
        return texcoord, np.eye(2, 3, dtype=np.float32)
    (offset_u, offset_v), (scale_u, scale_v) = (
        item.numbers("offset", 2, (0.0, 0.0)),
        item.numbers("scale", 2, (1.0, 1.0)),
    )
    angle = item.number("rotation", 0.0)
    cos, sin = math.cos(angle), math.sin(angle)
    with np.errstate(over="ignore"):
        matrix = np.array(
            [[cos * scale_u, sin * scale_v, offset_u], [-sin * scale_u, cos * scale_v, offset_v]], np.float64
        ).astype(np.float32)
    if not np.isfinite(matrix).all():
        raise item.error("VALUE_NOT_IN_RANGE", "the texture transform exceeds what 32-bit floats hold")
    return item.integer("texCoord", texcoord), matrix
