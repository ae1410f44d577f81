"""The lecture's notebooks as pages, written when the documentation is built.

The notebooks stand in the repository with what they printed and drew when they were run last, and the tests run them
again; so nothing has to be run here, and no package is needed that reads notebooks.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any


def write_lecture(notebooks: Path, folder: Path) -> None:
    """Write a page for each notebook, and its pictures beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted: set[Path] = set()
    for path in sorted(notebooks.glob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        title, _, first = _source(cells[0]).partition("\n")
        files = " and ".join(
            f"{{download}}`{file} <../../examples/notebooks/{file}>`" for file in (path.name, "figures.py")
        )
        note = f"To run it, download {files} into one folder."
        parts = [title, note, first.strip()]
        for number, cell in enumerate(cells[1:], start=1):
            pictures: list[tuple[str, bytes]] = []
            parts += _markdown(cell, f"{path.stem}_{number}", pictures)
            for name, data in pictures:
                wanted.add(_kept(folder / name, data))
        wanted.add(_kept(folder / f"{path.stem}.md", ("\n\n".join(parts) + "\n").encode()))
    for old in set(folder.iterdir()) - wanted:
        old.unlink()


def _markdown(cell: dict[str, Any], name: str, pictures: list[tuple[str, bytes]]) -> list[str]:
    """A cell as paragraphs; its pictures are appended to `pictures` with the names that the paragraphs call."""
    if cell["cell_type"] == "markdown":
        return [_source(cell)]
    parts = [f"```python\n{_source(cell)}\n```"]
    for output in cell["outputs"]:
        if output["output_type"] == "stream":
            parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
        elif "image/png" in output["data"]:
            file = f"{name}_{len(pictures)}.png"
            pictures.append((file, base64.b64decode("".join(output["data"]["image/png"]))))
            parts.append(f"![{cell['metadata']['alt']}]({file})")
    if "solution" in cell["metadata"].get("tags", ()):
        return ["<details>\n<summary>Solution</summary>", *parts, "</details>"]
    return parts


def _source(cell: dict[str, Any]) -> str:
    return "".join(cell["source"])


def _kept(path: Path, data: bytes) -> Path:
    """A file that is the same already stays as it is, for Sphinx reads again what is new."""
    if not path.exists() or path.read_bytes() != data:
        path.write_bytes(data)
    return path
