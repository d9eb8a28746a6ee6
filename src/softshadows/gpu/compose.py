"""WGSL files put together: includes, generated structs, and compile errors that name the right file and line.

    //#include "receiver.wgsl"       that file once: beside the including file, or by its path from the package's folder
    //#struct Light                  the WGSL declaration of the Python struct of that name (layout.py), once
    //#needs light, taps             what the file uses and leaves to its includer to declare (read by a test alone)

All are comments, so an editor sees plain WGSL. A *stand-in* is included in place of a file with the same functions:
how one shader is built for maps, for rays or for both.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import wgpu

from softshadows.errors import ShaderError
from softshadows.gpu.layout import nested, struct_named, wgsl

PACKAGE = Path(__file__).resolve().parent.parent
"""Where paths of includes and stand-ins begin."""
_DIRECTIVE = re.compile(r'^//#(include|struct)\s+"?([\w./]+)"?\s*$')
_ERROR_LINE = re.compile(r"wgsl:(\d+):(\d+)")


@dataclass(frozen=True)
class Source:
    """Composed WGSL and, for each of its lines, the file and line it came from."""

    text: str
    origin: list[tuple[str, int]]

    def locate(self, message: str) -> str:
        """A compiler's message with `wgsl:line:column` replaced by the file and line that the line came from."""

        def place(match: re.Match[str]) -> str:
            file, line = self.origin[min(int(match[1]), len(self.origin)) - 1]
            return f"{file}:{line}:{match[2]}"

        return _ERROR_LINE.sub(place, message)


def compose(path: Path, stand_ins: Mapping[str, str] | None = None) -> Source:
    """The file with its includes and structs resolved.

    `stand_ins` maps a file's path from the package's folder to that of the one that is included in its place. Raises
    ShaderError for a missing or circular include, and for a stand-in whose file nothing includes.
    """
    replaced = {PACKAGE / old: PACKAGE / new for old, new in (stand_ins or {}).items()}
    lines: list[str] = []
    origin: list[tuple[str, int]] = []
    done: set[Path | str] = set()

    def declare(struct: str, where: str) -> None:
        if struct not in done:
            done.add(struct)
            for inner in nested(struct_named(struct, where)):
                declare(inner.__name__, where)
            declaration = wgsl(struct_named(struct, where)).splitlines()
            lines.extend(declaration)
            origin.extend([(f"struct {struct}", 1)] * len(declaration))

    def include(file: Path, open_files: tuple[Path, ...]) -> None:
        file = replaced.get(file, file)
        if file in open_files:
            chain = " -> ".join(label(part) for part in (*open_files, file))
            raise ShaderError(f"circular include: {chain}")
        if file in done:
            return
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
            where = f"{label(file)}:{number}"
            match _directive(line):
                case ("struct", name):
                    declare(name, where)
                case ("include", name):
                    include(_find(name, file.parent, where), (*open_files, file))
                case _:
                    lines.append(line)
                    origin.append((label(file), number))
        done.add(file)

    include(path.resolve(), ())
    unused = [label(new) for new in replaced.values() if new not in done]
    if unused:
        raise ShaderError(f"{label(path)}: nothing includes what {', '.join(unused)} would stand in for")
    # Directives that enable extensions must come before everything else, wherever the file that needs them is included.
    enables = [index for index, line in enumerate(lines) if line.startswith("enable ")]
    order = enables + [index for index in range(len(lines)) if index not in set(enables)]
    return Source("\n".join(lines[i] for i in order) + "\n", [origin[i] for i in order])


def constant(path: str, name: str) -> int:
    """The whole number that the shader at `path` declares as `const name = …u;`: what Python must know of it, too.

    Raises ShaderError where it declares none.
    """
    found = re.search(rf"^const {name} = (\d+)u;", (PACKAGE / path).read_text(encoding="utf-8"), re.MULTILINE)
    if found is None:
        raise ShaderError(f"{path} declares no constant {name}")
    return int(found[1])


def label(file: Path) -> str:
    """A shader's path from the package's folder; a file outside of it goes by its name."""
    return file.relative_to(PACKAGE).as_posix() if file.is_relative_to(PACKAGE) else file.name


def _directive(line: str) -> tuple[str, str] | None:
    match = _DIRECTIVE.match(line)
    return (match[1], match[2]) if match else None


def _find(name: str, folder: Path, where: str) -> Path:
    candidates = [(folder / name).resolve(), PACKAGE / name]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise ShaderError(f"{where}: include {name!r} was found in none of {[str(place) for place in candidates]}")


def shader_module(device: wgpu.GPUDevice, source: Source, name: str) -> wgpu.GPUShaderModule:
    """The compiled source, labelled `name`. Raises ShaderError with the compiler's message, file and line."""
    try:
        return device.create_shader_module(label=name, code=source.text)
    except wgpu.GPUError as error:
        raise ShaderError(f"{name} does not compile:\n{source.locate(str(error))}") from None
