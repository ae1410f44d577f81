"""Export a NAO, with the results that the tool must reproduce."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import nao_kin as nk
from tools_table.tools import Tool

SAMPLES = 5


def write_export(tool: Tool, version: str, folder: Path) -> dict[str, Any]:
    """Export a version for a tool into a folder, with the expected results in `reference.json`; return these."""
    nao, options = nk.load_nao(version), dict[str, Any](tool.options)
    done = nk.export.write(nao, folder / tool.output, tool.format, **options)
    q = nao.random(np.random.default_rng(7), SAMPLES)
    drivers = {name: q[:, index] for index, name in enumerate(nao.joint_names)}
    followers = {name: mimic.value(drivers[mimic.joint]) for name, mimic in nao.mimics.items()}
    reference = {
        "path": str(done.path.relative_to(folder)),
        "drivers": {name: values.tolist() for name, values in drivers.items()},
        "followers": {name: np.asarray(values).tolist() for name, values in followers.items()},
        "couplings": {name: [m.joint, m.multiplier, m.offset] for name, m in nao.mimics.items()},
        "links": list(nao.link_names),
        "poses": nao.fk(q, nao.link_names, reference="torso").tolist(),
        "mass": nao.mass,
    }
    (folder / "reference.json").write_text(json.dumps(reference), encoding="utf-8")
    return reference
