"""Write the gallery of docs from the examples, or check it: an overview of cards, and a page for each example.

The docstring of an example is its title and sentence, its output is the result, and its picture is the PNG that it
draws, or a picture that headless Chromium takes of its page of the viewer.

Example:
    python scripts/generate_gallery.py                 # runs all examples, writes the pages and pictures
    python scripts/generate_gallery.py first_pose wave # runs only these
    python scripts/generate_gallery.py --check         # exit 1 if an example or a picture is missing or outdated

--check runs no example: tests/project/test_examples.py compares their output with the pages.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import io
import os
import re
import runpy
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

if TYPE_CHECKING:
    from nao_kin import Viewer

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
DOCS = ROOT / "docs"
PICTURES = DOCS / "images" / "examples"

# Every example is in one section, in reading order.
SECTIONS = {
    "Poses": """
        first_pose posture_and_joints hand_path workspace million_configurations hand_velocity coupled_limits versions
    """.split(),
    "The robot in its world": """
        balance self_collision camera_sees_ball calibrated_camera calibrate
    """.split(),
    "Rotations, screws and joints": """
        two_turns gimbal_lock mean_rotation screw_of_a_displacement lower_pairs spherical_hip
    """.split(),
    "Inverse kinematics": ["arm_branches", "romeo_branches", "look_at", "follow_ball", "crouch", "whole_body"],
    "Motions and NAOqi": ["wave", "webcam", "position6d", "virtual_nao", "log_to_hands"],
    "Robots and other tools": """
        two_naos meshcat_scene romeo own_urdf mujoco_stand urdf_for_simulators ros_package cross_check
    """.split(),
}
INTRODUCTION = """\
# Gallery

Short scripts, each about one idea, with their output; they are in the folder `examples` of the repository.
Each runs alone, and writes its picture or page into the current folder, or into the folder you name:

```text
python examples/first_pose.py
python examples/hand_path.py pictures
```

A page such as `first_pose.html` opens in any browser without a network, and you can turn the robot in it. Scripts for
NAOqi, in the style of scripts for the real robot, are in `examples/naoqi` ({doc}`old_scripts`).
"""
PRINTED_LINES = 9  # lines of output on the card of an example without a picture

MAX_BYTES = 60_000
SIZE = (1000, 900)  # of the viewer's picture [pixels]
WIDTH, HEIGHT = 640, 520  # at most, in the gallery
MARGIN = 12
# Cameras other than three-quarter that show an example better.
CAMERAS = {"arm_branches": "side", "camera_sees_ball": "side", "whole_body": "side"}


@dataclass(frozen=True)
class Example:
    """The contents of an example's docstring.

    Attributes:
        name: the file name without suffix.
        title: the first line.
        text: the sentence.
        extra: the extra that it needs or that makes it quicker, "" for none.
        required: whether it needs the extra to run.
    """

    name: str
    title: str
    text: str
    extra: str
    required: bool


def read_example(path: Path) -> Example:
    """Return the parts of an example's docstring.

    Raises:
        ValueError: the docstring has no title, or no sentence under it.
    """
    paragraphs = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split("\n\n")
    title, *rest = (" ".join(paragraph.split()) for paragraph in paragraphs)
    extra = re.fullmatch(r"(Needs|Quicker with) nao-kin\[(\w+)\]\.", rest[-1]) if rest else None
    text = rest[:-1] if extra else rest
    if not title or len(text) != 1:
        raise ValueError(f"{path}: expected a title, one paragraph, and perhaps 'Needs nao-kin[extra].'")
    word, name = extra.groups() if extra else ("", "")
    return Example(path.stem, title.removesuffix("."), text[0], name, word == "Needs")


def run_example(name: str, folder: Path) -> str:
    """Run an example in a folder, and return its output."""
    said, before, arguments = io.StringIO(), Path.cwd(), sys.argv
    os.chdir(folder)
    sys.argv = [f"{name}.py"]
    try:
        with contextlib.redirect_stdout(said):
            runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    finally:
        os.chdir(before)
        sys.argv = arguments
    return said.getvalue()


@contextlib.contextmanager
def pictured_pages() -> Iterator[None]:
    """Save a picture next to every page that an example saves."""
    from nao_kin import Viewer

    save_html = Viewer.save_html

    def save(viewer: Viewer, path: Path | str, *, overwrite: bool = False) -> Path:
        page = save_html(viewer, path, overwrite=overwrite)
        viewer.save_png(
            page.with_suffix(".png"), camera=CAMERAS.get(page.stem, "three-quarter"), size=SIZE, overwrite=overwrite
        )
        return page

    with mock.patch.object(Viewer, "save_html", save):
        yield


def write_small(source: Path, target: Path) -> None:
    """Write a picture without its empty margins, in few colours, with at most `MAX_BYTES`."""
    from PIL import Image, ImageChops

    picture = Image.open(source).convert("RGB")
    ground = Image.new("RGB", picture.size, picture.getpixel((0, 0)))
    left, top, right, bottom = ImageChops.difference(picture, ground).getbbox() or (0, 0, *picture.size)
    box = (left - MARGIN, top - MARGIN, right + MARGIN, bottom + MARGIN)
    inside = (max(box[0], 0), max(box[1], 0), min(box[2], picture.width), min(box[3], picture.height))
    picture = picture.crop(inside)
    picture.thumbnail((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    target.parent.mkdir(parents=True, exist_ok=True)
    # An octree keeps rare colours, such as those of thin lines, which median cut loses.
    picture.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(target, optimize=True)
    if target.stat().st_size > MAX_BYTES:
        raise ValueError(f"{target} has {target.stat().st_size} bytes, at most {MAX_BYTES} are allowed")


def draw(names: Iterable[str]) -> dict[str, str]:
    """Run examples, keep their pictures, and return their output."""
    import matplotlib as mpl

    mpl.use("Agg")
    printed = {}
    with tempfile.TemporaryDirectory() as temporary, pictured_pages():
        for name in names:
            printed[name] = run_example(name, Path(temporary))
            picture = Path(temporary) / f"{name}.png"
            if picture.exists():
                write_small(picture, PICTURES / picture.name)
            print(name)
    return printed


def pages_of(docs: Path = DOCS) -> dict[str, str]:
    """Return example → text of its page."""
    return {page.stem: page.read_text(encoding="utf-8") for page in (docs / "gallery").glob("*.md")}


def printed_in(pages: Mapping[str, str]) -> dict[str, str]:
    """Return the output of each example, from its page."""
    found = {name: re.search(r"^```text\n(.*?)^```$", page, re.MULTILINE | re.DOTALL) for name, page in pages.items()}
    return {name: match.group(1) for name, match in found.items() if match}


def page_text(example: Example, printed: str) -> str:
    """Return the page of an example."""
    lines = [f"(example_{example.name})=", f"# {example.title}", "", example.text]
    if example.extra:
        word = "Needs" if example.required else "Quicker with"
        lines += ["", f"*{word} the extra `{example.extra}`: `pip install 'nao-kin[{example.extra}]'`.*"]
    if is_drawn(example, printed):
        lines += ["", f"![{example.title}](../images/examples/{example.name}.png)"]
    lines += ["", f"`{example.name}.py` prints", "", "```text", printed.rstrip("\n"), "```", ""]
    lines += [f"```{{literalinclude}} ../../examples/{example.name}.py", ":language: python", "```", ""]
    return "\n".join(lines)


def is_drawn(example: Example, printed: str) -> bool:
    """Return whether an example draws a picture or a page."""
    return f"see {example.name}." in printed


def card(example: Example, printed: str) -> list[str]:
    """Return an example's card: its picture, or the beginning of its output, with title and sentence."""
    lines = [f":::{{grid-item-card}} {example.title}", f":link: gallery/{example.name}", ":link-type: doc"]
    if is_drawn(example, printed):
        lines += [f":img-top: images/examples/{example.name}.png", ":img-alt: ''", ""]
    else:
        lines += ["", "```{card-header}", "~~~text", *printed.splitlines()[:PRINTED_LINES], "~~~", "```"]
    idea = example.text.removeprefix("Learn ")
    return [*lines, idea[0].upper() + idea[1:], ":::", ""]


def overview_text(examples: Mapping[str, Example], printed: Mapping[str, str]) -> str:
    """Return the page with all cards."""
    lines = [INTRODUCTION]
    for section, names in SECTIONS.items():
        lines += [f"## {section}", "", "::::{grid} 1 2 2 3", ":gutter: 3", ":class-container: gallery", ""]
        lines += [line for name in names for line in card(examples[name], printed[name])]
        lines += ["::::", ""]
    every = [f"gallery/{name}" for names in SECTIONS.values() for name in names]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *every, "```", ""])


def texts(printed: Mapping[str, str]) -> dict[str, str]:
    """Return all pages by their path below docs."""
    examples = {name: read_example(EXAMPLES / f"{name}.py") for names in SECTIONS.values() for name in names}
    pages = {f"gallery/{name}.md": page_text(example, printed[name]) for name, example in examples.items()}
    return {"gallery.md": overview_text(examples, printed)} | pages


def faults(docs: Path = DOCS) -> list[str]:
    """Return the outdated parts, one line each; no example is run."""
    pages = pages_of(docs)
    printed = printed_in(pages)
    names = {name for section in SECTIONS.values() for name in section}
    there = {path.stem for path in EXAMPLES.glob("*.py")}
    found = [f"{name} is in no section of scripts/generate_gallery.py" for name in sorted(there - names)]
    found += [f"examples/{name}.py does not exist" for name in sorted(names - there)]
    found += [f"{name} has no page in docs/gallery" for name in sorted(names - printed.keys())]
    if found:
        return found
    found += [f"docs/gallery/{name}.md belongs to no example" for name in sorted(pages.keys() - names)]
    for place, text in texts(printed).items():
        if not (docs / place).is_file() or (docs / place).read_text(encoding="utf-8") != text:
            found.append(f"docs/{place} is not in step with the docstrings of the examples")
    drawn = {name for name in names if f"see {name}." in printed[name]}
    pictures = {path.stem: path for path in PICTURES.glob("*.png")}
    found += [f"{name} has no picture" for name in sorted(drawn - pictures.keys())]
    found += [f"{pictures[name]} belongs to no example" for name in sorted(pictures.keys() - drawn)]
    found += [f"{path} is too large" for path in pictures.values() if path.stat().st_size > MAX_BYTES]
    return found


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="examples to run again (default: all)")
    parser.add_argument(
        "--check", action="store_true", help="run and write nothing; fail if a page or a picture is outdated"
    )
    options = parser.parse_args(arguments)
    if options.check:
        found = faults()
        for fault in found:
            print(f"{fault} (run scripts/generate_gallery.py)", file=sys.stderr)
        return 1 if found else 0
    every = [name for section in SECTIONS.values() for name in section]
    printed = printed_in(pages_of()) | draw(options.names or every)
    for place, text in texts(printed).items():
        (DOCS / place).parent.mkdir(exist_ok=True)
        (DOCS / place).write_text(text, encoding="utf-8")
    print(DOCS / "gallery.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
