"""Numbers in text, as people and files write them."""

from __future__ import annotations

import re

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def decimal(text: str) -> float:
    """The number that `text` writes in decimal digits.

    Python's own `float` also takes 1_0 for 10 and digits of any script, which nobody writes on purpose.

    Raises:
        ValueError: no decimal number; "nan" and "inf" are none.
    """
    stripped = text.strip()
    if not _DECIMAL.fullmatch(stripped):
        raise ValueError(f"not a decimal number: {text!r}")
    return float(stripped)
