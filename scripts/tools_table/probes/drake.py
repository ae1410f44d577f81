"""Drake: kinematics and a moment of free fall, with the couplings as constraints."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

from pydrake.geometry import Mesh, Role
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from tools_table.probes.loaded import Loaded, Poses

_STEP, _SECONDS = 1e-3, 0.2


def load(path: Path) -> Loaded:
    """Load a URDF."""
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, _STEP)
    (robot,) = Parser(plant).AddModels(str(path))
    plant.Finalize()
    diagram = builder.Build()
    joints = [plant.get_joint(index) for index in plant.GetJointIndices(robot)]
    moving = {joint.name(): joint for joint in joints if joint.num_positions() == 1}
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(robot)]
    shown = scene.model_inspector()
    frames = [shown.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()), Role.kIllustration) for body in bodies]
    meshes = sum(isinstance(shown.GetShape(geometry), Mesh) for geometries in frames for geometry in geometries)
    # Drake does not name the joints of its constraints; the file does.
    coupled = [
        joint.attrib["name"] for joint in ET.parse(path).getroot().iter("joint") if joint.find("mimic") is not None
    ]

    def poses(values: Mapping[str, float]) -> Poses:
        context = plant.CreateDefaultContext()
        for name, value in values.items():
            moving[name].set_angle(context, value)
        return {body.name(): plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4() for body in bodies}

    def simulate() -> dict[str, float]:
        simulator = Simulator(diagram)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        simulator.Initialize()
        simulator.AdvanceTo(_SECONDS)
        return {name: joint.get_angle(context) for name, joint in moving.items()}

    return Loaded(
        poses,
        mass=plant.CalcTotalMass(plant.CreateDefaultContext(), [robot]),
        meshes=meshes,
        held=coupled if plant.num_constraints() == len(coupled) else (),
        simulate=simulate,
    )
