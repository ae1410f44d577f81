"""Foreign text inside messages: on one line, and never more of it than a reader needs."""

from __future__ import annotations

# No message repeats more than this of what it was given.
MOST_ECHOED = 200


def abbreviated(value: object, most: int = MOST_ECHOED) -> str:
    """`str(value)` on one line of at most `most` characters, the end replaced by … where there was more."""
    text = str(value)
    text = " ".join(text[: 4 * most].split()) + ("…" if len(text) > 4 * most else "")
    return text if len(text) <= most else f"{text[: most - 1]}…"


def quoted(value: object, most: int = MOST_ECHOED) -> str:
    """`repr(value)`, abbreviated; of a long text only the beginning is looked at."""
    return abbreviated(repr(value[: 4 * most] if isinstance(value, (str, bytes)) else value), most)
