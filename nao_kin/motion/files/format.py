"""What a motion file format is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from nao_kin.motion.files.source import Source
from nao_kin.motion.motion import Motion

# Motion, samples a second or None, the bytes of a file.
Writer = Callable[[Motion, float | None], bytes]


@dataclass(frozen=True)
class Format:
    """A motion file format.

    Attributes:
        name: by which `read_motion` and `write_motion` know it.
        suffixes: of its files, the first one by custom.
        title: what it is, in a few words.
    """

    name: str
    suffixes: tuple[str, ...]
    title: str
    # Whether the content looks like it; never raises.
    recognises: Callable[[Source], bool] = field(repr=False)
    read: Callable[[Source], Motion] = field(repr=False)
    # None for a format that is only read.
    write: Writer | None = field(repr=False, default=None)
