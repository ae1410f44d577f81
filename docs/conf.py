"""Sphinx configuration."""

from __future__ import annotations

import sys
from importlib.metadata import metadata
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.inspect import TypeAliasForwardRef

import nao_kin

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "scripts")]

from docstring_markup import ARRAYS, as_written, types_in_public_words  # noqa: E402 - found beside this file
from lecture_pages import write_lecture  # noqa: E402
from live_pages import write_pages  # noqa: E402
from parameter_tables import write_tables  # noqa: E402
from search_ranks import setup_ranks  # noqa: E402
from shown_names import setup_names  # noqa: E402

project = "nao_kin"
author = "The nao_kin developers"
project_copyright = "2026, the nao_kin developers"
version = release = nao_kin.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design", "sphinxcontrib.katex"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_generated"]
nitpicky = True
# Rows of results and tables: whatever contains them describes their attributes, and they have no entries of their own.
ROWS = (
    "BadRow|BalanceInterval|CameraRow|Change|Collision|Contact|CouplingViolation|Finger|Frame|Inertial|InertialRow|Joint|JointTableRow"
    "|Log|MotionViolation|MultiDofJoint|Origin|OutsideRows|Row|ShapeRow|Stance|Step|UrdfJoint|Visual|VisualRow"
)
# Types of other libraries, whose documentation a build without a network cannot ask, and names of ours that nobody
# meets but as a value.
nitpick_ignore_regex = [
    ("py:class", r"(?!nao_kin\.).*"),
    (
        "py:class",
        r"nao_kin\.(?:\w+\.)+(?:Call|DataFrame|Series|IsoTimes|CachedKernel|Made|Question|Segments|Subscription)",
    ),
    ("py:class", rf"nao_kin\.(?:\w+\.)+(?:{ROWS})"),
    ("py:class", r"nao_kin\.(?:\w+\.)+(?:TableColumns|Tables|Task|_\w+)"),
]
default_role = "code"

# Words such as q in a Returns section are taken for types, of which there are several.
suppress_warnings = ["ref.python"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
# The fields of a dataclass stand once, as attributes, with what they mean.
autodoc_typehints_description_target = "documented_params"
# As they are written in the code; what they stand for takes lines.
autodoc_type_aliases = {name: name for name in ("ArrayLike", "DTypeLike", "NDArray")} | ARRAYS
napoleon_google_docstring = True
napoleon_numpy_docstring = False
strip_signature_backslash = True  # and napoleon escapes the name `as_`, which is no reference

html_theme = "furo"
html_title = f"nao_kin {release}"
html_static_path = ["_static", "_generated/static"]
html_css_files = ["site.css"]
# Each page leads to its source, and says how to get the library until there is a release.
REPOSITORY = dict(line.split(", ") for line in metadata("nao-kin").get_all("Project-URL") or ())["Source"]
html_theme_options = {"source_repository": REPOSITORY, "source_branch": "main", "source_directory": "docs/"}
if "dev" in release:
    html_theme_options["announcement"] = (
        f"Not on PyPI yet: <code>git clone {REPOSITORY} && pip install ./nao_kin</code>. Then each "
        "<code>pip install 'nao-kin[…]'</code> of these pages adds an extra."
    )
html_show_sourcelink = False
html_search_scorer = str(HERE / "search_scorer.js")

# Formulas need no network: the extension brings KaTeX's program, _static/katex its style and fonts (woff2 alone). Both
# must be of one version, which `npm pack katex@<version>` gives and a test compares.
katex_css_path = "katex/katex.min.css"
katex_options = "throwOnError: true"


def _parametrised(alias: TypeAliasForwardRef, kind: Any) -> TypeAliasForwardRef:
    return TypeAliasForwardRef(f"{alias.name}[{getattr(kind, '__name__', kind)}]")


# Sphinx's stand-ins for aliases say their name alone, and not within `… | None` or before brackets.
TypeAliasForwardRef.__repr__ = lambda alias: alias.name
TypeAliasForwardRef.__getitem__ = _parametrised


def setup(app: Sphinx) -> None:
    """Write tables and the lecture before the pages are read, and for a site the pages with a robot."""
    app.connect("autodoc-process-docstring", as_written, priority=400)
    app.connect("autodoc-process-docstring", types_in_public_words)
    setup_names(app)
    setup_ranks(app)
    write_tables(HERE / "_generated" / "parameters.md")
    static = HERE / "_generated" / "static"
    static.mkdir(parents=True, exist_ok=True)
    app.connect("builder-inited", lambda app: write_pages(static) if app.builder.format == "html" else None)
    write_lecture(HERE.parent / "examples" / "notebooks", HERE / "lecture")
