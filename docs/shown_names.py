"""Short names in the reference, as programs write them: nk.screws.lines.angle instead of nao_kin.screws.lines.angle."""

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

# Module → how programs write it.
_WRITTEN = {f"nao_kin{name}": f"nk{name}" for name in ("", ".rotations.rank_one", ".screws.lines")} | {
    room.__name__: f"nk.{name}"
    for name in (*nk.__all__, *nk._UNLISTED)
    if isinstance(room := getattr(nk, name), ModuleType)
}
_NAME = re.compile(r"\b(nao_kin(?:\.\w+)*)\.(\w*)")
# Before a method of a robot that has an entry of its own.
_METHOD = re.compile(r"^RobotModel\.$")


def setup_names(app: Sphinx) -> None:
    """Show short names in all entries, and a table of the functions of each module.

    Links, anchors and the search keep the full names. The table stands below the module's description, because the
    entries of the functions come after those of all classes.
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
            text.parent.replace(text, nodes.Text(_NAME.sub(_written, _METHOD.sub("nao.", text))))


def _written(name: re.Match[str]) -> str:
    """Return a name as programs write it, or without its module if the module is internal."""
    module, last = name.groups()
    if module in _WRITTEN:
        return f"{_WRITTEN[module]}.{last}"
    return last if module in sys.modules and last else name[0]
