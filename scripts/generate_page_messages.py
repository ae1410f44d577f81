"""Write `web/src/received.ts`: the types of what the page receives, from KINDS and ROWS of `nao_kin.viewer.messages`.

With `--check` it writes nothing, and fails if the file is out of date.

Example:
    python scripts/generate_page_messages.py --check
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

from nao_kin.viewer.messages import KINDS, ROWS

TARGET = Path(__file__).resolve().parent.parent / "web" / "src" / "received.ts"
# The line length of Prettier, which breaks longer lines.
WIDTH = 120

HEAD = """\
// Written by scripts/generate_page_messages.py from nao_kin/viewer/messages.py.

import type { Vector } from "./math/rotations.ts";
import type { Control } from "./types.ts";

/** The contents of each kind of message from Python. */
export interface Received {
"""


def lines(begin: str, fields: Mapping[str, str], end: str) -> list[str]:
    """Return an object type, on one line if there is room."""
    entries = [f"{field}: {type_};" for field, type_ in fields.items()]
    line = f"{begin}{{ {' '.join(entries).removesuffix(';')} }}{end}" if fields else f"{begin}object{end}"
    indent = " " * (len(begin) - len(begin.lstrip()))
    broken = [f"{begin}{{", *(f"{indent}  {entry}" for entry in entries), f"{indent}}}{end}"]
    return [line] if len(line) <= WIDTH else broken


def text() -> str:
    """Return the text of the TypeScript module."""
    kinds = [line for name, kind in KINDS.items() for line in lines(f"  {name}: ", kind.fields, ";")]
    rows = [
        line
        for name, fields in ROWS.items()
        for line in lines(f"export type {name} = ", fields, " & Driven;" if name == "JointAbout" else ";")
    ]
    return HEAD + "\n".join([*kinds, "}", "", *rows, ""])


def main() -> int:
    """Write or check; return 0, or 1 if the file is out of date."""
    if "--check" not in sys.argv[1:]:
        TARGET.write_text(text(), encoding="utf-8")
    elif not TARGET.is_file() or TARGET.read_text(encoding="utf-8") != text():
        print(f"{TARGET.name} is out of date; run python scripts/generate_page_messages.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
