"""Legs of a robot that moves like a person: feet in place or in steps, lean, balance, and room for the arms."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from people import walker

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.imitation import Imitation, Skeleton, imitate
from nao_kin.imitation.arms import make_room
from nao_kin.imitation.limbs import LimbMap
from nao_kin.imitation.stance import _walked, _weight, in_place, slowly, stood

JOINTS = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll")


@pytest.fixture(scope="module")
def walked(nao: nk.NaoModel) -> Imitation:
    return imitate(nao, walker(), legs="follow")


def leaning(pitch: Floats, roll: Floats) -> Skeleton:
    """A person whose trunk leans, and whose arms hang from it."""
    R = nk.rotations.rot_y(pitch) @ nk.rotations.rot_x(roll)
    places = {
        "shoulder": (0.0, 0.19, 0.5),
        "elbow": (0.0, 0.3, 0.25),
        "wrist": (0.1, 0.3, 0.03),
        "hip": (0.0, 0.1, 0.0),
    }
    points = {
        f"{name}_{part}": R @ (x, side * y, z)
        for name, side in (("left", 1.0), ("right", -1.0))
        for part, (x, y, z) in places.items()
    }
    return Skeleton(np.arange(len(pitch)) / 20.0, points)


def test_a_trunk_leans_as_the_person_s_above_feet_in_place(nao: nk.NaoModel) -> None:
    t = np.arange(60) / 20.0
    pitch, roll = 0.4 * np.sin(2.0 * t) ** 2, 0.1 * np.sin(3.0 * t)
    made = imitate(nao, leaning(pitch, roll), cutoff=0.0)
    assert made.ok, made.describe()
    assert (made.lean == 1.0).all()
    # Pinocchio's feet: where they are in the first frame, as seen from each other, and flat.
    feet = nao.fk(made.q, ["LLeg", "RLeg"])
    between = np.linalg.inv(feet[:, 0]) @ feet[:, 1]
    assert np.abs(between - between[0]).max() < 1e-6
    # The vertical in the torso is that of the person; the heading may differ, for one motor turns both hips.
    up = feet[:, 0, :3, 2]
    wanted = (nk.rotations.rot_y(pitch) @ nk.rotations.rot_x(roll))[:, 2]
    assert np.abs(up - wanted).max() < 0.03
    # The centre of mass stays above the middle of the feet.
    com = np.linalg.inv(feet[:, 0]) @ np.append(nao.com(made.q), np.ones((60, 1)), axis=1)[..., None]
    assert np.ptp(com[:, :2, 0], axis=0).max() < 0.003


def test_a_lean_that_the_feet_do_not_allow_becomes_less(nao: nk.NaoModel) -> None:
    t = np.arange(30) / 20.0
    made = imitate(nao, leaning(2.0 * np.sin(2.0 * t) ** 2, 0.0 * t), cutoff=0.0)
    assert made.lean.min() < 0.9
    assert "with less lean" in made.describe()
    assert made.ok, made.describe()


def test_a_robot_that_follows_steps_stands_on_one_foot_and_does_not_tip(nao: nk.NaoModel, walked: Imitation) -> None:
    assert walked.ok, walked.describe()
    assert "3 steps" in walked.notes
    on = [row.soles for row in walked.report.balance]
    assert {("RLeg",), ("LLeg",)} < set(on)
    assert len(walked.played) == len(walked.times)
    names = [nao.joint_names.index(name) for name in walked.motion.joint_names]
    assert np.abs(walked.motion.sample(walked.played) - walked.q[:, names]).max() < 0.1  # coupled limits move ankles
    assert np.isfinite(walked.figure(walked.played[::10])).all()
    alone = [row for row in walked.report.balance if len(row.soles) == 1]
    # At rest the centre of mass is 25 mm inside the inner edge, where the plan has it.
    assert min(row.com_margin for row in alone) > 0.02


def test_weight_stays_above_the_foot_that_stands_at_the_end_of_a_take() -> None:
    carries = np.ones((60, 2), dtype=bool)
    carries[30:58, 0] = False
    left = _weight(np.arange(60) / 20.0, carries)[:, 0]
    assert left[0] == 0.5
    assert not left[30:].any()


def test_a_foot_on_the_floor_does_not_slip(nao: nk.NaoModel, walked: Imitation) -> None:
    poses = nao.fk(walked.q, ["LLeg", "RLeg"])
    lifted = np.abs((np.linalg.inv(poses[:, 0]) @ poses[:, 1])[:, 2, 3]) > 1e-4
    assert 0.05 < lifted.mean() < 0.7
    between = (np.linalg.inv(poses[:, 0]) @ poses[:, 1])[:, :2, 3]
    moved = np.linalg.norm(np.diff(between, axis=0), axis=1)
    both = ~lifted[1:] & ~lifted[:-1]
    assert moved[both].max() < 1e-4
    assert moved[~both].max() > 1e-3


def test_feet_that_carry_stay_where_they_are_while_the_hips_move() -> None:
    """A walk in a quarter of a circle, of which only the feet as seen from the hips are known."""
    t = np.linspace(0.0, 1.0, 41)
    R = nk.rotations.rot_z(0.5 * np.pi * t)
    hips = np.stack([np.sin(0.5 * np.pi * t), 1.0 - np.cos(0.5 * np.pi * t)], axis=1)
    carries = np.stack([t < 0.6, t > 0.5], axis=1)  # the right foot lands before the left one leaves
    feet = np.stack([np.tile([0.3, 0.1], (41, 1)), np.tile([0.5, 0.4], (41, 1))], axis=1)
    feet[~carries] += np.stack([t, -t], axis=1)[:, None].repeat(2, axis=1)[~carries]
    beside = (feet - hips[:, None]) @ R[:, :2, :2]
    np.testing.assert_allclose(_walked(R, beside, carries), feet, atol=1e-12)


def test_steps_of_a_person_elsewhere_and_of_another_size_are_the_same(nao: nk.NaoModel, walked: Imitation) -> None:
    R, seen = nk.rotations.rot_z(2.0), walker()
    points = {name: 1.2 * p @ R.T + (5.0, -3.0, 0.4) for name, p in seen.points.items()}
    again = imitate(nao, Skeleton(seen.times, points), legs="follow")
    assert np.abs(again.q - walked.q).max() < 1e-4
    np.testing.assert_allclose(again.motion.end, walked.motion.end, rtol=1e-3)


def test_a_walk_stands_in_mujoco(nao: nk.NaoModel, walked: Imitation) -> None:
    """The library's own export, with its servos as they are, follows the plan."""
    pytest.importorskip("mujoco")
    from simulated_robot import STEP, Scene

    times = np.arange(walked.motion.start, walked.motion.end, STEP)
    plan = walked.motion.configurations(nao, times=times, missing="StandInit").q
    scene = Scene(nao).go(plan[0], 1.0).play(plan)
    up = scene.truth().T[-len(plan) :: 10, 2, :3]
    wanted = nao.set_down(nao.clamp(plan[::10])).T_world_base[:, 2, :3]
    assert np.degrees(np.arccos(np.clip((up * wanted).sum(axis=1), -1.0, 1.0))).max() < 3.0


def test_legs_of_frames_without_a_balanced_pose_are_interpolated(nao: nk.NaoModel) -> None:
    start, times = nao.posture("StandInit"), np.arange(9) / 20.0
    stance = in_place(nao, start, np.tile(np.eye(3), (9, 1, 1)))
    com = stance.com + 0.5 * np.isin(np.arange(9), (4, 5))[:, None]  # half a metre away
    arms = np.arange(12)
    q, _, misses = stood(nao, times, np.tile(start, (9, 1)), replace(stance, com=com), arms, np.ones(9), np.arange(9))
    assert misses.tolist() == [4, 5]
    np.testing.assert_allclose(q[4], (2.0 * q[3] + q[6]) / 3.0, atol=1e-12)


def test_a_note_says_where_no_pose_is_balanced(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["nao_kin.imitation.imitate"]
    monkeypatch.setattr(module, "stood", lambda robot, times, q, *_: (q, np.ones(len(q)), np.array([3, 4])))
    made = imitate(nao, leaning(np.zeros(10), np.zeros(10)), cutoff=0.0, collisions=False)
    first = "the first at 0.15 s of the person"
    assert f"no balanced pose was found for 2 of 10 frames, {first}: interpolated" in made.notes
    assert made.report.ok
    assert not made.ok
    assert made.missed.tolist() == [3, 4]


def test_a_clip_is_what_pinocchio_finds_and_its_feet_do_not_slip(nao: nk.NaoModel, walked: Imitation) -> None:
    clip = walked.clip(nao)
    frames, dt = len(clip["joint_pos"]), 1.0 / clip["fps"][0]
    assert abs(frames - 1 - (walked.times[-1] - walked.times[0]) / dt) < 1.0
    model = pin.buildModelFromUrdf(str(nao.urdf_path), pin.JointModelFreeFlyer())
    data = model.createData()
    places = [model.joints[model.getJointId(name)] for name in clip["dof_names"]]
    soles = np.empty((frames, 2, 3))
    for k in range(1, frames - 1):
        q, v = pin.neutral(model), np.zeros(model.nv)
        q[:3], q[3:7] = clip["root_pos"][k], clip["root_rot"][k]
        for place, value, speed in zip(places, clip["dof_pos"][k], clip["joint_vel"][k], strict=True):
            q[place.idx_q], v[place.idx_v] = value, speed
        R = pin.Quaternion(q[3:7]).matrix()
        v[:3], v[3:6] = (R.T @ clip[f"body_{part}_vel_w"][k, 0] for part in ("lin", "ang"))
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for row, name in enumerate(clip["body_names"]):
            frame = model.getFrameId(str(name))
            T = data.oMf[frame]
            assert np.abs(T.translation - clip["body_pos_w"][k, row]).max() < 1e-9
            turned = nk.rotations.matrix_from_quat(clip["body_quat_w"][k, row])
            assert np.abs(T.rotation - turned).max() < 1e-9
            V = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            assert np.abs(V.linear - clip["body_lin_vel_w"][k, row]).max() < 0.03
            assert np.abs(V.angular - clip["body_ang_vel_w"][k, row]).max() < 0.5
        soles[k] = [data.oMf[model.getFrameId(name)].translation for name in ("l_sole", "r_sole")]
    on = clip["contacts"][1:-1]
    soles = soles[1:-1]
    stay = on[1:] & on[:-1]
    # Feet on the floor are on it, and slip by less than a millimetre from frame to frame.
    assert np.abs(soles[..., 2][on]).max() < 1e-3
    assert np.linalg.norm(np.diff(soles, axis=0), axis=-1)[stay].max() < 1e-3
    assert (np.ptp(soles[:, :, 0], axis=0) > (0.02, 0.005)).all()  # and both feet step
    np.testing.assert_allclose(clip["local_body_pos"][:, 0], 0.0, atol=1e-12)


def test_a_clip_is_in_the_order_of_mujoco(nao: nk.NaoModel, walked: Imitation, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(nk.export.mjcf(nao, tmp_path / "nao", meshes="none").path))
    clip = walked.clip(nao)
    assert clip["body_names"].tolist() == [model.body(k).name for k in range(1, model.nbody)]
    assert clip["dof_names"].tolist() == [model.joint(k).name for k in range(1, model.njnt)]


@pytest.mark.full
@pytest.mark.parametrize("options", [{"noise": 0.02}, {"squat": 0.3}, {"step": 0.0, "lift": 0.25}, {"period": 1.4}])
def test_other_ways_to_step_do_not_tip(nao: nk.NaoModel, options: dict[str, float]) -> None:
    made = imitate(nao, walker(6.0, **options), legs="follow")
    assert made.ok, made.describe()


def test_slowly_is_the_largest_function_below_that_changes_slowly() -> None:
    times = np.array([0.0, 0.1, 0.3, 0.4])
    np.testing.assert_allclose(slowly(times, np.array([1.0, 0.2, 1.0, 1.0]), 2.0), [0.4, 0.2, 0.6, 0.8])


def clapper() -> Skeleton:
    """A person whose hands meet before the chest, and part."""
    t = np.arange(40) / 20.0
    apart = 0.02 + 0.5 * np.sin(1.5 * t) ** 2
    points = {}
    for name, side in (("left", 1.0), ("right", -1.0)):
        hand = np.stack([0.35 + 0.0 * t, side * apart, 0.35 + 0.0 * t], axis=1)
        shoulder = np.tile((0.0, 0.19 * side, 0.5), (40, 1))
        along = hand - shoulder
        distance = np.linalg.norm(along, axis=1)[:, None]
        cosine = (0.28**2 + distance**2 - 0.34**2) / (2.0 * 0.28 * distance)
        out = np.tile((0.0, 0.4 * side, -1.0), (40, 1))
        out -= (out * along).sum(axis=1, keepdims=True) * along / distance**2
        out /= np.linalg.norm(out, axis=1)[:, None]
        elbow = shoulder + 0.28 * (cosine * along / distance + np.sqrt(1.0 - cosine**2) * out)
        points |= {f"{name}_shoulder": shoulder, f"{name}_elbow": elbow, f"{name}_hand": hand}
        points |= {f"{name}_wrist": elbow + (hand - elbow) * 0.25 / 0.34, f"{name}_hip": shoulder * (1.0, 0.5, 0.0)}
    return Skeleton(t, points)


PLACES = {"upper_arm": 0.001, "forearm": 0.001, "place": 10.0, "speed": 0.0}


def test_hands_are_at_the_person_s_places_times_the_ratio_of_the_spans(nao: nk.NaoModel) -> None:
    seen = clapper()
    hands, apart = [], []
    for weights in ({}, PLACES):
        made = imitate(nao, seen, weights=weights, cutoff=0.0, legs="ignore", collisions=False)
        hands.append(nao.fk(made.q, ["LArm", "RArm"])[..., :3, 3])
        apart.append(np.linalg.norm(hands[-1][0, 0] - hands[-1][0, 1]))
    # In the first frame the person's hands touch.
    assert apart[1] < min(0.05, apart[0] - 0.02)
    shoulders = nao.fk(nao.neutral(), ["LShoulder", "RShoulder"])[:, :3, 3]
    # From the middle of the body to the fingertips: the person 0.19 + 0.28 + 0.34 m, a NAO as published.
    scale = (0.098 + 0.105 + 0.05595 + 0.05775) / (0.19 + 0.28 + 0.34)
    places = np.stack([seen.points["left_hand"], seen.points["right_hand"]], axis=1) - (0.0, 0.0, 0.5)
    # The elbow's offset of 15 mm is not a person's.
    assert np.linalg.norm(hands[1] - shoulders.mean(axis=0) - scale * places, axis=-1).max() < 0.016


def test_arms_make_room_for_the_body_and_each_other(nao: nk.NaoModel) -> None:
    t = np.arange(40) / 20.0
    tight = leaning(0.0 * t, 0.0 * t)
    points = dict(tight.points)
    for name in ("left", "right"):
        points[f"{name}_elbow"] = points[f"{name}_shoulder"] - (0.0, 0.0, 0.28)
        points[f"{name}_wrist"] = points[f"{name}_elbow"] + (0.0, -0.2 if name == "left" else 0.2, -0.1)
    made, free = (imitate(nao, Skeleton(t, points), cutoff=0.0, collisions=rule) for rule in (True, False))
    assert not nao.clearance(free.q).is_free.all()
    assert nao.clearance(made.q).distance.min() > 0.0
    assert made.ok, made.describe()
    assert (made.clamped["left_upper_arm"] & 8).all()
    assert "to make room" in made.describe()
    # A touch that is accepted moves the arms less.
    touch = imitate(nao, Skeleton(t, points), cutoff=0.0, collisions=nk.robot.CollisionRule(0.01))
    assert np.nanmean(touch.errors["left_upper_arm"]) < np.nanmean(made.errors["left_upper_arm"])


def test_arms_that_cross_between_frames_make_room(nao: nk.NaoModel) -> None:
    """Two frames without overlap, and hands that go through each other between them."""
    values = {
        "L": ((0.0, 0.6), (-0.3, 0.0), (-0.5, -0.2), (-1.0, -1.1)),
        "R": ((0.5, 0.3), (0.1, 0.2), (0.4, 0.9), (0.9, 0.7)),
    }
    q = np.tile(nao.posture("StandInit"), (2, 1))
    for side, pairs in values.items():
        for joint, pair in zip(JOINTS, pairs, strict=True):
            q[:, nao.joint_names.index(side + joint)] = pair
    share = np.linspace(0.0, 1.0, 100)[:, None]
    assert nao.clearance(q).is_free.all()
    assert not nao.clearance(q[0] + share * (q[1] - q[0])).is_free.all()
    made, moved = make_room(
        nao, LimbMap(nao), np.array([0.0, 0.5]), q, nk.robot.CollisionRule(), np.ones(2, dtype=bool)
    )
    assert moved[:, :2].any()
    assert nao.clearance(made[0] + share * (made[1] - made[0])).is_free.all()


def test_a_head_that_touches_a_shoulder_makes_room(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (1, 1))
    q[0, :2] = 0.96, -0.47
    assert not nao.clearance(q).is_free.all()
    made, moved = make_room(nao, LimbMap(nao), np.zeros(1), q, nk.robot.CollisionRule(), np.ones(1, dtype=bool))
    assert moved[0, 2]
    assert nao.clearance(made).is_free.all()


def test_hands_open_as_the_fingers_do(nao: nk.NaoModel) -> None:
    seen = leaning(np.zeros(5), np.zeros(5))
    wrist = seen.points["left_wrist"]
    bend = np.linspace(0.0, np.pi, 5)
    knuckles = wrist + np.array([0.08, 0.0, 0.0])
    tip = knuckles + 0.09 * np.stack([np.cos(bend), 0.0 * bend, -np.sin(bend)], axis=1)
    made = imitate(nao, Skeleton(seen.times, {**seen.points, "left_hand": knuckles, "left_finger": tip}), cutoff=0.0)
    np.testing.assert_allclose(made.q[:, nao.joint_names.index("LHand")], [1.0, 0.854, 0.5, 0.146, 0.0], atol=1e-3)
    assert "LHand" in made.motion.joint_names
    assert "RHand" not in made.motion.joint_names
