"""Print docs/cheat_sheet.md on one page of A4: docs/_static/cheat_sheet.pdf.

Headings, Python and shell blocks and paragraphs of the page are set in two columns by HTML and CSS and printed by
Chromium. A comment after the end of the PDF has the hash of its source.

Examples:
    python scripts/make_cheat_sheet.py
    python scripts/make_cheat_sheet.py --check   # exit code 1 if the page has changed since
"""

from __future__ import annotations

import argparse
import hashlib
import re
import subprocess
import sys
import tempfile
from html import escape
from pathlib import Path

from nao_kin._core.files import write_bytes
from nao_kin._core.process import find_browsers

DOCS = Path(__file__).resolve().parent.parent / "docs"
SOURCE, TARGET = DOCS / "cheat_sheet.md", DOCS / "_static" / "cheat_sheet.pdf"
MARK = b"% made from sha256 "
WORDS = re.compile(
    r"(?P<string>\"[^\"]*\")|(?P<keyword>\b(?:import|from|as)\b|\b(?:True|False|None)\b)|(?P<number>\b\d[\d.e-]*\b)"
)
STYLE = """
@page { size: A4; margin: 9mm 9mm 8mm; }
* { box-sizing: border-box; margin: 0; }
body { font: 7.4pt/1.5 "Liberation Sans", Arial, sans-serif; color: #1b2430; }
header { display: flex; align-items: baseline; gap: 4mm; border-bottom: 1.2pt solid #1f5fa8; padding-bottom: 1.2mm; }
h1 { font-size: 15pt; letter-spacing: -0.2pt; white-space: nowrap; color: #1f5fa8; }
header p { font-size: 7pt; color: #4a5666; }
main { columns: 2; column-gap: 5mm; column-fill: balance; margin-top: 2.2mm; }
section { break-inside: avoid; margin-bottom: 3.2mm; border: 0.5pt solid #cfd8e3; border-radius: 1.2mm; }
h2 { font-size: 8.6pt; padding: 0.7mm 1.8mm; background: #e8f0f9; color: #1f5fa8; }
section > p, .code { padding: 1.1mm 1.8mm; }
.line { display: flex; justify-content: space-between; align-items: baseline; gap: 2mm; min-height: 1.4mm; }
code { font: 6.3pt/1.58 "DejaVu Sans Mono", "Liberation Mono", monospace; }
.line code { white-space: pre-wrap; overflow-wrap: anywhere; padding-left: 2em; text-indent: -2em; }
.line i { font-size: 6.7pt; color: #5d6b7c; text-align: right; }
.string { color: #8a4b08; } .keyword { color: #7a2a8c; } .number { color: #0b6b5b; }
"""


def main() -> int:
    """Write the PDF, or check whether it is up to date."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; check whether the PDF is up to date")
    made_from = MARK + _digest().encode()
    if parser.parse_args().check:
        if not TARGET.is_file() or not TARGET.read_bytes().rstrip().endswith(made_from):
            print(
                f"{TARGET.name} is out of date with {SOURCE.name}: run python scripts/make_cheat_sheet.py",
                file=sys.stderr,
            )
            return 1
        return 0
    pdf = _printed(_html(SOURCE.read_text(encoding="utf-8")))
    pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
    if pages != 1:
        print(f"{SOURCE.name} takes {pages} pages; it must fit on one", file=sys.stderr)
        return 1
    write_bytes(TARGET, pdf.rstrip() + b"\n" + made_from + b"\n")
    print(f"{TARGET} ({TARGET.stat().st_size / 1000:.0f} kB)")
    return 0


def _digest() -> str:
    return hashlib.sha256((SOURCE.read_text(encoding="utf-8") + STYLE).encode()).hexdigest()


def _html(page: str) -> str:
    first, *sections = re.split(r"^## ", page, flags=re.MULTILINE)
    body = "".join(_section(text) for text in sections)
    # The link to the PDF makes no sense on paper.
    conventions = first.partition("\n\n")[2].partition(". ")[2]
    return (
        f"<!DOCTYPE html><html lang=en><meta charset=utf-8><title>nao_kin on one page</title><style>{STYLE}</style>"
        f"<header><h1>nao_kin</h1><p>{_prose(conventions)}</p></header><main>{body}</main></html>"
    )


def _section(text: str) -> str:
    title, _, rest = text.partition("\n")
    parts = [f"<h2>{escape(title)}</h2>"]
    for block, prose in re.findall(r"^```\w+\n(.*?)^```|^(\w[^\n]*(?:\n[^\n]+)*)", rest, re.MULTILINE | re.DOTALL):
        lines = "".join(_line(line) for line in block.splitlines())
        parts.append(f"<div class=code>{lines}</div>" if block else f"<p>{_prose(prose)}</p>")
    return f"<section>{''.join(parts)}</section>"


def _line(line: str) -> str:
    code, _, comment = line.partition("  # ")
    remark = f"<i>{escape(comment)}</i>" if comment else ""
    return f"<div class=line><code>{_coloured(code)}</code>{remark}</div>"


def _coloured(code: str) -> str:
    parts, end = [], 0
    for word in WORDS.finditer(code):
        parts += [escape(code[end : word.start()]), f"<span class={word.lastgroup}>{escape(word[0])}</span>"]
        end = word.end()
    return "".join([*parts, escape(code[end:])])


def _prose(text: str) -> str:
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(" ".join(text.split())))


def _printed(html: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        page, pdf = Path(folder) / "page.html", Path(folder) / "page.pdf"
        page.write_text(html, encoding="utf-8")
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--print-to-pdf={pdf}"]
        subprocess.run(
            [find_browsers()[0], *options, f"--user-data-dir={folder}/profile", page.as_uri()],
            check=True,
            capture_output=True,
            timeout=120,
        )
        return pdf.read_bytes()


if __name__ == "__main__":
    sys.exit(main())
