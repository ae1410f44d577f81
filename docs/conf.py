"""Sphinx configuration."""

from __future__ import annotations

import sys
from pathlib import Path

from sphinx.application import Sphinx

import nao_kin

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from parameter_tables import write_tables  # noqa: E402 - found beside this file

project = "nao_kin"
author = "The nao_kin developers"
project_copyright = "2026, the nao_kin developers"
version = release = nao_kin.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design", "sphinxcontrib.katex"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_generated"]
nitpicky = False
default_role = "code"

# Words such as q in a Returns section are taken for types, of which there are several.
suppress_warnings = ["ref.python"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"nao_kin {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False

# Formulas need no network: the extension brings KaTeX's program, _static/katex its style and fonts (woff2 alone). Both
# must be of one version, which `npm pack katex@<version>` gives and a test compares.
katex_css_path = "katex/katex.min.css"
katex_options = "throwOnError: true"


def _escape_bars(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Absolute values in docstrings are written |x|, which reStructuredText would take for a substitution."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app: Sphinx) -> None:
    """Write the tables of parameters before the pages are read."""
    app.connect("autodoc-process-docstring", _escape_bars)
    write_tables(HERE / "_generated" / "parameters.md")
