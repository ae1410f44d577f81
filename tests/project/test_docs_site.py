"""The built documentation as people meet it: from a file, without a network, on a phone, in the dark."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from site_pages import ROOT, Reader, built_site, reading

pytestmark = pytest.mark.full

KATEX = ROOT / "docs" / "_static" / "katex"

# Wide pages, and all that have formulas.
SOURCES = sorted((ROOT / "docs").glob("*.md"))
FORMULA = re.compile(r"\$[^$\n]+\$|^\$\$|\\begin\{", re.MULTILINE)
CODE = re.compile(r"`[^`\n]+`")
WITH_FORMULAS = [path.stem for path in SOURCES if FORMULA.search(CODE.sub("", path.read_text(encoding="utf-8")))]
WITH_FORMULAS += [f"lecture/{path.stem}" for path in sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))]


@pytest.fixture(scope="module")
def site() -> Path:
    return built_site()


@pytest.fixture(scope="module")
def reader(browser: Any) -> Iterator[Reader]:
    with reading(browser) as reader:
        yield reader


def test_the_style_of_formulas_fits_their_program(site: Path) -> None:
    style = re.search(r'content:"(0[.\d]+)"', (KATEX / "katex.min.css").read_text(encoding="utf-8"))
    program = re.search(r'version:"(0[.\d]+)"', (site / "_static" / "katex.min.js").read_text(encoding="utf-8"))
    assert style is not None
    assert program is not None
    assert style.group(1) == program.group(1)


@pytest.mark.parametrize("name", WITH_FORMULAS)
def test_formulas_are_set_without_a_network_in_the_light_and_in_the_dark(reader: Reader, site: Path, name: str) -> None:
    with reader.at(site / f"{name}.html") as tab:
        written = (site / f"{name}.html").read_text(encoding="utf-8").count('class="math"')
        assert written > 0
        tab.wait_for_function("document.querySelectorAll('.math .katex-html').length > 0")
        assert tab.locator(".math").count() == written
        assert tab.locator(".math:not(:has(.katex-html))").count() == 0
        assert tab.locator(".katex-error").count() == 0
        # What a reader sees, without the hidden MathML for screen readers and without code.
        text = tab.evaluate(
            """() => {
                const page = document.querySelector('article').cloneNode(true);
                page.querySelectorAll('pre, code, .katex-mathml').forEach((node) => node.remove());
                return page.textContent;
            }"""
        )
        assert not re.search(r"\\[(\[a-zA-Z]|\$", text), name
        for dark in (False, True):
            reader.darken(dark)
            ink, paper = tab.evaluate(
                "[document.querySelector('.katex-html'), document.body].map((node) => getComputedStyle(node))"
                ".map((style, i) => (i ? style.backgroundColor : style.color))"
            )
            assert contrast(ink, paper) > 7
            assert (luminance(paper) < 0.5) == dark
        reader.resize(390)
        assert reader.overflow() == 0
        for letters, font in ((".katex-html", "KaTeX_Main"), (".katex-html .mathnormal", "KaTeX_Math")):
            assert tab.locator(letters).count() == 0 or tab.evaluate(f"document.fonts.check('16px {font}')")


def luminance(colour: str) -> float:
    """The relative luminance of a colour as WCAG 2.2 defines it."""
    parts = [int(number) / 255 for number in re.findall(r"\d+", colour)[:3]]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(a: str, b: str) -> float:
    """The contrast ratio of two colours as WCAG 2.2 defines it."""
    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


def pages(site: Path) -> list[str]:
    return sorted(str(path.relative_to(site)) for path in site.rglob("*.html") if "_static" not in path.parts)


def test_no_page_is_wider_than_a_phone(reader: Reader, site: Path) -> None:
    wide = []
    for name in pages(site):
        if name.removesuffix(".html") not in WITH_FORMULAS:  # those have been looked at above
            with reader.at(site / name, width=390):
                wide += [name] * (reader.overflow() > 0)
    assert wide == []


def test_the_robot_of_the_first_page_moves_and_lets_the_page_scroll_before_it_is_clicked(
    reader: Reader, site: Path
) -> None:
    with reader.at(site / "index.html") as tab:
        robot = tab.frame_locator(".robot iframe")
        robot.locator("body[data-ready]").wait_for(timeout=30_000)
        holds = "getComputedStyle(document.querySelector('.robot iframe')).pointerEvents"
        assert tab.evaluate(holds) == "none"
        tab.locator(".robot").click(position={"x": 30, "y": 300})
        assert tab.evaluate(holds) == "auto"
        robot.get_by_role("button", name="Crouch").click()
        knee = robot.locator('.joint[data-joint="LKneePitch"] input[type="text"]')
        tab.wait_for_function("value => value !== null", arg=knee.input_value())
        assert float(knee.input_value()) > 90.0


def test_without_programs_the_first_page_has_a_picture_of_the_robot(browser: Any, site: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    try:
        tab = context.new_page()
        tab.goto((site / "index.html").as_uri())
        assert tab.locator(".robot img").is_visible()
        assert not tab.locator(".robot iframe").is_visible()
    finally:
        context.close()


ATTRIBUTES = re.compile(r"""<[a-z]+\b[^>]*?\s(?:href|src|data)=(?:"([^"]*)"|'([^']*)')""")
NAMED = re.compile(r"""\s(?:id|name)="([^"]*)\"""")


def test_every_link_inside_the_site_leads_somewhere(site: Path) -> None:
    names = pages(site)
    texts = {name: (site / name).read_text(encoding="utf-8") for name in names}
    anchors = {name: {html.unescape(anchor) for anchor in NAMED.findall(text)} for name, text in texts.items()}
    broken = []
    for name, text in texts.items():
        for target in filter(None, map("".join, ATTRIBUTES.findall(text))):
            url = urlsplit(html.unescape(target))
            if url.scheme or url.netloc:
                continue
            path = os.path.normpath(os.path.join(os.path.dirname(name), unquote(url.path))) if url.path else name
            anchor = unquote(url.fragment)
            if not (site / path).is_file() or (anchor and path in anchors and anchor not in anchors[path]):
                broken.append(f"{name}: {target}")
    assert not broken


def test_styles_name_files_that_are_there(site: Path) -> None:
    for style in site.rglob("*.css"):
        for target in re.findall(r"url\(['\"]?([^)'\"]+)", style.read_text(encoding="utf-8")):
            if not target.startswith(("data:", "http", "#")):
                assert (style.parent / target.split("?")[0].split("#")[0]).is_file(), f"{style.name}: {target}"


@pytest.mark.parametrize("drawing", sorted((ROOT / "docs" / "images").glob("*.svg")), ids=lambda path: path.name)
def test_no_label_of_a_drawing_is_cut(reader: Reader, drawing: Path) -> None:
    with reader.at(drawing) as tab:
        outside = tab.evaluate(
            """() => {
                const drawing = document.documentElement;
                drawing.querySelectorAll('text').forEach((label) => (label.style.fontFamily = 'DejaVu Sans'));
                const [left, top, width, height] = drawing.getAttribute('viewBox').split(/[ ,]+/).map(Number);
                return [...drawing.querySelectorAll('text')].filter((label) => {
                    const box = label.getBBox(), m = drawing.getCTM().inverse().multiply(label.getCTM());
                    const ends = [0, 1].map((k) => new DOMPoint(box.x + k * box.width, box.y + k * box.height));
                    const [a, b] = ends.map((end) => end.matrixTransform(m));
                    const xs = [a.x, b.x], ys = [a.y, b.y];
                    return Math.min(...xs) < left || Math.max(...xs) > left + width
                        || Math.min(...ys) < top || Math.max(...ys) > top + height;
                }).map((label) => label.textContent);
            }"""
        )
        assert outside == []


@pytest.mark.parametrize(
    ("query", "first"),
    [
        ("quaternion", "Conventions"),
        ("inverse kinematics", "Inverse kinematics"),
        ("fk", "nao_kin.RobotModel.fk"),
        ("calibrated camera", "Calibrate joints and cameras"),
        ("mujoco", "MuJoCo"),
        ("joint limits", "Configurations and poses"),
    ],
)
def test_the_search_begins_with_the_page_that_is_most_about_the_words(
    reader: Reader, site: Path, query: str, first: str
) -> None:
    with reader.at(site / "search.html") as tab:
        tab.fill("form[role=search] input[name=q] >> visible=true", query)
        tab.keyboard.press("Enter")
        result = tab.locator("ul.search li > a").first
        result.wait_for()
        tab.wait_for_function("/found|finished/.test(document.querySelector('.search-summary').textContent)")
        assert result.inner_text() == first
        reader.errors.clear()  # of the summaries, which a browser does not fetch for pages opened from files
