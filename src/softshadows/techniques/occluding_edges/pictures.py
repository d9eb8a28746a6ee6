"""Pictures of what occluding edges found in a frame: the edge maps, and the penumbrae that pixels were assigned to.

    renderer = ss.Renderer(scene, technique="occluding_edges")
    frame = renderer.render(camera)
    edges = read_edges(renderer)
    image = edge_picture(edges, sample=0)

The GPU's memory is read between frames, so that a frame itself reads back nothing more. All pictures are float32 RGB in
0..1, row 0 at the top, to be shown as they are. They show the light that was drawn last.

    edge_picture       a sample's map: edges, and the texels in their penumbrae          [Reimann2016 Fig. 3]
    penumbra_picture   the camera's image: in whose penumbra each pixel's texel lies     [Reimann2016 §3.4 substep 4.1]
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.gpu.layout import dtype
from softshadows.scene.lights import Light
from softshadows.techniques.occluding_edges.occluding_edges import OccludingEdgesPass
from softshadows.visibility.line_maps.line_maps import line_points
from softshadows.visibility.maps.structs import FACES, ShadowView

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]

AFTER, BEFORE = 0, 1
EDGE_JUMPS = 0x8000
"""edge_map.wgsl."""
LINE_FACES = (
    ((0, 1), (1, 1), (2, -1)),
    ((0, 1), (2, 1), (1, 1)),
    ((0, 1), (1, -1), (2, 1)),
    ((0, 1), (2, -1), (1, -1)),
)
"""line_space.wgsl: by face, which axis of light space, and its sign, is a, b and d."""
IN_ORDER = (0.16, 0.17, 0.19)
PENUMBRA_COLORS = ((0.25, 0.45, 1.0), (0.2, 0.75, 0.3))
"""Colours of texels that the next sample does not see, and that the sample before does not see; their sum for both."""
EDGE_COLOR = (1.0, 0.25, 0.2)


class Seen(Protocol):
    """What a picture takes of an `ss.Frame`."""

    position: Floats
    surface: Bools


@dataclass(frozen=True, eq=False)
class Edges:
    """The edge map of one light: words (rows, columns) uint32 for the whole atlas, and its views (samples, FACES)."""

    light: Light
    words: npt.NDArray[np.uint32]
    views: np.ndarray

    @property
    def samples(self) -> int:
        """Points of the light that have a map."""
        return len(self.views)

    def of_view(self, sample: int, face: int) -> npt.NDArray[np.uint32]:
        """(2, rows, columns): the entries of a sample's view of a face, AFTER and BEFORE; 0 rows where not in use."""
        view = self.views[sample, face]
        (x, y), (width, height) = view["origin"], view["size"]
        pairs = (width + 1) // 2
        words = self.words[y : y + height, x : x + 2 * pairs].reshape(height, 2, pairs)
        entries = np.stack([words & 0xFFFF, words >> 16], axis=-1).reshape(height, 2, 2 * pairs)[..., :width]
        has_segment = np.array([sample + 1 < self.samples, sample > 0])
        return (entries.transpose(1, 0, 2) * has_segment[:, None, None]).astype(np.uint32)

    @property
    def has_edge(self) -> Bools:
        """(samples, FACES): does any texel of the view lie in a penumbra?"""
        return np.array([[self.of_view(s, f).any() for f in range(len(LINE_FACES))] for s in range(self.samples)])


def read_edges(renderer: Any) -> Edges:
    """The edges of the last frame of `renderer`, an `ss.Renderer`; OptionError where there are none of this kind."""
    work = getattr(renderer.passes, "technique", None)
    if not isinstance(work, OccludingEdgesPass) or not work.lights:
        raise OptionError(
            "these pictures show occluding edges: render a frame with technique 'occluding_edges' and a light first"
        )
    edge_maps, _ = work.by_light[-1]
    queue, side = renderer._gpu.device.queue, edge_maps.maps.plan.atlas_size
    data = queue.read_texture(
        {"texture": edge_maps.edge_map}, {"bytes_per_row": 4 * side, "rows_per_image": side}, (side, side, 1)
    )
    views = np.frombuffer(queue.read_buffer(edge_maps.maps.atlas.views), dtype(ShadowView))
    return Edges(
        light=work.lights[-1],
        words=np.frombuffer(data, "<u4").reshape(side, side),
        views=views.reshape(-1, FACES),
    )


def edge_picture(edges: Edges, sample: int = 0) -> Floats:
    """[Reimann2016 Fig. 3] (rows, columns, 3): a sample's largest view. Edges red, their penumbrae blue and green.

    Blue: hidden from the next sample; green: from the one before. OptionError for a sample that is not there.
    """
    if not 0 <= sample < edges.samples:
        raise OptionError(f"sample must be from 0 to {edges.samples - 1}, got {sample!r}")
    face = int(edges.views[sample]["size"][: len(LINE_FACES)].prod(axis=-1).argmax())
    entries = edges.of_view(sample, face)
    image = _penumbra_colors(entries[AFTER] > 0, entries[BEFORE] > 0)
    for side in (AFTER, BEFORE):
        rows, columns = np.nonzero(entries[side])
        image[rows, (entries[side][rows, columns] & ~np.uint32(EDGE_JUMPS)) - 1] = EDGE_COLOR
    return image


def penumbra_picture(edges: Edges, frame: Seen) -> Floats:
    """[Reimann2016 §3.4 substep 4.1] (height, width, 3): pixels whose texel lies in a penumbra of the light's ends.

    Blue: in the map of the light's start, of an edge that hides its end; green: the other way round.
    """
    light = edges.light
    points = light.center + line_points(light, edges.samples) @ light.axes[:2]
    found = [
        _entry_at(edges, frame, sample, side, points[sample] - light.center)
        for sample, side in ((0, AFTER), (edges.samples - 1, BEFORE))
    ]
    image = _penumbra_colors(found[0], found[1])
    image[~frame.surface] = 0.0
    return image


def _entry_at(edges: Edges, frame: Seen, sample: int, side: int, offset: npt.NDArray[np.float64]) -> Bools:
    """(height, width): does the texel that the pixel falls on hold an edge on that side?"""
    light = edges.light
    local = (frame.position - light.center - offset) @ light.axes.T
    found, covered = np.zeros(frame.surface.shape, bool), np.zeros(frame.surface.shape, bool)
    for face, axes in enumerate(LINE_FACES):
        view, entries = edges.views[sample, face], edges.of_view(sample, face)[side]
        if not entries.size:
            continue
        along, across, depth = (sign * local[..., axis] for axis, sign in axes)
        ahead = depth > 0.0
        safe = np.where(ahead, depth, 1.0)
        texel = np.stack([along / safe, across / safe], axis=-1) - view["window_low"]
        column, row = np.moveaxis(np.floor(texel * view["texels_per_unit"]).astype(np.int64), -1, 0)
        height, width = entries.shape
        inside = ahead & ~covered & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        found[inside] = entries[row[inside], column[inside]] > 0
        covered |= inside
    return found


def _penumbra_colors(after: Bools, before: Bools) -> Floats:
    image = np.empty((*after.shape, 3), np.float32)
    image[:] = IN_ORDER
    image[after] = PENUMBRA_COLORS[AFTER]
    image[before] = PENUMBRA_COLORS[BEFORE]
    image[after & before] = np.add(*PENUMBRA_COLORS).clip(0.0, 1.0)
    return image


def all_pictures(renderer: Any, frame: Seen) -> dict[str, Floats]:
    """By name: the edge maps of the light's first and last sample, and the penumbrae of `frame`, the last one."""
    edges = read_edges(renderer)
    return {
        "edges-first": edge_picture(edges, 0),
        "edges-last": edge_picture(edges, edges.samples - 1),
        "penumbrae": penumbra_picture(edges, frame),
    }
