"""`robot.geometry`: the shapes of the links as Pinocchio has them."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from made_up_robots import with_shapes

import nao_kin as nk
from nao_kin.errors import MissingShapeWarning, UnknownName


def _placements(robot: nk.RobotModel, geometry: pin.GeometryModel, q: np.ndarray) -> dict[str, np.ndarray]:
    data, shapes = robot.model.createData(), geometry.createData()
    pin.updateGeometryPlacements(robot.model, data, geometry, shapes, q)
    return {shape.name: shapes.oMg[index].homogeneous for index, shape in enumerate(geometry.geometryObjects)}


@pytest.mark.full
@pytest.mark.parametrize("kind", ["visual", "collision"])
@pytest.mark.parametrize("name", ["nao", "romeo", "ur5_robot"])
def test_every_shape_is_the_one_that_pinocchio_s_own_parser_makes(name: str, kind: str) -> None:
    robot = nk.load_nao() if name == "nao" else nk.load_robot(name)
    theirs_of = pin.GeometryType.VISUAL if kind == "visual" else pin.GeometryType.COLLISION
    # Without mimic joints, whose order Pinocchio's parser refuses in Romeo's file; the shapes do not depend on them.
    model = pin.buildModelFromUrdf(str(robot.urdf_path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its arguments
        folders = [str(folder) for folder in robot.urdf_path.parents]
        expected = pin.buildGeomFromUrdf(model, str(robot.urdf_path), theirs_of, folders)
    theirs = {shape.name: shape for shape in expected.geometryObjects}
    ours = {shape.name: shape for shape in robot.geometry(kind).geometryObjects}
    assert ours.keys() == theirs.keys()
    for shape, other in ((ours[name], theirs[name]) for name in ours):
        assert robot.model.names[shape.parentJoint] == model.names[other.parentJoint]
        assert robot.model.frames[shape.parentFrame].name == model.frames[other.parentFrame].name
        assert np.abs(shape.placement.homogeneous - other.placement.homogeneous).max() < 1e-12
        assert type(shape.geometry) is type(other.geometry)
        assert np.array_equal(shape.meshScale, other.meshScale)
        assert np.allclose(shape.meshColor, other.meshColor, atol=1e-6)
        assert shape.overrideMaterial == other.overrideMaterial
        assert shape.meshPath == other.meshPath or "/" not in other.meshPath


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_shapes_follow_their_links_mimic_joints_and_the_base_included(base: str) -> None:
    nao = nk.load_nao("v5", base=base)
    visual = nao.geometry("visual")
    links = [visual_row.link for visual_row in nao.tree.visuals]
    for q in nao.random(3, 4):
        poses = dict(zip(nao.link_names, nao.fk(q, reference="world" if base == "floating" else None), strict=True))
        for name, T in _placements(nao, visual, q).items():
            link, _, number = name.rpartition("_")
            own = [row for row in nao.tree.visuals if row.link == link][int(number)]
            T_link_shape = nk.screws.pose(nk.rotations.matrix_from_rpy(own.origin.rpy), own.origin.xyz)
            assert np.abs(T - poses[link] @ T_link_shape).max() < 1e-12
    assert len(links) == visual.ngeoms


@pytest.mark.parametrize("ending", ["stl", "ply"])
def test_a_mirrored_mesh_is_scaled_once_by_whoever_draws_it(nao: nk.NaoModel, tmp_path: Path, ending: str) -> None:
    robot = with_shapes(tmp_path, ending)
    with pytest.warns(MissingShapeWarning, match=r"^shapes: a visual shape of arm is left out: .*absent\.stl"):
        wedge = robot.geometry("visual").geometryObjects[1]
    # Pinocchio's visualizers multiply what they draw by meshScale: the file's vertices, or those that coal has read.
    wedge.geometry.computeLocalAABB()
    box = wedge.geometry.aabb_local
    assert np.allclose(box.min_, [0, -0.05, 0])
    assert np.allclose(box.max_, [0.1, 0, 0.15])
    if ending == "stl":
        assert (Path(wedge.meshPath).name, wedge.meshScale.tolist()) == ("wedge.stl", [0.5, -0.5, 0.5])
    else:
        assert (wedge.meshPath, wedge.meshScale.tolist()) == ("", [1, 1, 1])


def test_shapes_that_are_missing_are_warned_of_and_the_others_keep_their_numbers(
    nao: nk.NaoModel, tmp_path: Path
) -> None:
    robot = with_shapes(tmp_path, "stl")
    with pytest.warns(MissingShapeWarning):
        visual = robot.geometry("visual")
    assert [shape.name for shape in visual.geometryObjects] == ["trunk_0", "trunk_1", "trunk_2", "arm_1"]
    q = robot.configuration({"shoulder": 0.7})
    T_arm_sphere = nk.screws.pose(np.eye(3), [0.1, 0.0, 0.0])
    assert np.abs(_placements(robot, visual, q)["arm_1"] - robot.fk(q, "arm") @ T_arm_sphere).max() < 1e-12
    assert [type(shape.geometry).__name__ for shape in robot.geometry("collision").geometryObjects] == ["Cylinder"]


def test_collisions_are_found_with_it() -> None:
    nao = nk.load_nao()
    collision = nao.geometry("collision")
    hand, head = (
        next(i for i, s in enumerate(collision.geometryObjects) if s.name.startswith(p)) for p in ("LForeArm", "Head")
    )
    collision.addCollisionPair(pin.CollisionPair(hand, head))
    data, shapes = nao.model.createData(), collision.createData()
    q = nao.posture("StandInit")
    pin.computeDistances(nao.model, data, collision, shapes, q)
    centres = [shapes.oMg[index].translation for index in (hand, head)]
    assert 0.0 < shapes.distanceResults[0].min_distance < np.linalg.norm(centres[0] - centres[1])


def test_another_kind_is_refused_by_name(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match=r"kind of geometry.*visual"):
        nao.geometry("visuals")
