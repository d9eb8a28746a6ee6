"""The reference of the Python interface: every public name's signature and docstring, read from its source."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from typing import Any

from prose import prose

import softshadows as ss

WIDTH = 100
"""Characters of a signature before its arguments take lines of their own."""

GROUPS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "Rendering": (ss, ("render", "Renderer", "Frame", "FrameStats", "Images")),
    "Scenes": (ss, ("load_scene", "load_shot", "Shot", "Scene", "Node", "Mesh", "Material", "Texture")),
    "Camera and lights": (
        ss,
        ("Camera", "RectLight", "DiskLight", "LineLight", "PointLight", "SpotLight", "DirectionalLight"),
    ),
    "Techniques": (ss.techniques, ("Technique", "make_technique")),
    "Truth": (ss.truth, ("visibility", "visibility_from_points", "Occluders")),
    "Metrics": (ss.metrics, tuple(ss.metrics.__all__)),
    "Errors": (ss, ("SoftShadowsError", "SceneError", "OptionError", "DeviceError", "ShaderError")),
}
"""Sections of the page: the module that the names are looked up in, and the names."""

NOTES = {
    "Scenes": "`ss.scenes.figures()` and so on are the built-in scenes; `softshadows scenes` lists them.",
    "Techniques": "`ss.techniques.Pcss(blocker_samples=32)` and so on: the classes are on the "
    "[pages of the techniques](techniques/index.md), with their options.",
}


def reference_page() -> str:
    """The page, as Markdown."""
    parts = ["# Reference", "`import softshadows as ss`. Arrays are numpy's, row 0 at the top; lengths in metres."]
    for group, (module, names) in GROUPS.items():
        parts += [f"## {group}", *([NOTES[group]] if group in NOTES else [])]
        prefix = "ss." if module is ss else f"ss.{module.__name__.rpartition('.')[2]}."
        for name in names:
            parts += _entry(prefix + name, getattr(module, name))
    return "\n\n".join(parts) + "\n"


def _entry(name: str, thing: Any) -> Iterator[str]:
    """A class or a function under its public name."""
    (node,) = ast.parse(inspect.getsource(thing)).body
    yield f"### `{name}`"
    if isinstance(node, ast.FunctionDef):
        yield _signature(name, node)
        yield prose(ast.get_docstring(node) or "")
    elif isinstance(node, ast.ClassDef):
        yield from _class(name, node)


def _class(name: str, node: ast.ClassDef) -> Iterator[str]:
    fields = list(_fields(node))
    methods = [item for item in node.body if isinstance(item, ast.FunctionDef)]
    inits = [method for method in methods if method.name == "__init__"]
    if inits:
        yield _signature(name, inits[0])
    elif fields:
        yield _code(name, [text for text, _ in fields], "")
    yield prose(ast.get_docstring(node) or "")
    said = [f"- `{text.partition(':')[0]}`: {prose(about)}" for text, about in fields if about]
    if said:
        yield "\n".join(said)
    for method in methods:
        about = ast.get_docstring(method)
        if about and not method.name.startswith("_"):
            is_property = any(isinstance(one, ast.Name) and one.id == "property" for one in method.decorator_list)
            full = f"{name}.{method.name}"
            result = f" -> {ast.unparse(method.returns)}" if method.returns else ""
            yield f"```python\n{full}{result}\n```" if is_property else _signature(full, method)
            yield prose(about)


def _fields(node: ast.ClassDef) -> Iterator[tuple[str, str]]:
    """A dataclass's fields as they are declared, and the docstring below each, if any."""
    following = [*node.body[1:], None]
    for item, after in zip(node.body, following, strict=True):
        if not isinstance(item, ast.AnnAssign) or "ClassVar" in ast.unparse(item.annotation):
            continue
        text = f"{ast.unparse(item.target)}: {ast.unparse(item.annotation)}"
        if item.value is not None:
            text += f" = {'...' if isinstance(item.value, ast.Call) else ast.unparse(item.value)}"
        about = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
        yield text, str(about)


def _signature(name: str, node: ast.FunctionDef) -> str:
    arguments = _arguments(node.args)
    result = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__init__" else ""
    return _code(name, [text for text in arguments if text not in ("self", "cls")], result)


def _arguments(arguments: ast.arguments) -> list[str]:
    """Each argument with its type and default, and the signs between them."""
    positional = [*arguments.posonlyargs, *arguments.args]
    defaults = [None] * (len(positional) - len(arguments.defaults)) + list(arguments.defaults)
    written = [_argument(one, default) for one, default in zip(positional, defaults, strict=True)]
    if arguments.vararg:
        written.append("*" + _argument(arguments.vararg, None))
    elif arguments.kwonlyargs:
        written.append("*")
    named = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    return written + [_argument(one, default) for one, default in named]


def _argument(argument: ast.arg, default: ast.expr | None) -> str:
    text = argument.arg + (f": {ast.unparse(argument.annotation)}" if argument.annotation else "")
    return text if default is None else f"{text} = {ast.unparse(default)}"


def _code(name: str, arguments: list[str], result: str) -> str:
    line = f"{name}({', '.join(arguments)}){result}"
    if len(line) > WIDTH:
        line = f"{name}(\n" + "".join(f"    {argument},\n" for argument in arguments) + f"){result}"
    return f"```python\n{line}\n```"
