"""Writing motions: the format by its name or suffix, nothing overwritten unasked, all of a file or none of it."""

from __future__ import annotations

from pathlib import Path

from nao_kin._common.atomic import check_writable, replaced_file, write_bytes
from nao_kin._text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.motion.files.reading import described_formats, format_named, formats_of_suffix
from nao_kin.motion.files.source import file_name
from nao_kin.motion.motion import Motion, check_motion


def write_motion(
    motion: Motion,
    path: Path | str,
    *,
    format: str | None = None,
    rate: float | None = None,
    overwrite: bool = False,
) -> None:
    """Write a motion to a file.

    What a format cannot hold is an error where the file would be of no use, as joints that it has no place for, and
    else a `MotionFileWarning`, as curves in a format that knows straight lines only.

    Args:
        motion: what is written.
        path: the file.
        format: one of `FORMATS`, of which "bhuman" and "naodevils" are only read; None for the one that the suffix
            names, ".json" being "json".
        rate: write samples, so many a second, in the place of the keys.
        overwrite: an existing file may be replaced.

    Raises:
        BadArgument: no format, a file that exists or cannot be written, a motion that the format cannot hold.
        UnknownName: no such format.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.xar")
        >>> nk.motion.read_motion("nod.xar").joint_names
        ('HeadPitch',)
    """
    check_motion(motion)
    name = file_name(path)
    if format is None:
        known = formats_of_suffix(name)
        if not known:
            raise BadArgument(
                f"no motion format for {abbreviated(path)}; name one with format= or --to, or end it in one of: "
                f"{described_formats(written=True)}"
            )
        chosen = known[0]
    else:
        chosen = format_named(format)
    if chosen.write is None:
        raise BadArgument(f"{chosen.name} files are only read; write one of: {described_formats(written=True)}")
    check_writable(path)
    target = replaced_file(path)
    if not overwrite and target is not None and target.exists():
        raise BadArgument(f"{abbreviated(path)} exists; overwrite=True replaces it")
    write_bytes(path, chosen.write(motion, rate))
