"""Which bodies of a robot do not touch each other."""

from __future__ import annotations

from typing import Any


def add_excludes(spec: Any) -> tuple[str, ...]:
    """No contacts between neighbours, nor between bodies whose shapes overlap with all joints at zero or in a posture.

    Collision shapes stand for links roughly: those of neighbours overlap always, and others where the real shells just
    pass each other. Neighbours are a body and the nearest before it that has a shape.

    Args:
        spec: the specification, with shapes and key frames.

    Returns:
        One line that names the pairs that are no neighbours.
    """
    import mujoco

    model = spec.compile()
    data = mujoco.MjData(model)
    apart: dict[tuple[int, int], None] = {}
    touching = {int(model.geom_bodyid[geom]) for geom in range(model.ngeom) if model.geom_contype[geom]}
    for body in range(1, model.nbody):
        before = int(model.body_parentid[body])
        while before and before not in touching:
            before = int(model.body_parentid[before])
        if body in touching and before:
            apart[before, body] = None
    neighbours = len(apart)
    for key in range(-1, model.nkey):
        if key < 0:
            mujoco.mj_resetData(model, data)
        else:
            mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        for contact in data.contact:
            first, second = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
            if contact.dist < 0.0:
                apart[first, second] = None
    for first, second in apart:
        spec.add_exclude(bodyname1=model.body(first).name, bodyname2=model.body(second).name)
    pairs = [f"{model.body(a).name}–{model.body(b).name}" for a, b in list(apart)[neighbours:]]
    return (f"shapes overlap in a posture, and do not touch: {', '.join(pairs)}",) if pairs else ()
