"""Sphinx configuration."""

from __future__ import annotations

import nao_kin

project = "nao_kin"
author = "The nao_kin developers"
project_copyright = "2026, the nao_kin developers"
version = release = nao_kin.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_generated"]
nitpicky = False
default_role = "code"

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"nao_kin {release}"
# Formulas are set in the browser; without a network they stay readable as TeX.
html_show_sourcelink = False


def setup(app: object) -> None:
    """Write the tables of parameters before the pages are read."""
    import sys
    from pathlib import Path

    here = Path(__file__).resolve().parent
    sys.path.insert(0, str(here))
    from parameter_tables import write_tables

    write_tables(here / "_generated" / "parameters.md")
