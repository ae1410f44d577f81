"""The typed model without the links between the axes of merged joints."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import UnknownName
from nao_kin.joints import MultiDofModel
from nao_kin.joints.grouping import RULES

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BETWEEN = {"Neck", *(f"{side}{part}" for side in "LR" for part in ("Shoulder", "Elbow", "Pelvis", "Hip"))}


def test_the_nao_is_exactly_its_fifteen_joints(each_nao) -> None:
    typed = MultiDofModel(each_nao, intermediate="drop")
    assert (typed.nq, typed.nv) == (28, 26)
    assert typed.nv - len(typed.groups.mimics) == 25
    assert typed.carriers == ()
    assert set(typed.columns) == {joint.name for joint in typed.pairs}
    assert len(typed.pairs) == 15
    assert sorted(set(each_nao.link_names) - set(typed.link_names)) == sorted(
        {*BETWEEN, *(name for name in each_nao.link_names if "AnklePitch" in name)}
    )


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", ["v6", "v3.2", "romeo"])
def test_all_frames_left_move_as_the_robots(name, rule, base) -> None:
    robot = nk.load_robot(name, base=base) if name == "romeo" else nk.load_nao(name, base=base)
    typed = MultiDofModel(robot, rule=rule, intermediate="drop")
    q = robot.random(1, 20)
    q_typed = typed.from_q(q)
    names = typed.frame_names
    assert 50 < len(names) < len(robot.frame_names)
    assert np.allclose(typed.fk(q_typed, names), robot.fk(q, names), rtol=0, atol=1e-13)
    assert np.allclose(typed.fk(q_typed), robot.fk(q, typed.link_names), rtol=0, atol=1e-13)
    for frame in names[:: len(names) // 10]:
        J_typed = typed.jacobian(q_typed, frame) @ typed.velocity_matrix(q)
        assert np.allclose(J_typed, robot.jacobian(q, frame), rtol=0, atol=1e-12)


def test_masses_are_lumped_as_the_notes_say(each_nao) -> None:
    typed = MultiDofModel(each_nao, intermediate="drop")
    assert sum(inertia.mass for inertia in typed.model.inertias) == pytest.approx(each_nao.mass, abs=1e-14)
    zero = each_nao.neutral()
    assert np.allclose(typed.com(typed.from_q(zero)), each_nao.com(zero), rtol=0, atol=1e-15)
    q = each_nao.random(1, 200)
    off = np.linalg.norm(typed.com(typed.from_q(q)) - each_nao.com(q), axis=-1)
    # The page about joints says 1.4 mm.
    assert 1e-4 < off.max() < 1.4e-3
    assert len(typed.notes) == 11
    neck = next(note for note in typed.notes if "HeadYaw" in note)
    assert neck.startswith(f"{each_nao.model.inertias[each_nao.model.getJointId('HeadYaw')].mass:.6g} kg")
    assert "centre of mass" in neck
    assert MultiDofModel(each_nao).notes == ()


def test_a_link_without_mass_between_the_axes_is_not_noted(tmp_path) -> None:
    tree = made_up(tmp_path, J("a", axis=Z), J("b", axis=X), J("c", axis=Y)).tree
    light = replace(tree.inertials["b_l"], mass=1e-9)
    robot = nk.RobotModel(replace(tree, inertials={"b_l": light, "c_l": tree.inertials["c_l"]}))
    (note,) = MultiDofModel(robot, intermediate="drop").notes
    assert note.startswith("1e-09 kg carried by b")


def test_the_way_back_goes_by_limits_and_reference(nao) -> None:
    typed = MultiDofModel(nao, intermediate="drop")
    q = nao.random(1, 500)
    assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-13)
    wide = np.random.default_rng(1).uniform(-9, 9, (200, 25))
    assert np.allclose(typed.to_q(typed.from_q(wide), near=wide), wide, rtol=0, atol=1e-10)


def test_a_dropped_frame_is_unknown_and_pickling_keeps_the_choice(nao) -> None:
    typed = pickle.loads(pickle.dumps(MultiDofModel(nao, intermediate="drop")))
    assert typed.nq == 28
    assert "dropped" in repr(typed)
    with pytest.raises(UnknownName, match="Neck"):
        typed.fk(typed.neutral(), "Neck")
    with pytest.raises(UnknownName, match="intermediate"):
        MultiDofModel(nao, intermediate="fuse")


def test_what_follows_beside_a_dropped_link_goes_with_it_and_what_follows_elsewhere_stays(tmp_path) -> None:
    joints = [J("a", Z), J("b", X), J("c", Y), J("finger", Y, parent="a", follows=("b", 0.5, 0.0))]
    robot = made_up(tmp_path, *joints, J("f", X, (0.0, 0.1, 0.0), parent="base", follows=("a", 2.0, 0.1)))
    typed = MultiDofModel(robot, intermediate="drop")
    assert set(typed.link_names) == {"base", "c_l", "f_l"}
    q = robot.random(1, 50)
    q_typed = typed.from_q(q)
    assert np.allclose(typed.fk(q_typed), robot.fk(q, typed.link_names), rtol=0, atol=1e-14)
    q_typed[0, typed.columns["f"]] += 0.1
    assert [row.mimic for row in typed.violations(q_typed)] == ["f"]
