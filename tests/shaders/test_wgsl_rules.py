"""What browsers demand of every shader and wgpu-native does not check: by the text alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import softshadows

SOURCE = Path(softshadows.__file__).parent
SHADERS = sorted(SOURCE.rglob("*.wgsl"))

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
TEMPLATE = re.compile(r"\b(?:array|atomic|bitcast|mat\dx\d|ptr|texture_\w+|var|vec\d)\s*(<[^<>;(){}]*>)")
TOKEN = re.compile(r"<<=|>>=|<<|>>|[-+*/%&|^<>=!]=|&&|\|\||->|\+\+|--|[A-Za-z_]\w*|\d[\w.]*(?:[eE][-+]?\d+)?|\S")

SHIFTS, BITWISE, LOGICAL = {"<<", ">>"}, {"&", "|", "^"}, {"&&", "||"}
RELATIONAL = {"<", ">", "<=", ">=", "==", "!="}
BINARY = {"+", "-", "*", "/", "%", *SHIFTS, *BITWISE, *LOGICAL, *RELATIONAL}
WORDS = {"return", "if", "while", "case", "else", "switch", "for", "in"}
"""After these an operator has only a right side."""

Expression = list[tuple[int, str]]
"""The binary operators between two brackets, commas, semicolons or assignments, each with its line."""


def plain(text: str) -> str:
    """Without comments and without template lists, whose angle brackets are no operators; the same lines."""
    text = COMMENT.sub(lambda match: "\n" * match[0].count("\n"), text)
    while TEMPLATE.search(text):  # from the inside out
        text = TEMPLATE.sub(lambda match: match[0][: match.start(1) - match.start()], text)
    return text


def expressions(text: str) -> list[Expression]:
    """The operators that stand in one pair of brackets, without those of brackets within."""
    found: list[Expression] = []
    open_ones: list[Expression] = [[]]
    before = ""
    for line, part in enumerate(plain(text).split("\n"), start=1):
        for token in TOKEN.findall(part):
            has_left = bool(re.fullmatch(r"[\w.]+|[)\]]", before)) and before not in WORDS
            if token in "([":
                open_ones.append([])
            elif token in ")]":
                found.append(open_ones.pop())
            elif token in BINARY and has_left:
                open_ones[-1].append((line, token))
            elif token in ",;{}:" or token in WORDS or (token.endswith("=") and token not in RELATIONAL):
                found.append(open_ones[-1])
                open_ones[-1] = []
            before = token
    assert len(open_ones) == 1, "brackets do not match"
    return [*found, open_ones[0]]


def problem(expression: Expression) -> str | None:
    """What WGSL's grammar refuses in it: &, | and ^ mix with nothing, && and || not with each other, and both sides of
    a shift are unary."""
    operators = {token for _, token in expression}
    if operators & BITWISE and len(operators) > 1:
        return f"{' '.join(sorted(operators))} without brackets"
    if operators >= LOGICAL:
        return "&& and || without brackets"
    part: list[str] = []
    for _, token in [*expression, (0, "&&")]:
        if token in RELATIONAL | LOGICAL:
            if len(part) > 1 and set(part) & SHIFTS:
                return f"{' '.join(part)} without brackets"
            part = []
        else:
            part.append(token)
    return None


def problems(text: str) -> list[str]:
    return [f"line {each[0][0]}: {found}" for each in expressions(text) if each and (found := problem(each))]


@pytest.mark.parametrize("path", SHADERS, ids=lambda path: path.relative_to(SOURCE).as_posix())
def test_operators_that_browsers_refuse_to_mix_have_brackets(path: Path) -> None:
    """`a | b << c` compiles in naga, against the language: each browser refuses it."""
    assert not problems(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "code",
    [
        "let a = b | c << d;",
        "let a = b << c | d;",
        "x &= f(b ^ c >> d);",
        "return b & c >> 1u;",
        "if (a & b) == 1u && a & b == 1u { }",
        "let a = x[b << c + 1u];",
        "let a = b << c << d;",
        "let a = b & c | d;",
        "let a = b && c || d;",
        "let a = (b | c)\n    >> 1u & 1u;",
        "let a = bitcast<u32>(b) >> 1u & 1u;",
        "let a = !b & -c + d;",
    ],
)
def test_the_check_of_operators_can_fail(code: str) -> None:
    assert problems(code)


@pytest.mark.parametrize(
    "code",
    [
        "let a = b | (c << d);",
        "let a = b | c | d;",
        "x |= 1u << (a + b);",
        "x <<= a + b; y = a + b; z = b & c;",
        "let a = f(b << c, d & e, &g) | h;",
        "var<storage, read> a: array<vec2<u32>, 4>; // b | c << d",
        "let a = bitcast<u32>(b) >> 1u; /* a & b\n << c */ let b = array<atomic<u32>>(a & -b, ~c & !d);",
        "if a < b && c >= d << 1u { }",
        "for (var i = 0u; i < n && i != 3u; i++) { a[i] = b & c; }",
        "fn f(a: ptr<function, vec2<f32>>) -> u32 { return 1u << (*a).x; }",
        "let a = (b & c) == 0u || (b >> 1u) + 1u < 4u;",
        "let a = x + -y * z / 2.5e-3 - w;",
    ],
)
def test_the_check_of_operators_lets_the_rest_pass(code: str) -> None:
    assert not problems(code)


def workgroup_atomics(text: str) -> list[str]:
    """The names of the workgroup's variables with an atomic in their type."""
    found = re.findall(r"var<workgroup>\s*(\w+)\s*:\s*([^;]+);", COMMENT.sub("", text))
    return [name for name, kind in found if "atomic" in kind]


def is_stored(text: str, name: str) -> bool:
    return bool(re.search(rf"\batomicStore\(\s*&\s*{name}\b", COMMENT.sub("", text)))


@pytest.mark.parametrize("path", SHADERS, ids=lambda path: path.relative_to(SOURCE).as_posix())
def test_the_workgroups_atomics_are_stored(path: Path) -> None:
    """WebGPU clears a workgroup's memory at its start; wgpu-native here does not. Only that the file stores them, not
    that it does so before it uses them."""
    text = path.read_text(encoding="utf-8")
    assert not [name for name in workgroup_atomics(text) if not is_stored(text, name)]


def test_the_check_of_atomics_can_fail() -> None:
    code = "var<workgroup> a: atomic<u32>;  // atomicStore(&a, 0u)\nvar<workgroup> b: array<atomic<u32>, 4>;\n"
    code += "fn f() { atomicStore(&b[lane], 0u); atomicStore(&ab, 0u); }"
    assert workgroup_atomics(code) == ["a", "b"]
    assert not is_stored(code, "a")
    assert is_stored(code, "b")
    assert sum(len(workgroup_atomics(path.read_text(encoding="utf-8"))) for path in SHADERS) >= 3
