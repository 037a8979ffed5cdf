"""Every command and snippet of the documentation runs as it stands, page by page, and every public name has its place in it."""

import re
from types import ModuleType

import outcomes
import pytest
from pages import PAGES, ROOT, blocks, follow, is_run

import analysis
import ccd
import edmd

RUN = [page for page in PAGES if any(map(is_run, blocks(page)))]
SLOW = [page for page in RUN if any(block.note == "slow" for block in blocks(page))]


def name(page):
    return str(page.relative_to(ROOT))


def followed(page, slow, folder, monkeypatch):
    monkeypatch.chdir(folder)
    if not slow:
        monkeypatch.setattr("analysis.shading.SKY_LAMPS", 6)                   # pictures take most of the time
    names = follow(page, slow)
    if check := getattr(outcomes, page.stem, None):
        check(names)


@pytest.mark.parametrize("page", [page for page in RUN if any(is_run(block) and block.note != "slow" for block in blocks(page))], ids=name)
def test_the_page_runs(page, tmp_path, monkeypatch):
    followed(page, False, tmp_path, monkeypatch)


@pytest.mark.validate
@pytest.mark.parametrize("page", SLOW, ids=name)
def test_the_whole_page_runs(page, tmp_path, monkeypatch):
    followed(page, True, tmp_path, monkeypatch)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_what_is_not_run_says_why(page):
    for block in blocks(page):
        assert block.note is None or len(block.reason.split()) > 2, f"{page.name}:{block.line}"
        assert block.note in (None, "slow", "elsewhere", "before") or re.fullmatch(r"status \d+", block.note), f"{page.name}:{block.line}"


@pytest.mark.parametrize("package", [ccd, edmd, analysis], ids=lambda package: package.__name__)
def test_every_public_name_is_in_the_reference(package):
    """By the place where it really is, whose docstring the site shows."""
    page = (ROOT / "docs" / "api" / f"{package.__name__}.md").read_text()
    public = [getattr(package, name) for name in package.__all__ if name != "__version__"]
    homes = {one.__name__ if isinstance(one, ModuleType) else f"{one.__module__}.{one.__qualname__}" for one in public}
    assert set(re.findall(r"^::: ([\w.]+)$", page, re.MULTILINE)) == homes


def test_every_analysis_is_in_the_table_of_its_page():
    table = (ROOT / "docs" / "analysis.md").read_text().split("## Observables")[1].split("###")[0]
    words = {word for cell in re.findall(r"`([^`]+)`", table) for word in re.findall(r"[A-Za-z_]\w+", cell)}
    classes = {name for name in analysis.__all__ if name[0].isupper() and not name.startswith("EDMD")}
    assert classes <= words, f"not on the page: {classes - words}"


def test_every_page_is_on_the_site():
    listed = set(re.findall(r"[\w/-]+\.md", (ROOT / "mkdocs.yml").read_text()))
    there = {str(page.relative_to(ROOT / "docs")) for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert listed == there


def test_every_example_is_in_the_gallery():
    gallery = (ROOT / "docs" / "gallery.md").read_text()
    for script in (ROOT / "examples").glob("*.py"):
        assert f"examples/{script.name}" in gallery
