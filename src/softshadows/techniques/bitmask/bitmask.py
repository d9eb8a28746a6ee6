"""Bit-mask soft shadows: one walk of the scene's tree finds all samples of the light that a receiver sees.

Each pixel walks down the tree of triangles once, with the shaft from its receiver to the light. The light is cut into
rows of 32 samples, a bit each. A triangle covers one interval of a row, so 32 samples cost what one does; a box whose
samples are all hidden already, or that lies between samples, is refused. Bits agree with rays to the same samples.

Paper
    [Schwarz2007]  Schwarz, Stamminger, "Bitmask Soft Shadows", Computer Graphics Forum 26(3), 2007.
    [Laine2005]    Laine, Aila, "Hierarchical Penumbra Casting", Computer Graphics Forum 24(3), 2005.

Section map
    [Schwarz2007 bit mask]   which samples are hidden, a bit each        -> hidden_samples.wgsl bits_between() hide()
    [Laine2005 shaft]        what could hide a sample is walked through  -> walk.wgsl mark_hidden()

Departures from the paper
    - Occluders are the scene's triangles in a bounding volume hierarchy, not micropatches of a shadow map: nothing is
      missing that the light's centre does not see, and there is no texel and no bias.
    - A triangle marks intervals of slanted rows instead of half planes from a table. Rows climb by 0.62 of their height
      over the light's width, so that an edge along the light's sides does not meet all of a row at one place.
    - Of a solid, only the far side marks samples, unless the light reaches into the solid: a receiver on it then never
      meets its own surface.
    - A box is refused when the samples it could hide are hidden: without it, dense meshes cost several times as much.

Use when
    a shadow must be right: contacts, thin occluders, large scenes, any light with an area or a length.
Fails when
    an edge lies along the rows: with few of them their steps show (scene `blocker` with `rows=4`, seen from near).
    Where a thin part of a lamp lies along them, it hides the same share of samples at every pixel, and visibility is
    off by a part of a row; `offsets="stratified"` hides another share at each of 4×4 pixels.
Inputs
    any light; those without size take one ray.
Cost
    one walk per pixel for 8 rows or fewer, two for 16, four for 32. A light's tree takes 80 bytes a triangle; the trees
    of all lights are kept where they fit `memory_budget`, else one is fitted to light after light. Nothing is drawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

import numpy as np
import wgpu

from softshadows.gpu.budget import interleaved_groups
from softshadows.gpu.commands import Commands
from softshadows.gpu.layout import F32, U32, Struct, Vec2f, Vec4u, dtype, pack
from softshadows.gpu.program import Program, Resource
from softshadows.lights.rows import SLANT, placing_of, row_samples
from softshadows.scene.lights import Light
from softshadows.techniques.base import ALL_LIGHTS, Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import Rays, denoise_option, offsets_option
from softshadows.techniques.options import option
from softshadows.techniques.uniform.uniform import Uniform
from softshadows.techniques.workers import Workers
from softshadows.visibility.denoise.denoise import Denoise
from softshadows.visibility.rays.light_tree import LightTree, TreeStore
from softshadows.visibility.rays.tree import CUT_SHORT, tree_of

WORDS_AT_ONCE = 8
"""Words of 32 samples that a walk marks (hidden_samples.wgsl)."""
OPAQUE = {"techniques/bitmask/cutouts.wgsl": "techniques/bitmask/no_cutouts.wgsl"}
LINE = {"techniques/bitmask/rectangle.wgsl": "techniques/bitmask/line.wgsl"}


class RowSet(Struct):
    """The samples of one walk: rows `first_row` to before `first_row + count` of a light's `rows`; of a line, words.

    The bits outside stand for no sample of the light; `weight` is that of one sample in the light's visibility.
    """

    outside_lower: Vec4u
    outside_upper: Vec4u
    shift: Vec2f  # of all samples, in columns and rows
    slant: F32
    rows: F32
    first_row: F32
    count: F32
    weight: F32
    is_first: U32


class Bitmask(Technique):
    """Every sample of the light in one walk of the scene's tree. The module's text is its manual."""

    name: ClassVar[str] = "bitmask"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS
    refines: ClassVar[bool] = True
    presets: ClassVar[Presets] = {
        "preview": {"rows": 4, "offsets": "stratified", "denoise": True},
        "reference": {"rows": 32},
    }

    rows: int = option(
        default=8,
        help="rows of 32 samples that the light is cut into; a line has 8 samples for each",
        choices=(4, 8, 16, 32),
    )
    offsets: str = offsets_option()
    denoise: bool = denoise_option()

    def build(self, context: RenderContext) -> TechniquePass:
        return BitmaskPass(context, self)


def row_sets(light: Light, rows: int, refinement: int) -> Iterator[RowSet]:
    """What each walk of a light marks."""
    placing = placing_of(refinement)
    samples = row_samples(light, rows, placing)
    outside = samples.words_outside
    for first in range(0, len(outside), WORDS_AT_ONCE):
        words = outside[first : first + WORDS_AT_ONCE]
        padded = np.full(WORDS_AT_ONCE, 0xFFFFFFFF, np.uint32)
        padded[: len(words)] = words
        yield RowSet(
            outside_lower=tuple(padded[:4].tolist()),
            outside_upper=tuple(padded[4:].tolist()),
            shift=(placing.column, placing.row),
            slant=placing.slant,
            rows=float(len(outside)),
            first_row=float(first),
            count=float(len(words)),
            weight=1.0 / samples.count,
            is_first=int(first == 0),
        )


class WalkedLight:
    """One light with an extent at work: the tree in its space, and the programs of its walks."""

    def __init__(
        self, context: RenderContext, technique: Bitmask, store: TreeStore, report: wgpu.GPUBuffer, *, is_line: bool
    ) -> None:
        self._context, self._technique, self._is_line = context, technique, is_line
        self.tree = LightTree(context.gpu, context.scene, tree_of(context.scene), store)
        self._row_sets: list[wgpu.GPUBuffer] = []
        self._walks: list[Program] = []
        self._has_upper_words = True
        self._targets: dict[str, Resource] = {"visibility": context.visibility, "report": report}

    def write(self, light: Light, index: int, refinements: int) -> None:
        """Write the light, of which the visibility is number `index`, and its samples."""
        self.tree.write(light, index)
        for number, rows in enumerate(row_sets(light, self._technique.rows, refinements)):
            if number == len(self._walks):
                gpu = self._context.gpu
                self._row_sets.append(gpu.storage_buffer(dtype(RowSet).itemsize, "a walk's rows"))
                self._has_upper_words = rows.count > 4.0
                self._walks.append(self.program("bitmask.wgsl", "cs_visibility", number, self._targets))
            self._context.gpu.write(self._row_sets[number], 0, pack(rows), what="samples")

    def program(self, file: str, entry: str, number: int, targets: Mapping[str, Resource]) -> Program:
        """An entry of a shader that includes walk.wgsl, for walk `number`."""
        context, tree = self._context, tree_of(self._context.scene)
        return Program(
            context.gpu,
            f"techniques/bitmask/{file}",
            entry,
            {
                **context.gbuffer.resources,
                **(context.scene.masked_resources if tree.has_cutouts else {}),
                **self.tree.resources,
                "row_set": self._row_sets[number],
                **targets,
            },
            constants={
                "has_upper_words": self._has_upper_words,
                "is_stratified": self._technique.offsets == "stratified",
            },
            stand_ins={**(LINE if self._is_line else {}), **({} if tree.has_cutouts else OPAQUE)},
        )

    def encode(self, commands: Commands) -> None:
        width, height = self._context.gbuffer.size
        groups, budget = interleaved_groups(self._context.gbuffer.size), self._context.gpu.budget
        self.tree.encode(commands)
        for walk in self._walks:
            with commands.compute("walk") as compute:
                walk.dispatch(compute, groups)
            commands.account(RAYS_PER_WALK * width * height / budget.rays_per_ms)


RAYS_PER_WALK = 16
"""Rays that take as long as a walk, at most: measured on the shots of docs/decisions/0019-bitmask.md."""


class BitmaskPass(TechniquePass):
    """The technique at work: lights with an extent by walks, others by one ray each."""

    def __init__(self, context: RenderContext, technique: Bitmask) -> None:
        super().__init__()
        self.context, self.technique = context, technique
        self._tree = tree_of(context.scene)
        self._report = context.gpu.storage_buffer(4, "the walks' report")
        self._points = Uniform(grid=1, visibility=Rays()).build(context)
        self._stores = Workers(lambda kind: TreeStore(context.gpu, self._tree), context.memory_budget)
        self._walked: dict[tuple[int, bool, TreeStore], WalkedLight] = {}
        self._at_work: dict[int, WalkedLight] = {}
        noise = (1.0 - SLANT) / technique.rows
        self._denoise = Denoise(context.gpu, context.gbuffer, context.visibility, noise) if technique.denoise else None

    def write(self, lights: Mapping[int, Light]) -> None:
        sized = {index: light for index, light in lights.items() if light.has_size}
        self._points.write({index: light for index, light in lights.items() if not light.has_size})
        stores = self._stores.assign(dict.fromkeys(sized, "rectangle or line"))
        self._at_work = {index: self._write_light(light, index, stores[index][0]) for index, light in sized.items()}
        if self._denoise is not None:
            self._denoise.write([*sized])

    def _write_light(self, light: Light, index: int, store: TreeStore) -> WalkedLight:
        is_line = 0.0 in light.half_extent
        key = (index, is_line, store)
        if key not in self._walked:
            self._walked[key] = WalkedLight(self.context, self.technique, store, self._report, is_line=is_line)
        self._walked[key].write(light, index, self.refinements)
        return self._walked[key]

    def walked(self, index: int) -> WalkedLight:
        """Who found the last frame's visibility of a light with an extent."""
        return self._at_work[index]

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._report)
        self._tree.encode(commands)
        for walked in self._at_work.values():
            walked.encode(commands)
        if self._denoise is not None and self._at_work:
            self._denoise.encode(commands)
        self._points.encode(commands)
        self.bytes = self._tree.bytes + self._stores.bytes + (self._denoise.bytes if self._denoise is not None else 0)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"report": (self._report, "<u4", (1,)), **{f"point_{k}": v for k, v in self._points.results.items()}}

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        self._points.read({name: results[f"point_{name}"] for name in self._points.results})
        self.warnings = list(dict.fromkeys(([CUT_SHORT] if results["report"][0] else []) + self._points.warnings))
