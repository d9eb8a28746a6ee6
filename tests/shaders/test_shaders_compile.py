"""Every shader with an entry point compiles: in naga here, and in the browsers' Tint where Chromium is installed."""

from __future__ import annotations

import functools
import http.server
import json
import re
import shutil
import subprocess
import threading
from pathlib import Path

import pytest

import softshadows.renderer
from softshadows.gpu.compose import compose, shader_module
from softshadows.gpu.device import acquire

SOURCE = Path(softshadows.__file__).parent
ENTRY = re.compile(r"^@(compute|vertex|fragment)\b", re.MULTILINE)
SHADERS = sorted(path for path in SOURCE.rglob("*.wgsl") if ENTRY.search(path.read_text(encoding="utf-8")))


NEEDS = {"enable clip_distances;": "clip-distances"}


def name_of(path: Path) -> str:
    return path.relative_to(SOURCE).as_posix()


STAND_INS = {
    "visibility/hybrid.wgsl": "visibility/rays/unclassified.wgsl",
    "visibility/rays/cutouts.wgsl": "visibility/rays/no_cutouts.wgsl",
    "visibility/rays/world_space.wgsl": "visibility/rays/light_tree_space.wgsl",
    "techniques/bitmask/rectangle.wgsl": "techniques/bitmask/line.wgsl",
    "techniques/bitmask/cutouts.wgsl": "techniques/bitmask/no_cutouts.wgsl",
    "techniques/penumbra_wedges/wedges.wgsl": "techniques/penumbra_wedges/union.wgsl",
}
"""Files that others stand in for, by a scene's materials or by an option."""


@functools.cache
def variants() -> dict[str, tuple[Path, dict[str, str]]]:
    """Every shader as it is, and with the stand-ins where it includes what they replace."""
    found: dict[str, tuple[Path, dict[str, str]]] = {name_of(path): (path, {}) for path in SHADERS}
    for path in SHADERS:
        replaced = {file for file, _ in compose(path).origin} & STAND_INS.keys()
        if replaced:
            found[f"{name_of(path)} with stand-ins"] = (path, {file: STAND_INS[file] for file in replaced})
    return found


CHROMIUM_FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-quic", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan",
    "--use-vulkan=swiftshader", "--use-angle=swiftshader",
]  # fmt: skip
"""WebGPU on Chromium's software adapter."""

PAGE = """<!doctype html><title>working</title><script type="module">
const report = async (result) => { await fetch("/result", {method: "POST", body: JSON.stringify(result)}); };
try {
  const adapter = await navigator.gpu.requestAdapter();
  const features = ["clip-distances"].filter(name => adapter.features.has(name));
  const device = await adapter.requestDevice({requiredFeatures: features});
  const sources = await (await fetch("/sources")).json();
  const result = {};
  for (const [name, code] of Object.entries(sources)) {
    const info = await device.createShaderModule({code}).getCompilationInfo();
    result[name] = info.messages.filter(m => m.type == "error").map(m => `wgsl:${m.lineNum}:${m.linePos} ${m.message}`);
  }
  await report(result);
} catch (error) { await report({page: [String(error)]}); }
</script>"""


@pytest.mark.parametrize("name", variants())
def test_compiles_in_naga(name: str) -> None:
    path, stand_ins = variants()[name]
    text = path.read_text(encoding="utf-8")
    missing = {feature for line, feature in NEEDS.items() if line in text} - acquire().features
    if missing:
        pytest.skip(f"this adapter lacks {', '.join(missing)}")
    shader_module(acquire().device, compose(path, stand_ins), name)


def test_no_shader_is_forgotten() -> None:
    """Files without an entry point are libraries: some shader includes each of them."""
    libraries = {name_of(path) for path in SOURCE.rglob("*.wgsl")} - {name_of(path) for path in SHADERS}
    used = {file for path, stand_ins in variants().values() for file, _ in compose(path, stand_ins).origin}
    assert len(SHADERS) >= 10
    assert libraries <= used


class Handler(http.server.BaseHTTPRequestHandler):
    """Hands out the page and the sources, takes the result."""

    def __init__(
        self, sources: dict[str, str], result: dict[str, list[str]], done: threading.Event, *args: object
    ) -> None:
        self._sources, self._result, self._done = sources, result, done
        super().__init__(*args)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        is_page = self.path != "/sources"
        body = (PAGE if is_page else json.dumps(self._sources)).encode()
        self.send_response(200)
        self.send_header("Content-Type", "text/html" if is_page else "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self) -> None:
        self._result.update(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()
        self._done.set()

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.mark.chromium
def test_compiles_in_chromium(tmp_path: Path) -> None:
    """Tint refuses some things that naga lets pass."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium is installed, so nothing is compiled by Tint")
    sources = {name: compose(path, stand_ins) for name, (path, stand_ins) in variants().items()}
    sent = {name: source.text for name, source in sources.items()}
    sent["a shader with a mistake"] = "fn wrong() -> u32 { return 1.5; }"  # the compiler is really there
    result: dict[str, list[str]] = {}
    done = threading.Event()
    handler = functools.partial(Handler, sent, result, done)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_address[1]}/"
        command = [chromium, *CHROMIUM_FLAGS, f"--user-data-dir={tmp_path / 'profile'}", address]
        browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            assert done.wait(90.0), "the page did not answer"
        finally:
            browser.terminate()
            browser.wait(10.0)
            server.shutdown()
    assert "page" not in result, result["page"]
    assert result.pop("a shader with a mistake")
    assert set(result) == set(sources)
    errors = {name: [sources[name].locate(text) for text in messages] for name, messages in result.items() if messages}
    assert not errors, json.dumps(errors, indent=2)
