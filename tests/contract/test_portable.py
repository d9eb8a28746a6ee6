"""The portable profile: a device with exactly WebGPU's default limits and no optional features."""

from __future__ import annotations

from typing import Any

import pytest

import softshadows as ss
import stage
from softshadows.gpu.device import DEFAULT_LIMITS, acquire
from softshadows.techniques import TECHNIQUES

PROMISED = ("none", "hard", "pcf", "pcss", "vsm", "variable_penumbra")
"""What must run everywhere."""


def test_the_device_has_exactly_the_default_limits() -> None:
    device = acquire("portable").device
    assert not {feature for feature in device.features if "native" not in feature}
    assert {name: device.limits[name] for name in DEFAULT_LIMITS} == DEFAULT_LIMITS
    assert acquire("portable").device is device
    assert acquire().device is not device


def portable(name: str, **options: Any) -> ss.Frame:
    scene = stage.standard_scene(stage.light_for(name))
    return ss.render(scene, technique=stage.cheap(name, **options), size=stage.SIZE, profile="portable")


@pytest.mark.parametrize("name", PROMISED)
def test_the_promised_techniques_give_the_full_profiles_visibility(name: str, compare_visibility: Any) -> None:
    full = stage.render(stage.standard_scene(stage.light_for(name)), stage.cheap(name))
    compare_visibility(portable(name).visibility[0], full.visibility[0], limit=1e-3)


@pytest.mark.parametrize("options", [{"kernels": "from_light"}, {"layers": 2}, {"kernels": "from_light", "layers": 2}])
def test_variable_penumbras_options_too(options: dict, compare_visibility: Any) -> None:
    technique = stage.cheap("variable_penumbra", **options)
    full = stage.render(stage.standard_scene(), technique)
    frame = portable("variable_penumbra", **options)
    compare_visibility(frame.visibility[0], full.visibility[0], limit=1e-3)


@pytest.mark.parametrize(
    ("light", "options"),
    [
        (stage.RECT, {"pcf": 2}),
        (stage.RECT, {"filter": "cell"}),
        (stage.light_for("line_shadow_maps"), {"visibility": "ray"}),
        (stage.light_for("line_shadow_maps"), {"visibility": "hybrid"}),
    ],
)
def test_adaptives_options_too(light: ss.Light, options: dict) -> None:
    """Those whose programs bind most: a filter, and rays between a line's samples."""
    scene = stage.standard_scene(light)
    frame = ss.render(scene, technique=stage.cheap("adaptive", **options), size=stage.SIZE, profile="portable")
    stage.check_visibility(frame)


@pytest.mark.parametrize("name", [name for name in TECHNIQUES if name not in PROMISED])
def test_the_others_run_too(name: str) -> None:
    stage.check_visibility(portable(name))


def test_an_unknown_profile_is_refused() -> None:
    with pytest.raises(ss.OptionError, match="full, portable"):
        ss.Renderer(stage.standard_scene(), profile="phone")


@pytest.mark.parametrize("scene", ["figures", "leaves"])
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("bitmask", {}),
        ("bitmask", {"preset": "preview"}),
        ("bitmask", {"rows": 16}),
        ("uniform", {"grid": 4, "visibility": "ray"}),
        ("adaptive", {"max_depth": 2, "visibility": "ray"}),
    ],
)
def test_what_walks_through_the_tree_gives_the_full_profiles_bits(scene: str, name: str, options: dict) -> None:
    """Within eight storage buffers a shader, alpha masks included."""
    made = ss.scenes.make(scene)
    assert made.camera is not None
    full, portable = (
        ss.render(made, made.camera, technique=name, options=options, size=stage.SIZE, profile=profile)
        for profile in ("full", "portable")
    )
    assert stage.same_bits(full.visibility, portable.visibility)
