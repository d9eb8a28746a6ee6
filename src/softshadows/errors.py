"""The exceptions a user of softshadows can meet: each says what was expected, what came, and what to do.

SoftShadowsError
  SceneError     a file, mesh, light, camera or shot that cannot be used
  OptionError    an option with an unknown name or a value out of range
  DeviceError    no adapter, a missing feature, too little memory, a lost device
  ShaderError    a shader that does not compile (a bug of ours, or of a technique being written)
"""

from __future__ import annotations

from pathlib import Path


class SoftShadowsError(Exception):
    """Base class of every exception softshadows raises on purpose."""


class SceneError(SoftShadowsError):
    """A scene, or a file that describes one, cannot be used.

    `code` follows the Khronos glTF validator's names where one exists (`NODE_LOOP`, `ACCESSOR_INDEX_OOB` ...),
    `pointer` is the JSON pointer (or line, or key) inside `file`. Each may be None where it has no meaning.
    """

    def __init__(
        self, message: str, *, code: str | None = None, file: str | Path | None = None, pointer: str | None = None
    ) -> None:
        self.message, self.code, self.pointer = message, code, pointer
        self.file = None if file is None else str(file)
        where = ":".join(part for part in (self.file, pointer) if part)
        super().__init__(f"{where}: " * bool(where) + message + f" [{code}]" * bool(code))


class OptionError(SoftShadowsError, ValueError):
    """An option has an unknown name or an illegal value."""


class DeviceError(SoftShadowsError):
    """The GPU (or its software stand-in) cannot do what was asked."""


class ShaderError(SoftShadowsError):
    """A shader failed to compile; the message names the .wgsl file and line."""
