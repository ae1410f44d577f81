"""The versions: V6's tables are complete, each other version is a page of what it has otherwise than another one."""

from __future__ import annotations

from nao_kin.parameters.bodies import V6_INERTIALS, V6_VISUALS
from nao_kin.parameters.frames import V6_FRAMES
from nao_kin.parameters.overlay import Tables, VersionPage
from nao_kin.parameters.ranges import V6_ACTUATORS, V6_LIMITS
from nao_kin.parameters.rows import Version
from nao_kin.parameters.skeleton import V6_OFFSETS
from nao_kin.parameters.versions.v4 import V4
from nao_kin.parameters.versions.v5 import V5
from nao_kin.parameters.versions.v32 import V32
from nao_kin.parameters.versions.v33 import V33

V6 = Tables(
    offsets=V6_OFFSETS,
    limits=V6_LIMITS,
    actuators=V6_ACTUATORS,
    inertials=V6_INERTIALS,
    frames=V6_FRAMES,
    visuals=V6_VISUALS,
    placeholder=None,
)

# A page stands after the one that it is laid over.
PAGES: tuple[VersionPage, ...] = (V5, V4, V33, V32)


def tables_of_versions() -> dict[Version, Tables]:
    """The complete tables of each version, by laying the pages over each other."""
    tables: dict[Version, Tables] = {"v6": V6}
    for page in PAGES:
        tables[page.version] = page.over(tables[page.base])
    return tables


TABLES = tables_of_versions()
