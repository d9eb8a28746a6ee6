"""Entry points of shaders with their resources bound by name.

    average = Program(gpu, "techniques/adaptive/average.wgsl", "cs_average", {"light": …, "visibility": …})
    average.dispatch(compute, (width // 8, height // 8))

`@group` and `@binding` stand in the WGSL alone, where they are read from; so are the resources' kinds, so that a
pipeline's layout is made from the shader (`layout="auto"`). Modules and pipelines are kept on the device by path,
stand-ins, entry and constants: a second renderer compiles nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from typing import Any

import wgpu

from softshadows.errors import ShaderError
from softshadows.gpu.compose import PACKAGE, Source, compose, shader_module
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer


@dataclass(frozen=True)
class Slice:
    """`size` bytes of a buffer from `offset` on, which is a multiple of 256."""

    buffer: wgpu.GPUBuffer
    offset: int
    size: int


Resource = wgpu.GPUBuffer | GrowingBuffer | wgpu.GPUTexture | wgpu.GPUTextureView | Slice
Pass = wgpu.GPUComputePassEncoder | wgpu.GPURenderPassEncoder | wgpu.GPURenderBundleEncoder

_VARIABLE = re.compile(r"@group\((\d+)\)\s*@binding\((\d+)\)\s*var(?:<[^>]*>)?\s+(\w+)\s*:")
_GLOBAL = re.compile(
    r"^(?:@\w+(?:\([^)]*\))?\s+)*(?:fn|const|override|var(?:<[^>]*>)?|struct|alias)\s+(\w+)", re.MULTILINE
)
_COMMENT = re.compile(r"//[^\n]*")
_WORD = re.compile(r"(?<![.\w])[A-Za-z_]\w*")  # no member of a struct
_LOCAL = re.compile(r"([A-Za-z_]\w*)\s*:(?!:)|\b(?:let|var|const)\s+([A-Za-z_]\w*)")
"""Parameters, variables and fields, which may have a resource's name."""


@dataclass(frozen=True)
class Shader:
    """A composed file: its source, where its resources are bound, and what each of its declarations mentions."""

    name: str
    source: Source
    places: Mapping[str, tuple[int, int]]
    mentions: Mapping[str, frozenset[str]]

    def resources_of(self, *entries: str) -> set[str]:
        """The names of the resources that the entry points use, directly or not."""
        used: set[str] = set()
        waiting = list(entries)
        while waiting:
            name = waiting.pop()
            if name not in used:
                used.add(name)
                waiting += self.mentions.get(name, ())
        return used & self.places.keys()


@cache
def load_shader(path: str, stand_ins: frozenset[tuple[str, str]] = frozenset()) -> Shader:
    """The shader at `path` from the package's folder, composed. Raises ShaderError as compose.py."""
    source = compose(PACKAGE / path, dict(stand_ins))
    text = _COMMENT.sub("", source.text)
    places = {match[3]: (int(match[1]), int(match[2])) for match in _VARIABLE.finditer(text)}
    words = words_by_declaration(text)
    names = words.keys() | places.keys()
    return Shader(path, source, places, {name: found & names for name, found in words.items()})


def words_by_declaration(text: str) -> dict[str, frozenset[str]]:
    """By declaration of a module without comments: the words in it, but its own parameters, variables and fields."""
    starts = [*_GLOBAL.finditer(text)]
    ends = [match.start() for match in starts[1:]]
    words: dict[str, frozenset[str]] = {}
    for match, end in zip_longest(starts, ends):
        body = text[match.end() : end]
        words[match[1]] = frozenset(_WORD.findall(body)) - {name for local in _LOCAL.findall(body) for name in local}
    return words


class _Group:
    """A bind group, made again where one of its buffers has grown."""

    def __init__(self, create: Callable[[], wgpu.GPUBindGroup], growing: list[GrowingBuffer]) -> None:
        self._create, self._growing = create, growing
        self._bound, self._bindings = self._buffers, create()

    @property
    def _buffers(self) -> list[wgpu.GPUBuffer]:
        return [each.buffer for each in self._growing]

    @property
    def bindings(self) -> wgpu.GPUBindGroup:
        if self._bound != self._buffers:
            self._bound, self._bindings = self._buffers, self._create()
        return self._bindings


def declared(
    path: str, resources: Mapping[str, Resource], stand_ins: Mapping[str, str] | None = None
) -> dict[str, Resource]:
    """Those of the resources that a shader declares: for folders whose programs each take a few of many."""
    places = load_shader(path, _frozen(stand_ins)).places
    return {name: resource for name, resource in resources.items() if name in places}


class Bindings:
    """Bind groups of a program, ready to be set."""

    def __init__(self, groups: Mapping[int, _Group]) -> None:
        self._groups = groups

    def set(self, encoder: Pass) -> None:
        """Make them the pass's own."""
        for number, group in self._groups.items():
            encoder.set_bind_group(number, group.bindings)


class _Program:
    """What compute and draw programs share: a pipeline, and resources by name."""

    def __init__(self, gpu: Gpu, shader: Shader, entries: tuple[str, ...], pipeline: Any, resources: Any) -> None:
        self._gpu, self._shader, self._pipeline = gpu, shader, pipeline
        self._used = shader.resources_of(*entries)
        self._resources: dict[str, Resource] = self._checked(resources)
        self._groups: dict[int, _Group] = {}
        missing = self._used - self._resources.keys()
        self._later = {shader.places[name][0] for name in missing}  # groups that `bind` completes
        for group in {shader.places[name][0] for name in self._used} - self._later:
            self._groups[group] = self._bind_group(group, self._resources)

    def _checked(self, resources: Mapping[str, Resource]) -> dict[str, Resource]:
        unknown = resources.keys() - self._shader.places.keys()
        if unknown:
            raise ShaderError(
                f"{self._shader.name} declares no {', '.join(sorted(unknown))}; it declares "
                f"{', '.join(self._shader.places)}"
            )
        return {name: resource for name, resource in resources.items() if name in self._used}

    def _bind_group(self, group: int, resources: Mapping[str, Resource]) -> _Group:
        bound: dict[int, Resource] = {}
        for name in sorted(self._used):
            if self._shader.places[name][0] != group:
                continue
            if name not in resources:
                raise ShaderError(f"{self._shader.name}: nothing is bound to {name}")
            bound[self._shader.places[name][1]] = resources[name]
        layout = self._pipeline.get_bind_group_layout(group)

        def create() -> wgpu.GPUBindGroup:
            entries = [{"binding": binding, "resource": _entry(resource)} for binding, resource in bound.items()]
            return self._gpu.device.create_bind_group(layout=layout, entries=entries)

        return _Group(create, [resource for resource in bound.values() if isinstance(resource, GrowingBuffer)])

    def bind(self, **changing: Resource) -> Bindings:
        """Bindings in which some resources are others than, or come beside, those that the program was made with.

        Raises ShaderError for a name that the shader does not declare, or a resource that is still missing.
        """
        resources = {**self._resources, **self._checked(changing)}
        changed = {self._shader.places[name][0] for name in changing.keys() & self._used} | self._later
        return Bindings({**self._groups, **{group: self._bind_group(group, resources) for group in sorted(changed)}})

    def _begin(self, encoder: Any, bindings: Bindings | None) -> None:
        if bindings is None and self._later:
            raise ShaderError(f"{self._shader.name}: groups {sorted(self._later)} are not bound; use bind()")
        encoder.set_pipeline(self._pipeline)
        (bindings or Bindings(self._groups)).set(encoder)


def view_of(texture: wgpu.GPUTexture) -> wgpu.GPUTextureView:
    """A view of the whole texture, for passes that draw into it; a program may be given the texture itself."""
    return texture.create_view()


def _entry(resource: Resource) -> Any:
    match resource:
        case Slice(buffer, offset, size):
            return {"buffer": buffer, "offset": offset, "size": size}
        case wgpu.GPUBuffer():
            return {"buffer": resource}
        case GrowingBuffer(buffer=buffer):
            return {"buffer": buffer}
        case wgpu.GPUTexture():
            return view_of(resource)
        case _:
            return resource


class Program(_Program):
    """A compute entry point. Resources that change from dispatch to dispatch may be left to `bind`."""

    def __init__(
        self,
        gpu: Gpu,
        path: str,
        entry: str,
        resources: Mapping[str, Resource],
        *,
        constants: Mapping[str, float] | None = None,
        stand_ins: Mapping[str, str] | None = None,
    ) -> None:
        shader, module = _compiled(gpu, path, stand_ins)

        def create() -> wgpu.GPUComputePipeline:
            stage = {"module": module, "entry_point": entry, "constants": dict(constants or {})}
            return gpu.device.create_compute_pipeline(label=f"{path} {entry}", layout="auto", compute=stage)

        key = (path, _frozen(stand_ins), entry, _frozen(constants))
        super().__init__(gpu, shader, (entry,), _cached(gpu, key, create), resources)

    def begin(self, compute: wgpu.GPUComputePassEncoder, bindings: Bindings | None = None) -> None:
        """Make this the program that the pass's next dispatch runs."""
        self._begin(compute, bindings)

    def dispatch(
        self, compute: wgpu.GPUComputePassEncoder, groups: tuple[int, ...], bindings: Bindings | None = None
    ) -> None:
        """Run so many workgroups."""
        self._begin(compute, bindings)
        compute.dispatch_workgroups(*groups)

    def dispatch_indirect(
        self,
        compute: wgpu.GPUComputePassEncoder,
        arguments: wgpu.GPUBuffer,
        offset: int = 0,
        bindings: Bindings | None = None,
    ) -> None:
        """Run as many workgroups as three words of a buffer say."""
        self._begin(compute, bindings)
        compute.dispatch_workgroups_indirect(arguments, offset)


class DrawProgram(_Program):
    """A vertex and perhaps a fragment entry point.

    `state` holds what WebGPU's pipeline descriptor has besides stages and layout: primitive, depth_stencil;
    `vertex_buffers` and `targets` are those of its two stages.
    """

    def __init__(
        self,
        gpu: Gpu,
        path: str,
        vertex: str,
        fragment: str | None,
        resources: Mapping[str, Resource],
        *,
        state: Mapping[str, Any],
        vertex_buffers: list[dict] | None = None,
        targets: list[dict] | None = None,
        constants: Mapping[str, float] | None = None,
        stand_ins: Mapping[str, str] | None = None,
    ) -> None:
        shader, module = _compiled(gpu, path, stand_ins)

        def create() -> wgpu.GPURenderPipeline:
            shared = {"module": module, "constants": dict(constants or {})}
            pixels = None if fragment is None else {**shared, "entry_point": fragment, "targets": targets or []}
            return gpu.device.create_render_pipeline(
                label=f"{path} {vertex}",
                layout="auto",
                vertex={**shared, "entry_point": vertex, "buffers": vertex_buffers or []},
                fragment=pixels,
                **state,
            )

        key = (path, _frozen(stand_ins), vertex, fragment, repr((state, vertex_buffers, targets)), _frozen(constants))
        entries = (vertex,) if fragment is None else (vertex, fragment)
        super().__init__(gpu, shader, entries, _cached(gpu, key, create), resources)

    def begin(self, draw: wgpu.GPURenderPassEncoder | wgpu.GPURenderBundleEncoder) -> None:
        """Make this the program of the next draw."""
        self._begin(draw, None)


def _frozen(mapping: Mapping[str, Any] | None) -> frozenset[tuple[str, Any]]:
    return frozenset((mapping or {}).items())


def _cached(gpu: Gpu, key: object, create: Callable[[], Any]) -> Any:
    if key not in gpu.pipelines:
        gpu.pipelines[key] = create()
    return gpu.pipelines[key]


def _compiled(gpu: Gpu, path: str, stand_ins: Mapping[str, str] | None) -> tuple[Shader, wgpu.GPUShaderModule]:
    shader = load_shader(path, _frozen(stand_ins))
    return shader, _cached(gpu, (path, _frozen(stand_ins)), lambda: shader_module(gpu.device, shader.source, path))
