"""The reference shows names as programs write them: nk.ik.leg, nk.lines.angle for nao_kin.screws.lines.angle."""

from __future__ import annotations

import inspect
import re
import sys
from types import ModuleType
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

import nao_kin as nk

# Module → how programs write it. `typed` is another name of `joints`.
_WRITTEN = {f"nao_kin{name}": f"nk{name}" for name in ("", ".rotations.rank_one", ".viewer.figures")} | {
    room.__name__: f"nk.{name}"
    for name in nk.__all__
    if name != "typed" and isinstance(room := getattr(nk, name), ModuleType)
}
_NAME = re.compile(r"\b(nao_kin(?:\.\w+)*)\.(\w*)")


def setup_names(app: Sphinx) -> None:
    """Show them so in all entries; links, anchors and the search keep the whole names.

    Below what a module is about, a table leads to its functions, which otherwise come after all classes.
    """
    app.connect("doctree-read", _show)
    app.connect("autodoc-process-docstring", _list_functions, priority=600)


def _list_functions(app: Sphinx, what: str, module: str, obj: Any, options: Any, lines: list[str]) -> None:
    if what != "module":
        return
    names = [name for name in getattr(obj, "__all__", ()) if name not in (options.exclude_members or ())]
    functions = {name: inspect.getdoc(getattr(obj, name)) for name in names if inspect.isroutine(getattr(obj, name))}
    if len(functions) > 3:
        lines += ["", ".. list-table::", ""]
        for name, text in functions.items():
            lines.append(f"   * - :py:func:`{_WRITTEN.get(module, module)}.{name} <{module}.{name}>`")
            lines.append("     - " + " ".join((text or "").partition("\n\n")[0].split()).replace("|", "\\|"))


def _show(app: Sphinx, doctree: nodes.document) -> None:
    for entry in doctree.findall(addnodes.desc):
        for text in list(entry.findall(nodes.Text)):
            text.parent.replace(text, nodes.Text(_NAME.sub(_written, text)))


def _written(name: re.Match[str]) -> str:
    """Return the name in its room, or alone if its module is internal."""
    module, last = name.groups()
    if module in _WRITTEN:
        return f"{_WRITTEN[module]}.{last}"
    return last if module in sys.modules and last else name[0]
