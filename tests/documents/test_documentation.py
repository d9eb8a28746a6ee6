"""The documentation builds without a warning, its figures are those of its JSON, and its code runs."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import softshadows
from softshadows.scene.description import light_from_text
from softshadows.techniques import TECHNIQUES

ROOT = Path(__file__).parents[2]
DOCS, IMAGES = ROOT / "docs", ROOT / "docs" / "images"
sys.path.insert(0, str(ROOT / "scripts" / "docs"))

PICTURE_BYTES, ALL_BYTES = 100_000, 3_000_000

techniques = pytest.mark.parametrize("name", list(TECHNIQUES))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built documentation; fails with mkdocs' output where it warns."""
    folder = tmp_path_factory.mktemp("site")
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}  # an advertisement of the theme's successor
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (done.stdout + done.stderr).strip() == ""
    return folder


class Links(HTMLParser):
    """What a page loads by itself: pictures, scripts and style sheets."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in ("img", "script"):
            self.loaded += filter(None, [given.get("src")])
        elif tag == "link" and given.get("rel") in ("stylesheet", "icon"):
            self.loaded += filter(None, [given.get("href")])


def test_pages_load_nothing_from_the_network_and_nothing_that_is_missing(site: Path) -> None:
    pages = [page for page in site.rglob("*.html") if page.name != "404.html"]
    assert len(pages) > 30
    for page in pages:
        for link in Links(page).loaded:
            assert "//" not in link, f"{page.name} loads {link}"
            assert (page.parent / link.partition("?")[0]).is_file(), f"{page.name} loads {link}, which is not there"


@techniques
def test_a_technique_has_its_page_with_both_pictures_and_all_options(site: Path, name: str) -> None:
    page = (site / "techniques" / f"{name}.html").read_text(encoding="utf-8")
    assert f"images/techniques/{name}.png" in page
    assert f"images/techniques/{name}-fails.png" in page
    for option in TECHNIQUES[name].options():
        assert f"<code>{option.name}</code>" in page
    for heading in ("Use when", "Fails when", "Figures", "From the paper to the code", "Departures from the paper"):
        assert f">{heading}<" in page


@techniques
def test_the_command_on_a_technique_s_page_names_a_light_that_it_can_do(name: str) -> None:
    from technique_page import technique_page

    (command,) = re.findall(r"^    softshadows render (.+)$", technique_page(name), re.MULTILINE)
    words = command.split()
    scene = softshadows.scenes.make(words[0])
    lights = [light_from_text(words[words.index("--light") + 1])] if "--light" in words else scene.lights
    assert words[words.index("-t") + 1] == name
    TECHNIQUES[name].check_lights(lights)


@techniques
def test_every_technique_is_declared_a_picture_and_a_failure(name: str) -> None:
    from pictures import CAPTIONS, SHOWN

    captions = json.loads(CAPTIONS.read_text(encoding="utf-8"))[name]
    for shown, caption in zip(SHOWN[name], (captions["picture"], captions["failure"]), strict=True):
        assert shown.words in caption, f"run `python scripts/docs/pictures.py {name}`: the picture shows something else"
        assert f"`{shown.scene}`" in caption
        TECHNIQUES[name].of(shown.options)  # raises where an option went


@techniques
def test_the_failure_is_shown_on_a_scene_that_the_manual_names(name: str) -> None:
    """Where the manual names none, for every scene shows it, any will do."""
    from manual import manual
    from pictures import SHOWN

    named = set(re.findall(r"`(\w+)`", manual(TECHNIQUES[name])[1]["Fails when"])) & set(softshadows.scenes.SCENES)
    assert not named or SHOWN[name][1].scene in named


def test_pictures_are_small_and_show_something() -> None:
    files = [path for path in IMAGES.rglob("*") if path.suffix in (".png", ".gif")]
    assert sum(path.stat().st_size for path in files) <= ALL_BYTES
    for path in files:
        with Image.open(path) as image:
            assert np.ptp(np.asarray(image.convert("L"))) > 100, path.name
        limit = 250_000 if path.stem in ("demo", "moving_light") else PICTURE_BYTES
        assert path.stat().st_size <= limit, path.name


def test_readme_holds_the_figures_of_the_results() -> None:
    from tables import README, filled

    text = README.read_text(encoding="utf-8")
    assert text.count("<!-- table: ") == 2
    assert filled(text) == text, "run `python scripts/docs/tables.py`"


def test_tables_show_the_figures_of_their_json() -> None:
    """Each technique's rmse in README's table, straight from the file: the generator is checked, too."""
    from tables import README, RESULTS

    rows = {}
    for line in README.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| `") and cells[0].strip("`") in TECHNIQUES:
            rows[cells[0].strip("`")] = cells
    assert list(rows) == list(TECHNIQUES)
    pictures = json.loads((RESULTS / "choice.json").read_text(encoding="utf-8"))["pictures"]
    for column, kind in ((3, "rect"), (5, "line")):
        picture = next(picture for picture in pictures if picture["lights"][0]["type"] == kind)
        measured = {row["label"]: row for row in picture["techniques"]}
        for name, cells in rows.items():
            if name in measured:
                assert float(cells[column]) == pytest.approx(measured[name]["lights"][0]["rmse"], rel=0.05)
                assert int(cells[column + 1].replace(" ", "")) == round(measured[name]["frame_ms"])
            else:
                assert cells[column : column + 2] == ["", ""]


@pytest.mark.parametrize("page", ["docs/index.md", "README.md"])
def test_the_code_of_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All Python of the page in one go, at a tiny size; a model file of the reader's own becomes a built-in scene."""
    monkeypatch.chdir(tmp_path)
    text = (ROOT / page).read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    assert code.count("ss.") > 5
    code = re.sub(r"size=\(\d+, \d+\)", "size=(48, 36)", code).replace("samples=1024", "samples=16")
    code = code.replace('ss.load_scene("chair.glb")', "ss.scenes.figures()")
    exec(compile(code, page, "exec"), {"cameras": [softshadows.Camera((3, 2, 3), (0, 0, 0))]})
    assert list(tmp_path.glob("*.png"))


def test_the_reference_has_every_public_name(site: Path) -> None:
    page = (site / "reference.html").read_text(encoding="utf-8")
    modules = {"metrics", "scenes", "techniques", "truth", "__version__"}
    for name in set(softshadows.__all__) - modules:
        assert f"<code>ss.{name}</code>" in page


def test_pages_name_files_that_exist() -> None:
    """Files that the written pages name by their path from the root, or from docs."""
    pages = [*DOCS.glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    mention = re.compile(r"`((?:src|scripts|examples|benchmarks|tests|docs)/[\w./]+)`")
    named = [(page.name, path) for page in pages for path in mention.findall(page.read_text(encoding="utf-8"))]
    assert len(named) > 10
    missing = [(page, path) for page, path in named if not (ROOT / path).exists() and "four_points" not in path]
    assert missing == []
