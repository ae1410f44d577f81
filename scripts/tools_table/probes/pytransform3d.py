"""pytransform3d: kinematics of a URDF as a graph of frames."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pytransform3d.urdf import Mesh, UrdfTransformManager

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF with its meshes."""
    frames = UrdfTransformManager()
    frames.load_urdf(path.read_text(encoding="utf-8"), mesh_path=str(path.parent))
    # Shapes and centres of mass are frames too, named link/kind:number.
    links = [frame for frame in frames.nodes if ":" not in frame and not frame.startswith("inertial_frame")]

    def poses(values: Mapping[str, float]) -> Poses:
        for name, value in values.items():
            frames.set_joint(name, value)
        return {link: frames.get_transform(link, "torso") for link in links}

    # pytransform3d reads a mesh only when it draws it, from this file name.
    found = [shape for shape in frames.visuals if isinstance(shape, Mesh) and Path(shape.filename).is_file()]
    return Loaded(poses, meshes=len(found))
