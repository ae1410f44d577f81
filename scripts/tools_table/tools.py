"""The export for each tool, as recommended in the documentation and tested by the measurement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType


@dataclass(frozen=True)
class Tool:
    """A tool, and the export to use with it.

    Attributes:
        name: its usual name.
        package: its name for pip; the page shows its version.
        probe: module in `probes`.
        format: one of `nao_kin.export.FORMATS`.
        snippet: a few lines that load the export, run as shown.
        remarks: remarks on the page.
        options: of the format.
        output: the file or folder to write.
        more: further packages to install.
        bound: the versions of the package to use, as pip writes them: "<4"; "" for the newest.
    """

    name: str
    package: str
    probe: str
    format: str
    snippet: str
    remarks: str
    options: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    output: str = "nao.urdf"
    more: tuple[str, ...] = ()
    bound: str = ""

    @property
    def key(self) -> str:
        """The package with its bound, unique in the table."""
        return self.package + self.bound

    @property
    def requirements(self) -> tuple[str, ...]:
        """The packages to install."""
        return (self.key, *self.more)

    @property
    def command(self) -> str:
        """The command that exports V6."""
        options = "".join(f" --{name.replace('_', '-')} {value}" for name, value in self.options.items())
        return f"nao-kin export {self.output} --format {self.format}{options}"


MUJOCO = Tool(
    "MuJoCo",
    "mujoco",
    "mujoco",
    "mjcf",
    """\
import mujoco

model = mujoco.MjModel.from_xml_path("nao_mujoco/scene.xml")
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, model.key("StandInit").id)
mujoco.mj_step(model, data)
""",
    "The robot stands on its soles in simulation. If you set joints without simulating, set the mimic joints too: "
    "{doc}`mujoco`.",
    output="nao_mujoco",
)

TOOLS = (
    MUJOCO,
    replace(
        MUJOCO,
        name="MuJoCo 3",
        bound="<4",
        remarks="This is the newest MuJoCo 3, with the files that MuJoCo 4 writes.",
    ),
    replace(
        MUJOCO,
        name="MuJoCo 3.3",
        bound="==3.3.6",
        remarks="This is the oldest version that the library supports, with the files that MuJoCo 4 writes.",
    ),
    Tool(
        "mink",
        "mink",
        "mink",
        "mjcf",
        """\
import mink
import mujoco

configuration = mink.Configuration(mujoco.MjModel.from_xml_path("nao_mujoco/scene.xml"))
configuration.update_from_keyframe("StandInit")
couplings = mink.EqualityConstraintTask(configuration.model, cost=1.0)
""",
        "Pass `couplings` to `solve_ik` with the other tasks; mink does not add it.",
        {"base": "fixed"},
        "nao_mujoco",
        ("daqp",),
    ),
    Tool(
        "Drake",
        "drake",
        "drake",
        "urdf",
        """\
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

plant = MultibodyPlant(time_step=1e-3)
Parser(plant).AddModels("nao.urdf")
plant.Finalize()
""",
        "The couplings are constraints of a plant with a time step, and apply in simulation. `set_angle` does not "
        "apply them; set the mimic joints too.",
        {"inertia": "physical"},
    ),
    Tool(
        "PyBullet",
        "pybullet",
        "pybullet",
        "urdf",
        """\
import pybullet

pybullet.connect(pybullet.DIRECT)
robot = pybullet.loadURDF("nao.urdf")
""",
        "Link states have single precision. PyBullet ignores couplings, and the file has none: set both hips, and "
        "the fingers. With more than 128 links it returns no states; `--frames effectors` exports fewer.",
        {"frames": "effectors", "coupling": "independent", "inertia": "physical"},
        more=("numpy",),
    ),
    Tool(
        "Pinocchio",
        "pin",
        "pinocchio",
        "urdf",
        """\
import pinocchio

floating = pinocchio.JointModelFreeFlyer()
robot = pinocchio.RobotWrapper.BuildFromURDF("nao.urdf", ["."], floating, mimic=True)
""",
        "Without `mimic=True` the joints are uncoupled. `nao.model` is the coupled model, without a file.",
    ),
    Tool(
        "pink",
        "pin-pink",
        "pink",
        "urdf",
        """\
import pink
import pinocchio

floating = pinocchio.JointModelFreeFlyer()
robot = pinocchio.RobotWrapper.BuildFromURDF("nao.urdf", ["."], floating, mimic=True)
configuration = pink.Configuration(robot.model, robot.data, robot.q0)
""",
        "pink uses a Pinocchio model: without `mimic=True` the joints are uncoupled.",
        more=("daqp",),
    ),
    Tool(
        "placo",
        "placo",
        "placo",
        "urdf",
        """\
import placo

robot = placo.RobotWrapper("./nao.urdf", placo.Flags.ignore_collisions)
solver = placo.KinematicsSolver(robot)
solver.add_gear_task().set_gear("RHipYawPitch", "LHipYawPitch", 1.0)
""",
        "placo ignores the couplings of a file, and this file has none: add a gear task for the hips to the solver. If "
        "you set joints directly, set both. placo finds meshes only if the path begins with `./`. It requires "
        "another version of Pinocchio than this library: install it in an environment of its own.",
        {"coupling": "independent"},
    ),
    Tool(
        "yourdfpy",
        "yourdfpy",
        "yourdfpy",
        "urdf",
        """\
import yourdfpy

robot = yourdfpy.URDF.load("nao.urdf")
robot.update_cfg({"HeadYaw": 0.5})
""",
        "",
    ),
    Tool(
        "urchin",
        "urchin",
        "urchin",
        "urdf",
        """\
import urchin

robot = urchin.URDF.load("nao.urdf")
poses = robot.link_fk({"HeadYaw": 0.5})
""",
        "urchin is the successor of urdfpy. It assumes 1 kg for a link without a mass: 104 kg in total without "
        "`--inertia physical`.",
        {"frames": "effectors", "inertia": "physical"},
    ),
    Tool(
        "viser",
        "viser",
        "viser",
        "urdf",
        """\
from pathlib import Path

import viser
from viser.extras import ViserUrdf

robot = ViserUrdf(viser.ViserServer(), Path("nao.urdf"))
""",
        "viser reads the file with yourdfpy.",
        more=("yourdfpy",),
    ),
    Tool(
        "rerun",
        "rerun-sdk",
        "rerun",
        "urdf",
        """\
import rerun
from rerun.urdf import UrdfTree

rerun.init("nao", spawn=False)
tree = UrdfTree.from_file_path("nao.urdf")
tree.log_urdf_to_recording()
""",
        "rerun shows the transforms that you log, in single precision. `joint.mimic` describes the coupling of a "
        "joint; apply it when you log.",
    ),
    Tool(
        "ikpy",
        "ikpy",
        "ikpy",
        "urdf",
        """\
from ikpy.chain import Chain

joints = ["LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw"]
links = ["LShoulder", "LBicep", "LElbow", "LForeArm", "l_wrist"]
path = ["torso", *(name for pair in zip(joints, links) for name in pair)]
arm = Chain.from_urdf_file("nao.urdf", base_elements=[*path, "LArm_fixed", "LArm"])
""",
        "ikpy loads one chain at a time. It ignores couplings, and the file has none: give both legs the same "
        "`HipYawPitch`.",
        {"coupling": "independent", "meshes": "none"},
    ),
    Tool(
        "Robotics Toolbox",
        "roboticstoolbox-python",
        "roboticstoolbox",
        "urdf",
        """\
from pathlib import Path

from roboticstoolbox.models.URDF.URDFRobot import URDFRobot

robot = URDFRobot(Path("nao.urdf").resolve())
""",
        "The toolbox rotates the frame of a joint with an oblique axis, and with it the legs, by a wrong angle; with "
        "`--axes aligned` there is no such joint. The toolbox ignores couplings, and the file has none: set both "
        "values.",
        {"coupling": "independent", "axes": "aligned"},
    ),
    Tool(
        "pytransform3d",
        "pytransform3d",
        "pytransform3d",
        "urdf",
        """\
from pathlib import Path

from pytransform3d.urdf import UrdfTransformManager

frames = UrdfTransformManager()
frames.load_urdf(Path("nao.urdf").read_text(), mesh_path=".")
T_torso_hand = frames.get_transform("LArm", "torso")
""",
        "pytransform3d ignores couplings, and the file has none: set both values.",
        {"coupling": "independent"},
        more=("lxml", "trimesh"),
    ),
    Tool(
        "kinpy",
        "kinpy",
        "kinpy",
        "urdf",
        """\
from pathlib import Path

import kinpy

chain = kinpy.build_chain_from_urdf(Path("nao.urdf").read_bytes())
poses = chain.forward_kinematics({"HeadYaw": 0.5})
""",
        "Pass bytes: the parser rejects text with an encoding declaration. kinpy ignores couplings, and the file has "
        "none: set both values.",
        {"coupling": "independent"},
    ),
    Tool(
        "pytorch_kinematics",
        "pytorch-kinematics",
        "pytorch_kinematics",
        "urdf",
        """\
from pathlib import Path

import pytorch_kinematics
import torch

chain = pytorch_kinematics.build_chain_from_urdf(Path("nao.urdf").read_bytes())
poses = chain.forward_kinematics(torch.zeros(100, chain.n_joints))
""",
        "Origins are read in single precision, even if the chain is converted to double. pytorch_kinematics ignores "
        "couplings, and the file has none: set both values.",
        {"coupling": "independent"},
    ),
)
