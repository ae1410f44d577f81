"""`nao-kin info`: what robot this is."""

from __future__ import annotations

from nao_kin.cli.options import (
    JsonOption,
    OffsetsOption,
    PackageDirOption,
    RobotOption,
    UrdfOption,
    VersionOption,
    XacroOption,
    command,
    load,
)
from nao_kin.cli.output import print_json, print_table


@command("info", "Example: nao-kin info --version v5 --json")
def info(
    version: VersionOption = "v6",
    urdf: UrdfOption = None,
    robot: RobotOption = None,
    package_dir: PackageDirOption = None,
    xacro: XacroOption = False,
    offsets: OffsetsOption = None,
    json: JsonOption = False,
) -> None:
    """Name, degrees of freedom, mass, chains, postures and the file of a robot."""
    model = load(version, urdf, robot, package_dir, xacro, offsets)
    facts: dict[str, object] = {
        "name": model.name,
        "degrees_of_freedom": model.nv,
        "joints": len(model.joint_names),
        "following_joints": len(model.mimics),
        "links": len(model.link_names),
        "frames": len(model.frame_names),
        "mass_kg": round(model.mass, 9),
        "urdf": str(model.urdf_path),
        "load_notes": list(model.load_notes),
    }
    if model.semantics.version:
        facts["version"] = model.semantics.version
    if model.chains:
        facts["chains"] = {chain: list(names) for chain, names in model.chains.items()}
    if model.posture_names:
        facts["postures"] = list(model.posture_names)
    if json:
        print_json(facts)
        return
    print_table(
        ("fact", "value"), [(key.replace("_", " "), _text(value)) for key, value in facts.items() if value != []]
    )


def _text(value: object) -> str:
    if isinstance(value, dict):
        return "\n".join(f"{key}: {', '.join(names)}" for key, names in value.items())
    if isinstance(value, list):
        return "\n".join(value) if any(" " in str(item) for item in value) else ", ".join(value)
    return f"{value:.5f}" if isinstance(value, float) else str(value)
