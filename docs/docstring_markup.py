"""Docstrings are plain text; this makes of them what reStructuredText shows the same way."""

from __future__ import annotations

import re

# What nao_kin._core.arrays calls arrays, and readers know by another name.
ARRAYS = {name: f"NDArray[{kind}]" for name, kind in (("Codes", "int8"), ("Floats", "float64"), ("Integers", "int64"))}


def as_written(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Mark indented blocks as literal, and keep |x| from becoming a substitution.

    For Sphinx's event autodoc-process-docstring, before napoleon looks for sections: what is indented below a section's
    name follows it without an empty line, and is no block.
    """
    marked: list[str] = []
    block = example = False
    for above, line in zip(["", *lines], lines, strict=False):
        indented = line.startswith("    ")
        if above == "Returns:" and ":" in line:
            marked.append("    \\")  # else napoleon takes what stands before the colon for a type
        if indented and not above and marked[-2:-1] and marked[-2] and not marked[-2].startswith(" "):
            block = True
            marked += [] if marked[-2].endswith("::") else ["::", ""]
        block = block and (indented or not line)
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>> "))
        marked.append(line if block or example else line.replace("|", r"\|"))
    lines[:] = marked


def types_in_public_words(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Types of attributes, which napoleon writes as it finds them: bool for bool_, arrays for our own aliases."""
    for number, line in enumerate(lines):
        if line.lstrip().startswith(":type:"):
            words = re.sub(r"\b\w+\b", lambda word: ARRAYS.get(word[0], word[0]), line)
            lines[number] = words.replace("np.bool_", "bool")
