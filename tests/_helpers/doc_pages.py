"""The README and the pages of the documentation, and the blocks of code in them."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
# The pages in the folder lecture are generated from the notebooks, which have their own test.
PAGES = [
    ROOT / "README.md",
    *sorted(DOCS.glob("[!_]*.md")),
    *(page for page in sorted(DOCS.glob("[!_]*/*.md")) if page.parent.name != "lecture"),
]
# Pages on which every Python block that prints is followed by a block with its output.
_EXACT = "choregraphe", "coming_from", "courses", "getting_started", "installation", "logs"
PRINTED = [DOCS / f"{name}.md" for name in _EXACT]

_BLOCK = re.compile(r"^```(\w+|\{code-block\} sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str]]:
    """Language and text of each block, in order."""
    return _BLOCK.findall(page.read_text(encoding="utf-8"))


def blocks_of(page: Path, *languages: str) -> list[str]:
    """The text of the blocks in some languages."""
    return [text for language, text in blocks(page) if language in languages]
