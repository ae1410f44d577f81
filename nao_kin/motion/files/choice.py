"""Which one of several motions in a file."""

from __future__ import annotations

from collections.abc import Sequence

from nao_kin._text import abbreviated, quoted
from nao_kin.errors import nearest_names
from nao_kin.motion.files.source import Source

_MOST_LISTED = 12


def chosen(source: Source, names: Sequence[str], what: str) -> int:
    """The index of the motion that the caller wants.

    Args:
        source: the file; its `timeline` is a name, the end of one after a slash, or a number from 1.
        names: of the motions in the file.
        what: what they are, in messages.

    Raises:
        BadInputFile: none or several fit; lists them.
    """
    wanted = source.timeline
    if wanted is None:
        fitting = list(range(len(names)))
    else:
        fitting = [index for index, name in enumerate(names) if name == wanted]
        fitting = fitting or [index for index, name in enumerate(names) if name.endswith(f"/{wanted}")]
        if not fitting and wanted.isdecimal() and wanted.isascii() and 1 <= int(wanted[:9]) <= len(names):
            fitting = [int(wanted) - 1]
    if len(fitting) == 1:
        return fitting[0]
    shown = fitting or range(len(names))
    listed = ", ".join(f"{index + 1}: {abbreviated(names[index], 60)}" for index in shown[:_MOST_LISTED])
    more = f" and {len(shown) - _MOST_LISTED} more" if len(shown) > _MOST_LISTED else ""
    if wanted is None:
        raise source.error(
            f"{len(names)} {what}; choose one with timeline= or --timeline, by name or number: {listed}{more}"
        )
    if fitting:
        raise source.error(
            f"timeline {quoted(wanted)} stands for {len(fitting)} of the {what}; choose by number: {listed}{more}"
        )
    near = ", ".join(nearest_names(wanted, names))
    listed = f"nearest: {near}" if near else listed + more
    raise source.error(f"no timeline {quoted(wanted)} among {len(names)} {what} ({listed})")
