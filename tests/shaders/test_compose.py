"""WGSL put together from files: includes once, circles and gaps refused, errors at the line they were written on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import wgpu

import softshadows.renderer  # noqa: F401 - every struct that the package's shaders name
from softshadows.errors import ShaderError
from softshadows.gpu.compose import PACKAGE, compose, shader_module
from softshadows.gpu.device import acquire
from softshadows.gpu.layout import F32, Struct, Vec3f

FILES = Path(__file__).parent / "includes"


class Pair(Struct):
    first: Vec3f
    second: F32


def test_every_file_is_included_once_and_the_result_runs() -> None:
    source = compose(FILES / "outer.wgsl")
    assert source.text.count("const ANSWER") == 1
    assert source.text.count("fn doubled") == 1
    assert run(FILES / "outer.wgsl") == 126


def run(path: Path) -> int:
    device = acquire().device
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    result = device.create_buffer(size=16, usage=usage)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": shader_module(device, compose(path), path.name), "entry_point": "cs_test"}
    )
    entries = [{"binding": 0, "resource": {"buffer": result}}]
    bindings = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(1)
    compute.end()
    device.queue.submit([encoder.finish()])
    return int(np.frombuffer(device.queue.read_buffer(result), np.uint32)[0])


def test_every_line_remembers_where_it_came_from() -> None:
    source = compose(FILES / "outer.wgsl")
    lines = source.text.splitlines()
    assert len(lines) == len(source.origin)
    for line, (file, number) in zip(lines, source.origin, strict=True):
        assert (FILES / file).read_text(encoding="utf-8").splitlines()[number - 1] == line


@pytest.mark.parametrize(
    ("file", "chain"),
    [("circular_a.wgsl", "circular_a.wgsl -> circular_b.wgsl -> circular_a.wgsl"),
     ("circular_self.wgsl", "circular_self.wgsl -> circular_self.wgsl")],
)  # fmt: skip
def test_circles_are_refused_with_their_chain(file: str, chain: str) -> None:
    with pytest.raises(ShaderError, match=chain):
        compose(FILES / file)


def test_a_missing_include_is_named_with_its_line_and_where_it_was_sought() -> None:
    with pytest.raises(ShaderError, match=r"missing\.wgsl:2: .*nowhere\.wgsl") as error:
        compose(FILES / "missing.wgsl")
    assert str(PACKAGE) in str(error.value)
    assert str(FILES) in str(error.value)


def test_structs_are_declared_once_and_unknown_ones_refused(tmp_path: Path) -> None:
    shader = tmp_path / "twice.wgsl"
    shader.write_text("//#struct Pair\n//#struct Pair\n", encoding="utf-8")
    source = compose(shader)
    assert source.text == "struct Pair {\n    first: vec3f,\n    second: f32,\n};\n"
    shader.write_text("\n//#struct Triplet\n", encoding="utf-8")
    with pytest.raises(ShaderError, match=r"twice\.wgsl:2: no struct 'Triplet'.*Pair"):
        compose(shader)


def test_two_structs_of_one_name_are_refused() -> None:
    with pytest.raises(AssertionError, match="two structs are called Pair"):
        type("Pair", (Struct,), {"__module__": "elsewhere", "__annotations__": {"third": F32}})


def test_a_stand_in_is_included_in_place_of_a_file_that_is_included() -> None:
    real = {"visibility/rays/cutouts.wgsl": "visibility/rays/no_cutouts.wgsl"}
    occluded = PACKAGE / "visibility/rays/occluded.wgsl"
    files = {file for file, _ in compose(occluded, real).origin}
    assert "visibility/rays/no_cutouts.wgsl" in files
    assert "visibility/rays/cutouts.wgsl" not in files


def test_a_stand_in_for_what_nothing_includes_is_refused() -> None:
    with pytest.raises(ShaderError, match=r"nothing includes what visibility/rays/no_cutouts\.wgsl"):
        compose(FILES / "outer.wgsl", {"visibility/rays/cutouts.wgsl": "visibility/rays/no_cutouts.wgsl"})


def test_compile_errors_name_the_file_and_line_they_were_written_on() -> None:
    with pytest.raises(ShaderError, match=r"broken\.wgsl does not compile") as error:
        shader_module(acquire().device, compose(FILES / "broken.wgsl"), "broken.wgsl")
    assert "broken_part.wgsl:4:" in str(error.value)
    assert "third" in str(error.value)


def test_extensions_come_before_everything_else() -> None:
    source = compose(FILES / "enable_late.wgsl")
    assert source.text.splitlines()[0] == "enable clip_distances;"
    assert source.origin[0] == ("enable_part.wgsl", 1)
    assert "const FIRST" in source.text
    assert "const SECOND" in source.text


def test_only_whole_line_directives_count(tmp_path: Path) -> None:
    shader = tmp_path / "comment.wgsl"
    text = '// see //#include "nowhere.wgsl"\n    //#include "nowhere.wgsl"\nconst A = 1u;\n'
    shader.write_text(text, encoding="utf-8")
    assert compose(shader).text == text
