"""Write `web/src/received.ts`: the types of the messages that the page receives, from `nao_kin.viewer.messages.KINDS`.

With `--check` it writes nothing, and fails if the file is out of date.

Example:
    python scripts/generate_page_messages.py --check
"""

from __future__ import annotations

import sys
from pathlib import Path

from nao_kin.viewer.messages import KINDS

TARGET = Path(__file__).resolve().parent.parent / "web" / "src" / "received.ts"
# The line length of Prettier, which breaks longer lines.
WIDTH = 120

HEAD = """\
// Written by scripts/generate_page_messages.py from nao_kin/viewer/messages.py.

import type { About, Control, Vector } from "./types.ts";

/** The contents of each kind of message from Python. */
export interface Received {
"""


def text() -> str:
    """Return the text of the TypeScript module."""
    kinds: list[str] = []
    for name, kind in KINDS.items():
        fields = [f"{field}: {type_};" for field, type_ in kind.fields.items()]
        line = f"  {name}: {{ {' '.join(fields).removesuffix(';')} }};" if fields else f"  {name}: object;"
        lines = [line] if len(line) <= WIDTH else [f"  {name}: {{", *(f"    {field}" for field in fields), "  };"]
        kinds += lines
    return HEAD + "\n".join([*kinds, "}", ""])


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
