"""WGSL files put together: includes, generated structs, and compile errors that name the right file and line.

    //#include "shadow_map.wgsl"     that file once, looked for beside the including file, then in shaders/
    //#struct Light                  the WGSL declaration of the Python struct of that name, once

Both are comments, so an editor sees plain WGSL. A *stand-in* is included in place of a file with the same functions:
how one shader is built for maps, for rays or for both.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import wgpu

from softshadows.errors import ShaderError
from softshadows.gpu.layout import Struct, wgsl

SHADERS = Path(__file__).resolve().parent.parent / "shaders"
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


def compose(path: Path, structs: Sequence[type[Struct]] = (), stand_ins: Mapping[str, str] | None = None) -> Source:
    """The file with its includes and structs resolved. Raises ShaderError for a missing or circular include.

    `stand_ins` maps a file's name to that of the one that is included in its place.
    """
    replaced = dict(stand_ins or {})
    named = {struct.__name__: struct for struct in structs}
    lines: list[str] = []
    origin: list[tuple[str, int]] = []
    done: set[str] = set()

    def resolve(file: Path, open_files: tuple[Path, ...]) -> None:
        if file in open_files:
            chain = " -> ".join(part.name for part in (*open_files, file))
            raise ShaderError(f"circular include: {chain}")
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
            directive = _DIRECTIVE.match(line)
            if directive is None:
                lines.append(line)
                origin.append((file.name, number))
                continue
            kind, name = directive.groups()
            name = replaced.get(name, name)
            key = f"{kind} {name}"
            if kind == "struct":
                if name not in named:
                    raise ShaderError(f"{file.name}:{number}: no struct {name!r} was given; known: {sorted(named)}")
                if key not in done:
                    declaration = wgsl(named[name]).splitlines()
                    lines.extend(declaration)
                    origin.extend([(f"struct {name}", 1)] * len(declaration))
            else:
                candidates = [folder / name for folder in (file.parent, SHADERS)]
                found = next((candidate for candidate in candidates if candidate.is_file()), None)
                if found is None:
                    raise ShaderError(
                        f"{file.name}:{number}: include {name!r} was found in none of {[str(c) for c in candidates]}"
                    )
                if found in open_files or key not in done:
                    resolve(found, (*open_files, file))
            done.add(key)

    resolve(path, ())
    # Directives that enable extensions must come before everything else, wherever the file that needs them is included.
    enables = [index for index, line in enumerate(lines) if line.startswith("enable ")]
    order = enables + [index for index in range(len(lines)) if index not in set(enables)]
    return Source("\n".join(lines[i] for i in order) + "\n", [origin[i] for i in order])


def shader_module(
    device: wgpu.GPUDevice,
    path: Path,
    structs: Sequence[type[Struct]] = (),
    stand_ins: Mapping[str, str] | None = None,
) -> wgpu.GPUShaderModule:
    """The compiled file. Raises ShaderError with the compiler's message, file and line."""
    source = compose(path, structs, stand_ins)
    try:
        return device.create_shader_module(label=path.name, code=source.text)
    except wgpu.GPUError as error:
        raise ShaderError(f"{path.name} does not compile:\n{source.locate(str(error))}") from None
