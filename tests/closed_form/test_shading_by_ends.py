"""Line lights shaded by the illumination at their ends, as both papers do it, against the papers' sums in float64.

A half-plane at y = h hides the light at y = H along x from the floor, y = 0, from one end on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
from softshadows.techniques import Ends, LineShadowMaps, OccludingEdges, Technique, Texture
from softshadows.truth import closed_form

H, h, a, e = 2.0, 0.8, 1.0, 0.1
"""Low, so that the ends are seen at very different distances: their illumination differs by up to a factor of 2."""
FAR = 60.0
LIMIT = 0.01
OESS: dict[str, dict[str, Any]] = {
    "paper": {"samples": 2, "penumbra": Texture(rows=2)},
    "searched": {"samples": 2},
}
Floats = npt.NDArray[np.float64]


def look_down(technique: Technique, *, blocks_start: bool) -> tuple[Floats, Floats, Floats, Floats]:
    """(found visibility, true share, illumination by the start, by the end), each (height, width), of the floor."""
    light = ss.LineLight((-a, H, 0.0), (a, H, 0.0), (1.0, 1.0, 1.0))
    blocker = (-FAR, e, -FAR, FAR) if blocks_start else (-e, FAR, -FAR, FAR)
    scene = ss.scenes.blocker(light_height=H, height=h, occluders=[blocker], light=light, floor_half=8.0)
    eye = 0.9 * h
    camera = ss.Camera((0.0, eye, 0.0), (0.0, 0.0, 0.0), 70.0, up=(np.sin(0.002), 0.0, -np.cos(0.002)))
    frame = ss.render(scene, camera, technique=technique, size=(96, 32))
    assert frame.facing.all()
    position = frame.position.astype(np.float64)
    x = position[..., 0] if blocks_start else -position[..., 0]
    share = closed_form.half_plane(x, H, h, a, e)
    distances = [np.linalg.norm(position - (end, H, 0.0), axis=-1) for end in (-a, a)]
    by_start, by_end = (H / distance**3 for distance in distances)
    return frame.visibility[0].astype(np.float64), share, by_start, by_end


def linear(share: Floats) -> Floats:
    return share**2 / 2.0


def late(share: Floats) -> Floats:
    """The integral of the table 0 0 1."""
    return np.maximum(share - 0.5, 0.0) ** 2


@pytest.mark.parametrize("blocks_start", [True, False])
@pytest.mark.parametrize("options", OESS.values(), ids=OESS)
@pytest.mark.parametrize(("table", "integral"), [((0, 1), linear), ((0, 0.5, 1), linear), ((0, 0, 1), late)])
def test_occluding_edges_share_what_is_lit_among_the_ends(
    options: dict[str, Any], table: tuple[float, ...], integral: Callable[[Floats], Floats], blocks_start: bool
) -> None:
    """[Reimann2016 §3.4 substeps 4.3, 4.4] B illum(L) + A illum(R), A the integral of f over what is lit."""
    technique = OccludingEdges(**options, resolution=1024, shading=Ends(table))
    found, share, by_start, by_end = look_down(technique, blocks_start=blocks_start)
    all_of_it = integral(np.ones(()))
    of_end = all_of_it - integral(1.0 - share) if blocks_start else integral(share)
    expected = (share - of_end) * by_start + of_end * by_end
    expected /= (1.0 - all_of_it) * by_start + all_of_it * by_end
    assert np.abs(found - expected).max() <= LIMIT
    assert np.abs(share - expected).max() > 3.0 * LIMIT, "the ends' illumination must matter"
    assert (found[share > 1.0 - 1e-9] >= 1.0 - LIMIT).all()
    assert (found == 1.0).sum() > 100


def test_an_influence_of_one_end_alone_is_the_visible_share() -> None:
    ways: list[dict[str, Any]] = [{}, {"shading": Ends((1, 1))}]
    whole, by_end = (look_down(OccludingEdges(samples=2, resolution=256, **way), blocks_start=True)[0] for way in ways)
    assert np.abs(whole - by_end).max() < 1e-5


@pytest.mark.parametrize("blocks_start", [True, False])
def test_soft_shadow_maps_weigh_their_channels_with_the_ends(blocks_start: bool) -> None:
    """[Heidrich2000 §3] The end that alone sees a point stands for all that is visible; nothing outshines the lit."""
    technique = LineShadowMaps(samples=2, transition="linear", between="channels", resolution=1024, shading="ends")
    found, share, by_start, by_end = look_down(technique, blocks_start=blocks_start)
    seen_by = by_end if blocks_start else by_start
    expected = np.minimum(share * seen_by / (0.5 * (by_start + by_end)), 1.0)
    inside = (share > 0.02) & (share < 0.98)
    assert inside.sum() > 500
    assert np.abs(found - expected)[inside].max() <= LIMIT
    assert np.abs(share - expected)[inside].max() > 3.0 * LIMIT
    assert (found[share == 1.0] > 1.0 - LIMIT).all()
    assert (found == 1.0).sum() > 100
    assert found.max() == 1.0


def test_a_table_is_text_or_numbers() -> None:
    assert Ends(influence=(0, 0.5, 1)) == Ends(influence=" 0  0.5 1.0")  # type: ignore[arg-type]
    assert OccludingEdges.of({"shading": "ends", "shading.influence": "0 1"}).shading == Ends()
    for illegal in ("0", "0 2", "0 nan", "0,1"):
        with pytest.raises(ss.OptionError, match="influence"):
            Ends(influence=illegal)  # type: ignore[arg-type]
