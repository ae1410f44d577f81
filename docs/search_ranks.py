"""How much each page of the documentation is about a word, for search_scorer.js."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

FILE = "search_ranks.js"
_WORDS = 120  # kept of a page: those it has most often


def setup_ranks(app: Sphinx) -> None:
    """Write the file with the ranks after a build of HTML pages, and load it into the search page."""
    app.connect("html-page-context", _load_ranks)
    app.connect("build-finished", _write_ranks)


def _load_ranks(app: Sphinx, page: str, *_: Any) -> None:
    if page == "search":
        app.add_js_file(FILE)


def _write_ranks(app: Sphinx, error: Exception | None) -> None:
    if error is not None or app.builder.format != "html":
        return
    counts = {
        page: Counter(re.findall(r"[^\W\d_]{2,}", app.env.get_doctree(page).astext().lower()))
        for page in sorted(app.env.found_docs)
    }
    mean = sum(count.total() for count in counts.values()) / len(counts)
    # The weight of a word in BM25 with its usual constants: it grows with the count and falls with the page's length.
    ranks = {
        page: {
            word: round(n / (n + 1.2 * (0.25 + 0.75 * count.total() / mean)), 2)
            for word, n in count.most_common(_WORDS)
        }
        for page, count in counts.items()
    }
    text = json.dumps(ranks, ensure_ascii=False, separators=(",", ":"))
    (Path(app.outdir) / "_static" / FILE).write_text(f"const SEARCH_RANKS = {text};\n", encoding="utf-8")
