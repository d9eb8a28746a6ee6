"""Shots: what the format says is what comes out, and every mistake is answered by its file and key."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from softshadows.errors import SceneError
from softshadows.scene import builtin
from softshadows.scene.camera import Camera
from softshadows.scene.description import camera_from_text, light_from_text, size_from_text
from softshadows.scene.framing import complete, framing_camera
from softshadows.scene.lights import LineLight, RectLight
from softshadows.scene.model import Mesh, Node, Scene
from softshadows.scene.shot import load_shot, open_shot
from softshadows.techniques import Bands, VariablePenumbra, make_technique

WHOLE = """
scene = "figures"
size = [320, 240]
ground = true
[camera]
position = [4.5, 2.5, 5.5]
target = [0.4, -0.9, 0]
vertical_fov = 40.0
[[lights]]
type = "rect"
position = [2.5, 4.5, 3.0]
target = [0.4, -0.8, 0.0]
width = 1.5
height = 1
radiance = [40.0, 40.0, 40.0]
[[lights]]
type = "line"
start = [-1, 4, 0]
end = [1, 4, 0]
radiance = [10, 10, 10]
[technique]
name = "uniform"
grid = 9
weights = "equal"
"""

LIGHT = 'type = "rect"\nposition = [2, 4, 3]\ntarget = [0, 0, 0]\nwidth = 1.5\nheight = 1\nradiance = [40, 40, 40]\n'

MISTAKES = {
    # what is written: (pointer, what the sentence says)
    'scene = "nowhere"': ("scene", "built in are blocker"),
    "size = [10, 10]": ("scene", "needs 'scene'"),
    "scene = 3": ("scene", "text"),
    'scene = "figures"\nsizes = [1, 2]': ("sizes", "legal are scene, size, ground, camera, lights, technique"),
    'scene = "figures"\nsize = [0, 10]': ("size", "from 1 to"),
    'scene = "figures"\nsize = [10.5, 10]': ("size", "width, height"),
    'scene = "figures"\nsize = "10x10"': ("size", "width, height"),
    'scene = "figures"\nground = 1': ("ground", "true or false"),
    'scene = "figures"\ncamera = 1': ("camera", "table"),
    'scene = "figures"\n[camera]\nposition = [1, 2, 3]': ("camera.target", "needs 'target'"),
    'scene = "figures"\n[camera]\nposition = [1, 2]\ntarget = [0, 0, 0]': ("camera.position", "three numbers"),
    'scene = "figures"\n[camera]\nposition = ["1", 2, 3]\ntarget = [0, 0, 0]': ("camera.position", "three numbers"),
    'scene = "figures"\n[camera]\nposition = [inf, 2, 3]\ntarget = [0, 0, 0]': ("camera.position", "finite"),
    'scene = "figures"\n[camera]\nposition = [1, 2, 3]\ntarget = [1, 2, 3]': ("camera.target", "differ"),
    'scene = "figures"\n[camera]\nposition = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 3': ("camera.fov", "vertical_fov"),
    'scene = "figures"\n[lights]\ntype = "rect"': ("lights", "[[lights]]"),
    'scene = "figures"\n[[lights]]\nwidth = 1': ("lights[0].type", "needs 'type'"),
    'scene = "figures"\n[[lights]]\ntype = "sun"': ("lights[0].type", "rect, disk, line"),
    'scene = "figures"\n[[lights]]\ntype = "rect"': ("lights[0].position", "needs 'position'"),
    f'scene = "figures"\n[[lights]]\n{LIGHT.replace("1.5", "-1")}': ("lights[0].width", "[0,"),
    f'scene = "figures"\n[[lights]]\n{LIGHT.replace("1.5", "nan")}': ("lights[0].width", "[0,"),
    f'scene = "figures"\n[[lights]]\n{LIGHT.replace("1.5", "1" + "0" * 400)}': ("lights[0].width", "too large"),
    f'scene = "figures"\n[[lights]]\n{LIGHT}two_sided = 1': ("lights[0].two_sided", "true or false"),
    f'scene = "figures"\n[[lights]]\n{LIGHT}[[lights]]\n{LIGHT}radius = 1': (
        "lights[1].radius",
        "legal are type, position",
    ),
    'scene = "figures"\n[technique]\ngrid = 3': ("technique.name", "needs 'name'"),
    'scene = "figures"\n[technique]\nname = "uniform"\ngrid = {}': ("technique.grid", "number"),
    'scene = "figures"\n[technique]\nname = "uniform"\n[technique.visibility.more]': (
        "technique.visibility.more",
        "number",
    ),
    "scene = ": (None, "not valid TOML"),
    "a = " + "[" * 5000: (None, "not valid TOML"),
}


def written(folder: Path, text: str) -> Path:
    file = folder / "picture.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_whole_shot(tmp_path: Path) -> None:
    shot = load_shot(written(tmp_path, WHOLE))
    assert shot.size == (320, 240)
    assert shot.camera == Camera((4.5, 2.5, 5.5), (0.4, -0.9, 0.0), 40.0) == shot.scene.camera
    assert shot.scene.lights == [
        RectLight((2.5, 4.5, 3.0), (0.4, -0.8, 0.0), 1.5, 1.0, (40.0, 40.0, 40.0)),
        LineLight((-1, 4, 0), (1, 4, 0), (10, 10, 10)),
    ]
    assert shot.technique is not None
    assert (shot.technique.name, shot.technique.options) == ("uniform", {"grid": 9, "weights": "equal"})
    assert shot.scene.nodes[-1].name == "ground"
    assert shot.name == "picture"
    assert shot.notes == []


def test_a_shot_names_a_preset_and_the_options_of_a_choice(tmp_path: Path) -> None:
    text = 'scene = "room"\n[technique]\nname = "variable_penumbra"\npreset = "paper"\n[technique.kernels]\n'
    shot = load_shot(written(tmp_path, text + 'type = "bands"\nsizes = [2, 3, 5]\nedges = "0.1 0.2 0.3"'))
    assert shot.technique is not None
    made = make_technique(shot.technique.name, shot.technique.options)
    kernels = Bands(sizes=(2, 3, 5), edges=(0.1, 0.2, 0.3))
    assert made == VariablePenumbra(kernels=kernels, self_shadowing=False)


def test_a_short_shot_uses_the_scenes_own_camera_and_lights(tmp_path: Path) -> None:
    shot = load_shot(written(tmp_path, 'scene = "room"'))
    room = builtin.room()
    assert shot.camera == room.camera
    assert shot.scene.lights == room.lights
    assert shot.technique is None


@pytest.mark.parametrize("text", MISTAKES, ids=lambda text: text[-40:].replace("\n", " "))
def test_every_mistake_names_file_and_key(tmp_path: Path, text: str) -> None:
    pointer, sentence = MISTAKES[text]
    with pytest.raises(SceneError) as caught:
        load_shot(written(tmp_path, text))
    assert caught.value.pointer == pointer
    assert caught.value.file == str(tmp_path / "picture.toml")
    assert caught.value.code
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read_are_scene_errors(tmp_path: Path) -> None:
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "huge.toml").write_bytes(b"#" * (2 << 20))
    for name in ("missing.toml", ".", "binary.toml", "huge.toml", "nul\0byte.toml"):
        with pytest.raises(SceneError):
            load_shot(tmp_path / name)


def test_arguments_replace_what_the_shot_says(tmp_path: Path) -> None:
    camera, light = Camera((1, 2, 3), (0, 0, 0)), LineLight((0, 3, 0), (1, 3, 0), (1, 1, 1))
    shot = open_shot(written(tmp_path, WHOLE), camera=camera, lights=[light], size=(8, 6))
    assert (shot.camera, shot.scene.lights, shot.size) == (camera, [light], (8, 6))


def test_built_in_scenes_open_by_name() -> None:
    assert open_shot("blocker").scene.name == "blocker"
    with pytest.raises(SceneError, match="atrium"):
        open_shot("blokcer")


def test_a_model_without_camera_or_light_gets_both(tmp_path: Path) -> None:
    (tmp_path / "model.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    shot = open_shot(tmp_path / "model.obj", ground=True)
    assert len(shot.scene.lights) == 1
    assert len(shot.notes) >= 2
    assert all("\n" not in note for note in shot.notes)


@pytest.mark.parametrize("extent", [(1.0, 1.0, 1.0), (100.0, 0.1, 3.0), (0.001, 0.002, 0.001), (0.0, 5.0, 0.0)])
def test_framing_holds_the_whole_scene(extent: tuple[float, float, float]) -> None:
    corners = np.array(np.meshgrid(*([-e, e] for e in extent))).reshape(3, -1).T + 7.0
    scene = Scene([Node(Mesh(corners, np.array([[0, 1, 2]], np.uint32)))])
    camera = framing_camera(scene, aspect=1.5)
    local = (corners - camera.position) @ camera.axes.T
    tangent = np.tan(np.radians(camera.vertical_fov / 2))
    assert (local[:, 2] < 0).all()
    assert (np.abs(local[:, 1] / local[:, 2]) < tangent).all()
    assert (np.abs(local[:, 0] / local[:, 2]) < 1.5 * tangent).all()
    assert complete(scene)


def test_an_empty_scene_cannot_be_framed() -> None:
    with pytest.raises(SceneError):
        complete(Scene())


def test_command_line_texts() -> None:
    rect = RectLight((0, 4, 0), (0, 0, 0), 1.0, 0.5, (10, 9, 8), two_sided=True)
    text = "rect:position=0,4,0:target=0,0,0:width=1:height=.5:radiance=10,9,8:two_sided=true"
    assert light_from_text(text) == light_from_text(text.replace(":", ";").replace("rect;", "rect:")) == rect
    assert light_from_text("line:start=-1,4,0:end=1,4,0:radiance=1,1,1") == LineLight((-1, 4, 0), (1, 4, 0), (1, 1, 1))
    assert camera_from_text("position=4,2,5;target=0,1,0;fov=30") == Camera((4, 2, 5), (0, 1, 0), 30.0)
    assert size_from_text("1024x768") == (1024, 768)


@pytest.mark.parametrize(
    ("parse", "text", "expected"),
    [
        (light_from_text, "", "--light:type"),
        (light_from_text, "sun:position=0,0,0", "rect, disk, line"),
        (light_from_text, "rect", "--light:position"),
        (light_from_text, "rect:position", "key=value"),
        (light_from_text, "line:start=0,1,0:start=0,1,0", "twice"),
        (light_from_text, "line:start=0,1:end=0,1,2:radiance=1,1,1", "--light:start"),
        (light_from_text, "line:start=0,1,x:end=0,1,2:radiance=1,1,1", "three numbers"),
        (camera_from_text, "position=0,0,0", "--camera:target"),
        (camera_from_text, "position=1,1,1:target=0,0,0:zoom=3", "legal are position"),
        (size_from_text, "1024", "1024x768"),
        (size_from_text, "0x5", "from 1"),
        (size_from_text, "99999x5", "16384"),
    ],
)
def test_bad_command_line_texts_name_the_option(parse, text: str, expected: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse(text)
    assert expected in str(caught.value)


@pytest.mark.scenes
def test_the_real_shots_load() -> None:
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if not folder:
        pytest.skip("SOFTSHADOWS_SCENES is not set: no real scenes to load")
    shot = load_shot(Path(folder) / "shots" / "bunny.toml")
    assert shot.size == (1024, 768)
    assert shot.scene.triangle_count > 1000
