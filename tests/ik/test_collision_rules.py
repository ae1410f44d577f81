"""Overlaps that inverse kinematics accepts: of links that it does not move, of the beginning, and by a rule."""

from __future__ import annotations

import numpy as np
import pytest
from loops import for_all

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik import Reason
from nao_kin.robot import CollisionRule

# Hands that overlap by 7 mm in front of the chest.
HANDS = {"LShoulderPitch": 0.6, "LElbowYaw": -0.8, "LElbowRoll": -0.9, "LHand": 0.4}
HANDS |= {"RShoulderPitch": 0.6, "RElbowYaw": 0.8, "RElbowRoll": 0.9, "RHand": 0.4}


@for_all("posture", ["Crouch", "Sit", "SitRelax", "LyingBack"])
def test_an_arm_moves_whatever_the_feet_overlap(nao: nk.NaoModel, posture: str) -> None:
    q = nao.posture(posture)
    assert not nao.clearance(q).is_free or posture in ("SitRelax", "LyingBack")
    found = nk.ik.arm(nao, "L", nao.fk(q, "LArm"), near=q, collisions=True)
    assert found.success
    assert found.q == pytest.approx(q, abs=1e-9)
    path = nao.position(q, "LArm") + np.linspace([0.0, 0.0, 0.0], [0.004, 0.0, 0.0], 3)
    assert nk.ik.follow(nao, {"LArm": path}, near=q, collisions=True).limbs[0].reached.all()


def test_only_pairs_with_a_joint_between_them_are_checked(nao: nk.NaoModel) -> None:
    shapes = nao.link_shapes
    columns = [nao.joint_names.index(name) for name in nao.chains["LArm"]]
    moved = shapes.moved(columns)
    rng = np.random.default_rng(3)
    q = nao.random(rng)
    other = q.copy()
    other[columns] = nao.random(rng)[columns]
    before, after = (nao.fk(each, list(shapes.links)) for each in (q, other))
    names = list(shapes.links)
    for pair, is_moved in zip(shapes.pairs, moved, strict=True):
        a, b = (names.index(name) for name in pair)
        relative = [np.linalg.inv(T[a]) @ T[b] for T in (before, after)]
        assert (np.abs(relative[0] - relative[1]).max() > 1e-9) == is_moved, pair


def _hands(nao: nk.NaoModel) -> np.ndarray:
    return nao.configuration(HANDS)


def test_links_that_overlap_at_the_beginning_may_not_overlap_more(nao: nk.NaoModel) -> None:
    q = _hands(nao)
    depth = -float(nao.clearance(q).distance)
    assert depth > 0.005
    T = nao.fk(q, "LArm")
    assert nk.ik.arm(nao, "L", T, near=q, collisions=True).success
    roll = np.where(np.array(nao.joint_names) == "LShoulderRoll", 0.02, 0.0)
    away, near = (nk.ik.arm(nao, "L", nao.fk(q + turn, "LArm"), near=q, collisions=True) for turn in (roll, -roll))
    assert away.success
    assert -nao.clearance(away.q).distance < depth
    assert near.reason == Reason.COLLISION
    assert -nao.clearance(near.q).distance > depth
    # From another beginning this overlap is new.
    begin = np.where(_moves_left(nao), nao.posture("StandInit"), q)
    assert nao.clearance(begin).is_free
    assert nk.ik.arm(nao, "L", T, near=begin, collisions=True).reason == Reason.COLLISION
    # In a batch each row has its own beginning.
    both = nk.ik.arm(nao, "L", np.stack([T, T]), near=np.stack([q, begin]), collisions=True)
    assert both.success.tolist() == [True, False]


def _moves_left(nao: nk.NaoModel) -> np.ndarray:
    return np.isin(nao.joint_names, nao.chains["LArm"]) & (np.array(nao.joint_names) != "LHand")


def test_a_rule_accepts_an_overlap_or_a_pair(nao: nk.NaoModel) -> None:
    q = _hands(nao)
    begin = np.where(_moves_left(nao), nao.posture("StandInit"), q)
    T, found = nao.fk(q, "LArm"), nao.clearance(q)
    depth = -float(found.distance)
    pairs = [contact.links for contact in nao.collisions(q)]
    answers = {
        "more": CollisionRule(tolerance=depth + 1e-4),
        "less": CollisionRule(tolerance=depth - 1e-4),
        "pairs": CollisionRule(allowed=pairs),
        "reversed": CollisionRule(allowed=[pair[::-1] for pair in pairs]),
        "another": CollisionRule(allowed=[("l_ankle", "r_ankle")]),
    }
    success = {name: nk.ik.arm(nao, "L", T, near=begin, collisions=rule).success for name, rule in answers.items()}
    assert success == {"more": True, "less": False, "pairs": True, "reversed": True, "another": False}
    for name, rule in answers.items():
        assert nao.clearance(q, tolerance=rule.tolerance, allowed=rule.allowed).is_free == success[name], name
        assert (nao.collisions(q, tolerance=rule.tolerance, allowed=rule.allowed) == ()) == success[name], name
        still = nk.Motion([0.0, 1.0], nao.joint_names, np.stack([q, q]))
        rows = nk.motion.check(nao, still, rate=2, collisions=rule).violations
        assert (not [row for row in rows if row.kind == "collision"]) == success[name], name


def test_random_configurations_obey_the_rule(nao: nk.NaoModel) -> None:
    rule = CollisionRule(tolerance=0.01, allowed=[("l_ankle", "r_ankle")])
    q = nao.random(0, 300, collision_free=rule)
    assert nao.clearance(q, tolerance=rule.tolerance, allowed=rule.allowed).is_free.all()
    assert not nao.clearance(q).is_free.all()
    assert np.array_equal(nao.random(0, 20, collision_free=CollisionRule()), nao.random(0, 20, collision_free=True))


@pytest.mark.full
def test_the_whole_body_moves_from_rest_postures_that_overlap(nao: nk.NaoModel) -> None:
    for posture in ("Crouch", "Sit", "LyingBack"):
        q = nao.posture(posture)
        found = nk.ik.whole_body(nao, {"LArm": nao.position(q, "LArm")}, near=q, collisions=True)
        assert found.success, posture


def test_wrong_rules_are_refused(nao: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    with pytest.raises(BadArgument, match="tolerance"):
        CollisionRule(tolerance=-0.1)
    for wrong in ("ab", ["l_ankle", "r_ankle"], [("l_ankle",)]):
        with pytest.raises(BadArgument, match="allowed"):
            nao.clearance(q, allowed=wrong)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="l_ankel"):
        nao.collisions(q, allowed=[("l_ankel", "r_ankle")])
    for ask in (nk.ik.arm, nk.ik.leg):
        with pytest.raises(BadArgument, match="collisions"):
            ask(nao, "L", nao.fk(q, "LArm"), near=q, collisions=1)  # type: ignore[arg-type]


# --- The meshes.


def test_with_the_meshes_links_touch_exactly_if_their_meshes_do(nao: nk.NaoModel) -> None:
    coal = pytest.importorskip("coal")
    parents = {joint.child: joint.parent for joint in nao.tree.joints}
    loader, shapes = coal.MeshLoader(), []
    for visual in nao.tree.visuals:
        owner = visual.link
        while owner not in nao.link_shapes.links:
            owner = parents[owner]
        mesh = loader.load(str(nao.urdf_path.parent / visual.geometry.filename), np.array(visual.geometry.scale))
        shapes.append((owner, visual.link, mesh, visual.origin.matrix))
    q = nao.random(5, 90)
    q = q[~np.asarray(nao.clearance(q, exact=False).is_free)]
    false_alarms = 0
    for row in q:
        poses = dict(zip(nao.link_names, nao.fk(row), strict=True))
        touching = set()
        for contact in nao.collisions(row, exact=False):
            one, other = (
                [(mesh, poses[link] @ T) for owner, link, mesh, T in shapes if owner == name] for name in contact.links
            )
            for mesh, T in one:
                for second, T_second in other:
                    places = (coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (T, T_second))
                    first, last = places
                    if coal.collide(mesh, first, second, last, coal.CollisionRequest(), coal.CollisionResult()):
                        touching.add(contact.links)
        found = nao.clearance(row, exact=True)
        assert {contact.links for contact in nao.collisions(row, exact=True)} == touching
        assert found.is_free == (not touching)
        assert found.distance >= nao.clearance(row, exact=False).distance - 1e-9
        false_alarms += not touching
    assert 0 < false_alarms < len(q)


def test_where_only_hulls_overlap_the_meshes_let_an_arm_be() -> None:
    nao = nk.load_nao("v3.2")
    q = nao.posture("LyingBack")
    assert not nao.clearance(q, exact=False).is_free
    assert nao.clearance(q).is_free
    rule, by_hulls = CollisionRule(), CollisionRule(exact=False)
    assert nk.motion.check(nao, nk.Motion([0.0, 1.0], nao.joint_names, [q, q]), rate=2, collisions=rule).ok
    near = np.where(_moves_left(nao), 0.0, q)
    T = nao.fk(q, "LArm")
    assert nk.ik.arm(nao, "L", T, near=near, collisions=by_hulls).reason == Reason.COLLISION
    assert nk.ik.arm(nao, "L", T, near=near, collisions=rule).success
    with pytest.raises(BadArgument, match="exact"):
        nao.clearance(q, exact=1)  # type: ignore[arg-type]


def test_meshes_that_touch_count_beside_hulls_that_overlap_more(nao: nk.NaoModel) -> None:
    legs = {"LHipYawPitch": -0.18, "LHipRoll": -0.07, "LHipPitch": -0.24, "LKneePitch": 0.89}
    legs |= {"RHipRoll": 0.32, "RHipPitch": 0.34, "RKneePitch": 1.42}
    q = nao.posture("StandInit", legs), nao.posture("StandInit", legs | {"LShoulderRoll": -0.3, "LElbowRoll": -1.2})
    by_hulls, found = nao.clearance(q, exact=False), nao.clearance(q, exact=True)
    assert by_hulls.pair.tolist() == [("LTibia", "RTibia")] * 2  # type: ignore[union-attr]
    np.testing.assert_allclose(by_hulls.distance, -0.0048, atol=5e-4)
    assert found.pair.tolist() == [("LTibia", "RTibia"), ("LForeArm", "torso")]  # type: ignore[union-attr]
    np.testing.assert_allclose(found.distance, [0.0025, -0.0026], atol=2e-4)


def test_by_default_the_meshes_decide_where_hulls_overlap_by_less_than_3_mm(nao: nk.NaoModel) -> None:
    q = nao.random(6, 500)
    by_hulls, by_meshes, found = (nao.clearance(q, exact=exact) for exact in (False, True, None))
    shallow = (by_hulls.distance < 0.0) & (by_hulls.distance > -0.003)
    assert 5 < (shallow & by_meshes.is_free).sum() < shallow.sum() - 5
    np.testing.assert_array_equal(found.distance, np.where(shallow, by_meshes.distance, by_hulls.distance))
    np.testing.assert_array_equal(found.is_free[shallow], by_meshes.is_free[shallow])
    for k in np.flatnonzero(shallow)[:40]:
        assert nao.clearance(q[k]).distance == pytest.approx(float(found.distance[k]), abs=1e-8)
        contacts = nao.collisions(q[k], margin=float(found.distance[k]) + 1e-6)
        assert contacts[0].links == found.pair[k]  # type: ignore[index]
    free = nao.random(0, 200, collision_free=True)
    assert nao.clearance(free).is_free.all()
    assert not nao.clearance(free, exact=False).is_free.all()
