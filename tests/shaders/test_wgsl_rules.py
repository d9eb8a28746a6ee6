"""What browsers demand of every shader and wgpu-native does not check: by the text alone."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

import softshadows.renderer
from softshadows.gpu.compose import compose
from softshadows.gpu.program import words_by_declaration

SOURCE = Path(softshadows.__file__).parent
SHADERS = sorted(SOURCE.rglob("*.wgsl"))
TEXTS = {path.relative_to(SOURCE).as_posix(): path.read_text(encoding="utf-8") for path in SHADERS}

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


def test_operators_that_browsers_refuse_to_mix_have_brackets() -> None:
    """`a | b << c` compiles in naga, against the language: each browser refuses it."""
    found = {name: problems(text) for name, text in TEXTS.items()}
    assert not {name: lines for name, lines in found.items() if lines}


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


def test_the_workgroups_atomics_are_stored() -> None:
    """WebGPU clears a workgroup's memory at its start; wgpu-native here does not. Only that the file stores them, not
    that it does so before it uses them."""
    atomics = [(file, text, name) for file, text in TEXTS.items() for name in workgroup_atomics(text)]
    assert len(atomics) >= 3
    assert not [f"{file}: {name}" for file, text, name in atomics if not is_stored(text, name)]


def test_the_check_of_atomics_can_fail() -> None:
    code = "var<workgroup> a: atomic<u32>;  // atomicStore(&a, 0u)\nvar<workgroup> b: array<atomic<u32>, 4>;\n"
    code += "fn f() { atomicStore(&b[lane], 0u); atomicStore(&ab, 0u); }"
    assert workgroup_atomics(code) == ["a", "b"]
    assert not is_stored(code, "a")
    assert is_stored(code, "b")


# -- What Mesa's software driver builds into machine code --------------------------------------------------------------

SCALARS = {"f32", "u32", "i32"}
FUNCTION = re.compile(r"\bfn\s+(\w+)\s*\(([^)]*\)?)[^{]*\{")
DECLARATION = re.compile(r"(?<!for \()\b(?:let|var)\s+(\w+)(?:\s*:[^=;]*)?\s*=\s*([^;]*);")
NAME = re.compile(r"(?<![.\w])([A-Za-z_]\w*)\b(\(\))?(?!\s*\()")
"""A variable, or a call without arguments; no member of a struct."""


def uniform_scalars(text: str) -> re.Pattern[str]:
    """What reads one scalar of a `var<uniform>`: a scalar member, or a part of a vector."""
    patterns = []
    for name, kind in re.findall(r"var<uniform>\s+(\w+)\s*:\s*([\w<>]+)", text):
        struct = re.search(rf"\bstruct\s+{kind}\s*\{{(.*?)\}}", text, re.DOTALL)
        for member, member_type in re.findall(r"(\w+)\s*:\s*([\w<>]+)", struct[1]) if struct else [("", kind)]:
            path = rf"{name}\.{member}\b" if member else rf"{name}\b"
            patterns.append(path if member_type in SCALARS else rf"{path}(?:\.[xyzwrgba]\b|\[)")
    return re.compile(rf"(?<![.\w])(?:{'|'.join(patterns) or '(?!)'})")


def conditions(text: str) -> list[tuple[int, str]]:
    """What if, while, for, switch and break if hang on, each with the place where it begins."""
    found = [(match.start(1), match[1]) for match in re.finditer(r"\b(?:if|while|switch)\b([^{;]*)", text)]
    return found + [(match.start(1), match[1]) for match in re.finditer(r"\bfor\s*\([^;]*;([^;]*);", text)]


def values_compiled_in(text: str) -> dict[str, list[int]]:
    """The scalars of uniforms that a condition mentions, with the lines: by themselves, by a variable that is made of
    them alone, or by a function without parameters that reads them. `text` is composed."""
    text = COMMENT.sub(lambda match: "\n" * match[0].count("\n"), text)
    pattern = uniform_scalars(text)
    constant = set(re.findall(r"(?:\bconst|\boverride|var<uniform>)\s+(\w+)", text))
    stand_for: dict[str, set[str]] = {}  # variables and calls, to the scalars that they hang on

    def scalars_in(expression: str) -> set[str]:
        names = {"".join(name) for name in NAME.findall(expression)}
        return set(pattern.findall(expression)).union(*(stand_for[name] for name in names & stand_for.keys()))

    def is_made_of_scalars(expression: str) -> bool:
        return not {name for name, call in NAME.findall(expression) if not call} - constant - stand_for.keys()

    found: dict[str, list[int]] = {}
    starts = [*FUNCTION.finditer(text)]
    ends = [match.start() for match in starts[1:]]
    for match, end in itertools.zip_longest(starts, ends):
        body = text[match.end() : end]
        stand_for = {name: scalars for name, scalars in stand_for.items() if name.endswith("()")}
        for name, value in DECLARATION.findall(body):
            if is_made_of_scalars(value) and (scalars := scalars_in(value)):
                stand_for[name] = scalars
        for offset, condition in conditions(body):
            for scalar in scalars_in(condition):
                found.setdefault(scalar, []).append(text.count("\n", 0, match.end() + offset) + 1)
        if match[2].strip() == ")" and (scalars := scalars_in(body)):
            stand_for[f"{match[1]}()"] = scalars
    return found


def all_values_compiled_in() -> dict[str, set[str]]:
    """The offenders of every shader, with the files and lines where they stand."""
    found: dict[str, set[str]] = {}
    for path in SHADERS:
        source = compose(path)
        for scalar, lines in values_compiled_in(source.text).items():
            places = {":".join(map(str, source.origin[line - 1])) for line in lines}
            found.setdefault(scalar, set()).update(places)
    return found


COMPILED_IN = {
    "chunk.first_sample",
    "chunk.sample_count",
    "maps.is_auto",
    "shape.columns",
    "shape.comparison_step",
    "shape.deepest",
    "shape.has_probes",
    "shape.has_rows",
    "shape.image_size.x",
    "shape.image_size.y",
    "shape.is_global",
    "shape.refined_rows",
    "shape.sample_count",
    "shape.sample_rows",
    "shape.sure_levels",
    "shape.threshold",
    "sort.digit",
    "step.first_rank",
    "step.first_ray",
    "step.level",
    "tree.node_count",
    "tree.triangle_count",
}
"""Scalars of uniforms on which a condition may still hang; none of them changes from frame to frame, as
tests/contract/test_shader_cache.py shows. Take off this list what is mended."""


def test_no_condition_hangs_on_a_scalar_of_a_uniform() -> None:
    """Mesa's software driver may compile a kernel anew for each value of it: control values stand in storage, or are
    overrides. A vector that is compared with a built-in id, as in all(id.xy < frame.size), is not such a value."""
    found = all_values_compiled_in()
    new = {scalar: sorted(places) for scalar, places in found.items() if scalar not in COMPILED_IN}
    assert not new, f"conditions hang on scalars of uniforms: {new}"


UNIFORM = "struct Step {\n    level: u32,\n    size: vec2u,\n};\nvar<uniform> step: Step;\nvar<uniform> n: vec4u;\n"


@pytest.mark.parametrize(
    "code",
    [
        "if step.level == 1u { }",
        "if a &&\n    b[step.level] > 2u { }",
        "while i < f(step.level) { }",
        "for (var i = 0u; i < step.level; i++) { }",
        "switch step.level { default: { } }",
        "loop { break if step.level > i; }",
        "if id.x < step.size.x { }",
        "if id.x < n.y { }",
        "let last = step.level + 2u * COUNT; if i < last { }",
        "var last = step.level; let next = last + 1u; while i < next { }",
        "if i < last_level() { }",
    ],
)
def test_the_rule_of_conditions_can_fail(code: str) -> None:
    before = UNIFORM + "const COUNT = 3u;\nfn last_level() -> u32 {\n    return step.level;\n}\n"
    assert values_compiled_in(f"{before}fn f(i: u32) {{ {code} }}")


@pytest.mark.parametrize(
    "code",
    [
        "if all(id.xy < step.size) { }",
        "if my.step.level == 1u { }",
        "if control.level == 1u { let a = step.level; }",
        "let a = select(1u, 2u, step.level == 1u);",
        "for (var i = step.level; i < 4u; i += step.level) { }",
        "let level = positions[step.level]; if level > 1.0 { }",
        "if i == 1u { } // if step.level == 1u { }",
    ],
)
def test_the_rule_of_conditions_lets_the_rest_pass(code: str) -> None:
    assert not values_compiled_in(f"{UNIFORM}fn f(i: u32) {{ {code} }}")


# -- What a file needs from its includer -------------------------------------------------------------------------------

NEEDS = re.compile(r"^//#needs ([\w, ]+)$", re.MULTILINE)
ENTRY = re.compile(r"^@(?:compute|vertex|fragment)\b", re.MULTILINE)
ATTRIBUTE = re.compile(r"@\w+(?:\([^()]*\))?\s*")
LANGUAGE = set(
    re.findall(
        r"\w+",
        """
    alias break case const const_assert continue continuing default discard else enable fn for if let loop override
    return struct switch true false var while private workgroup uniform storage read write read_write
    bool f16 f32 i32 u32 array atomic ptr sampler function r32uint rgba16float rgba32float rgba32uint
    abs acos all any arrayLength asin atan atan2 bitcast ceil clamp cos countLeadingZeros countOneBits
    countTrailingZeros cross degrees determinant distance dot exp exp2 extractBits firstLeadingBit firstTrailingBit
    floor fma fract insertBits inverseSqrt ldexp length log log2 max min mix modf normalize pow radians reflect
    reverseBits round saturate select sign sin smoothstep sqrt step tan transpose trunc
    atomicAdd atomicAnd atomicExchange atomicLoad atomicMax atomicMin atomicOr atomicStore atomicXor
    storageBarrier workgroupBarrier workgroupUniformLoad
    """,
    )
)
LANGUAGE_FAMILIES = re.compile(r"(?:vec[234]|mat[234]x[234])[fuih]?|texture\w+|(?:un)?pack[24]x\w+")


def said_needs(path: Path) -> set[str]:
    """What the file's header says."""
    return {name.strip() for names in NEEDS.findall(path.read_text(encoding="utf-8")) for name in names.split(",")}


def needs(path: Path) -> set[str]:
    """The names that the file uses, and that neither it, nor what it includes, nor the language declares."""
    source = compose(path)
    declared = words_by_declaration(COMMENT.sub("", source.text)).keys()
    here = source.origin[-1][0]
    lines = [
        line
        for line, (file, _) in zip(source.text.split("\n"), source.origin, strict=False)
        if file == here and not line.startswith("enable ")
    ]
    words = words_by_declaration(ATTRIBUTE.sub("", COMMENT.sub("", "\n".join(lines))))
    used = set().union(*words.values()) - declared - LANGUAGE
    return {name for name in used if not LANGUAGE_FAMILIES.fullmatch(name)}


def test_every_file_says_what_it_needs_from_its_includer() -> None:
    wrong = {
        path.relative_to(SOURCE).as_posix(): {"says": sorted(said), "needs": sorted(found)}
        for path in SHADERS
        if (said := said_needs(path)) != (found := needs(path))
    }
    assert not wrong
    assert sum(bool(said_needs(path)) for path in SHADERS) >= 5


def test_whoever_includes_a_file_provides_what_it_needs() -> None:
    """Those with entry points, which are what is compiled; they need nothing themselves."""
    missing = []
    for path in SHADERS:
        if not ENTRY.search(path.read_text(encoding="utf-8")):
            continue
        source = compose(path)
        declared = words_by_declaration(COMMENT.sub("", source.text)).keys()
        files = {file for file, _ in source.origin if file.endswith(".wgsl")}
        missing += [(path, file, lacking) for file in files if (lacking := said_needs(SOURCE / file) - declared)]
    assert not missing


def test_the_rule_of_needs_can_fail(tmp_path: Path) -> None:
    (tmp_path / "given.wgsl").write_text("const GIVEN = 1u;\nfn given(a: u32) -> u32 {\n    return a;\n}\n")
    file = tmp_path / "file.wgsl"
    file.write_text(
        '//#include "given.wgsl"\n//#needs taps, light\n// unsaid(light)\nvar<private> mine: array<f32, GIVEN>;\n'
        "fn f(own: vec2f, x: f32) -> Missing {\n    let a = given(GIVEN) + taps(own.light) + light.own + mine[0];\n}\n"
    )
    assert said_needs(file) == {"taps", "light"}
    assert needs(file) == {"taps", "light", "Missing"}
