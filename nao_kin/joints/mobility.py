"""How many independent motions a mechanism has: the Grübler–Kutzbach count."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from nao_kin._scalars import whole_number
from nao_kin.errors import BadArgument
from nao_kin.joints.pairs import LowerPair, lower_pair


def mobility(
    pairs: Iterable[LowerPair | str],
    *,
    links: int | None = None,
    couplings: int = 0,
    space: Literal[3, 6] = 6,
) -> int:
    """Degrees of freedom of a mechanism, M = d (n − 1 − j) + Σ fᵢ − c.

    n links, the frame included, are connected by j joints with fᵢ freedoms in a space of d = 6 motions; every coupling
    (one motor for two joints, a gear, a tendon) takes one more away. In a chain or tree n − 1 = j, and the count is the
    sum of the freedoms less the couplings, exact for all dimensions. In a mechanism with loops it is a lower bound:
    special dimensions can make constraints redundant (a planar four-bar linkage counted in space has −2; count it with
    space=3).

    Args:
        pairs: the joints, as pairs or their names.
        links: n; left out, the mechanism is a chain or tree and n = j + 1.
        couplings: c.
        space: d: 6, or 3 for a mechanism that moves in a plane.

    Raises:
        UnknownName: no such pair.
        BadArgument: links or couplings that are no count, or links the joints cannot connect; a space other than 3 or
            6; a joint with more freedoms than the space has.

    Source: Hartenberg and Denavit, Kinematic Synthesis of Linkages, 1964, ch. 5.
    """
    if not isinstance(pairs, Iterable):
        raise BadArgument(f"pairs must be a list of joints, got {pairs!r}")
    known = [pair if isinstance(pair, LowerPair) else lower_pair(pair) for pair in pairs]
    if space not in (3, 6):
        raise BadArgument(f"space must be 3 or 6, got {space!r}")
    freest = max((pair.freedoms for pair in known), default=0)
    if freest > space:
        raise BadArgument(f"a joint of {freest} freedoms does not fit a space of {space}")
    n = len(known) + 1 if links is None else whole_number(links, "links", 1)
    if n > len(known) + 1:
        raise BadArgument(f"{len(known)} joints cannot connect {n} links")
    c = whole_number(couplings, "couplings", 0)
    return space * (n - 1 - len(known)) + sum(pair.freedoms for pair in known) - c
