"""Solutions in collision are left out, and the report says so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.ik import IKResult, Reason, follow_branches, follow_limbs

CROSSED = {"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04, "LHand": 1.0}
ARMS, LEGS = ("Shoulder", "Elbow", "Wrist"), ("Hip", "Knee", "Ankle")


def _with_random(nao: nk.NaoModel, words: tuple[str, ...], rng: np.random.Generator | int, n: int) -> np.ndarray:
    """Standing configurations with random values of the joints whose names have one of these words."""
    q = np.tile(nao.posture("StandInit"), (n, 1))
    columns = [k for k, name in enumerate(nao.joint_names) if any(word in name for word in words)]
    q[:, columns] = nao.random(rng, n)[:, columns]
    return q


def _solved(nao: nk.NaoModel, solver: str, q: np.ndarray, near: np.ndarray, **more: Any) -> IKResult:
    if solver == "leg":  # the limits leave some targets with fewer solutions than others
        return nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=near, **more)
    if solver == "arm":
        return nk.ik.arm(nao, "L", nao.fk(q, "LArm"), near=near, limits="ignore", **more)
    if solver == "legs":
        return nk.ik.legs(nao, nao.fk(q, "LLeg"), nao.fk(q, "RLeg"), near=near, limits="ignore", **more)
    if solver == "head":
        return nk.ik.head(nao, nao.rotation(q, "Head"), near=near, **more)
    if solver == "look_at":
        T = nao.fk(q, "CameraTop")
        return nk.ik.look_at(nao, T[..., :3, 3] + 0.5 * T[..., :3, 0], near=near, limits="ignore", **more)
    if solver == "analytic":
        pytest.importorskip("eaik")
        return nk.ik.analytic(nao, "LLeg", nao.fk(q, "LLeg"), near=near, limits="ignore", **more)
    return nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm"), near=near, **more)


def _gap(nao: nk.NaoModel, row: np.ndarray, near: np.ndarray, columns: tuple[int, ...]) -> float:
    """Return the least distance of pairs that the columns move and that overlap more than in `near`, or infinity."""
    moving, begin = near.copy(), {contact.links: contact.distance for contact in nao.collisions(near)}
    moving[list(columns)] += 0.1
    names = list(nao.link_shapes.links)
    at, then = nao.fk(near, names), nao.fk(moving, names)
    gaps = [np.inf]
    for contact in nao.collisions(row):
        a, b = (names.index(link) for link in contact.links)
        moves = np.abs(np.linalg.inv(at[a]) @ at[b] - np.linalg.inv(then[a]) @ then[b]).max() > 1e-9
        if moves and (contact.links not in begin or contact.distance < begin[contact.links] - 1e-5):
            gaps.append(contact.distance)
    return min(gaps)


@pytest.mark.parametrize("solver", ["leg", "arm", "legs", "head", "look_at", "numeric", "analytic"])
def test_exactly_the_solutions_in_collision_are_left_out(solver: str) -> None:
    nao = nk.load_nao()
    q = nao.random(3, {"legs": 16, "numeric": 6, "analytic": 20}.get(solver, 16))
    columns = list(_solved(nao, solver, q, q).columns)
    near = q.copy()
    near[:, columns] = np.roll(q, 1, axis=0)[:, columns]
    every, free = _solved(nao, solver, q, near), _solved(nao, solver, q, near, collisions=True)
    for index in range(len(q)):
        solutions = every.solutions[index, : every.count[index]]
        least = [_gap(nao, row, near[index], every.columns) for row in solutions]
        kept = solutions[np.array(least) >= 0.0]
        np.testing.assert_array_equal(free.solutions[index, : free.count[index]], kept)
        assert np.isnan(free.solutions[index, free.count[index] :]).all()
        if len(kept):
            np.testing.assert_array_equal(free.q[index], kept[0])
            assert free.reasons[index] == Reason.REACHED
        elif len(solutions):
            assert free.reasons[index] == Reason.COLLISION
            assert _gap(nao, free.q[index], near[index], every.columns) == pytest.approx(max(least), abs=1e-9)
            assert free.obstacles.needed[index] == pytest.approx(-max(least), abs=1e-9)
            assert "every solution has links that overlap" in free.describe((index,))
        else:
            assert free.reasons[index] == every.reasons[index]
    assert (free.reasons == Reason.REACHED).any()
    assert (free.reasons == Reason.COLLISION).any()
    left = int(every.count.sum() - free.count.sum())
    assert free.notes[-1] == f"{left} of {every.count.sum()} solutions are left out: links overlap"


def test_one_target_says_which_links_overlap() -> None:
    nao = nk.load_nao()
    q = nao.configuration(CROSSED)
    near = nao.configuration({name: CROSSED[name] for name in ("RElbowRoll", "LHand")})
    result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"), near=near, collisions=True)
    assert result.reason is Reason.COLLISION
    assert not result.success
    assert result.message == "every solution has links that overlap: RBicep and l_wrist by 10.22 mm or more"
    np.testing.assert_allclose(result.q, q, atol=1e-9)


def test_a_result_without_collisions_is_unchanged() -> None:
    nao = nk.load_nao()
    q = nao.posture("StandInit")
    one, other = (nk.ik.arm(nao, "L", nao.fk(q, "LArm"), collisions=collisions) for collisions in (False, True))
    np.testing.assert_array_equal(one.q, other.q)
    assert one.notes == other.notes == ()
    far = nk.ik.arm(nao, "L", [1.0, 0.0, 0.0], collisions=True)
    assert far.reason is Reason.OUT_OF_REACH


# --- Whole-body poses.


def test_whole_body_poses_with_links_that_overlap_give_way_to_others() -> None:
    nao = nk.load_nao()
    start = nao.posture("StandInit")
    q = _with_random(nao, ARMS, 1, 150)
    targets = {name: nao.position(q, name) for name in ("LArm", "RArm")}
    feet = {side: nao.fk(start, f"{side}Leg") for side in "LR"}
    options: dict[str, Any] = {"feet": feet, "near": start, "restarts": 20}
    every, free = (nk.ik.whole_body(nao, targets, collisions=collisions, **options) for collisions in (False, True))
    gaps, least = nao.clearance(free.q), nao.clearance(every.q).distance
    solved = every.reasons == Reason.REACHED
    overlap = solved & (least < 0.0)
    np.testing.assert_array_equal(free.success, solved & gaps.is_free)
    np.testing.assert_array_equal(free.q[~overlap], every.q[~overlap])
    np.testing.assert_array_equal(free.starts[~overlap], every.starts[~overlap])
    assert np.count_nonzero(overlap & free.success) > np.count_nonzero(overlap & ~free.success) > 0
    for name, places in targets.items():
        hands = (free.torso @ nao.fk(free.q, name))[:, :3, 3]
        np.testing.assert_allclose(hands[solved], places[solved], atol=1e-7)
    for side, T in feet.items():
        np.testing.assert_allclose(
            free.torso @ nao.fk(free.q, f"{side}Leg"), np.broadcast_to(T, (150, 4, 4)), atol=1e-9
        )
    lost = overlap & ~free.success
    assert (free.reasons[lost] == Reason.COLLISION).all()
    assert (gaps.distance[lost] >= least[lost]).all()
    assert (gaps.distance[lost] > least[lost]).any()
    np.testing.assert_array_equal(free.starts[lost], every.starts[lost] + 20)
    assert (free.starts[overlap & free.success] <= every.starts[overlap & free.success] + 20).all()
    assert free.clearance is not None
    np.testing.assert_array_equal(free.clearance.distance, gaps.distance)
    index = (int(np.flatnonzero(lost)[0]),)
    links = " and ".join(nao.clearance(free.q[index]).pair or ())
    assert free.describe(index).startswith(f"every solution has links that overlap: {links} by ")
    assert np.asarray(free.gives_way)[index] == ""


def test_a_whole_body_pose_without_feet_to_stand_on_has_no_clearance() -> None:
    nao = nk.load_nao()
    feet = {"L": np.eye(4), "R": np.eye(4)}
    feet["R"][1, 3] = -5.0
    result = nk.ik.whole_body(nao, {}, feet=feet, restarts=0, collisions=True)
    assert result.reason is Reason.OUT_OF_REACH
    assert result.clearance is not None
    assert np.isnan(result.clearance.distance)
    assert result.clearance.pair is None
    assert nk.ik.whole_body(nao, {}, restarts=0).clearance is None


# --- Paths.


def _hands(nao: nk.NaoModel, q: np.ndarray, *arms: str) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Positions of hands and directions of forearms."""
    directions = {arm: nao.rotation(q, f"{arm[0]}WristYaw")[:, :, 0] for arm in arms}
    return {arm: nao.position(q, arm) for arm in arms}, directions


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
def test_a_path_takes_the_branches_without_overlap_and_names_the_samples_that_have_none() -> None:
    nao = nk.load_nao()
    start = nao.posture("StandInit")
    avoided = lost = 0
    for words, seed in ((LEGS, 4), (LEGS, 14), (ARMS, 3), (ARMS, 25)):
        ends = _with_random(nao, words, seed, 2)
        q = nao.clamp(ends[0] + np.linspace(0.0, 1.0, 15)[:, None] * (ends[1] - ends[0]))
        path, directions = _hands(nao, q, "LArm")
        if words is LEGS:
            path, directions = {"LLeg": nao.fk(q, "LLeg"), "RLeg": nao.fk(q, "RLeg")}, {}
        options: dict[str, Any] = {"directions": directions, "near": start, "limits": "ignore"}
        every, free = (nk.ik.follow(nao, path, collisions=collisions, **options) for collisions in (False, True))
        before, after = nao.clearance(every.q), nao.clearance(free.q)
        assert every.success
        assert (before.distance < 0.0).any()
        np.testing.assert_array_equal(free.reached, after.is_free)
        avoided += np.count_nonzero(after.is_free & ~before.is_free)
        for index in np.flatnonzero(~after.is_free).tolist():
            lost += 1
            links = " and ".join(nao.clearance(free.q[index]).pair or ())
            assert free.limbs[0].reasons[index] == Reason.COLLISION
            assert free.limbs[0].messages[index].startswith(f"every solution has links that overlap: {links} by ")
    assert avoided > 5
    assert lost > 0


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
def test_a_jump_to_a_branch_without_overlap_says_which_links_overlap_on_the_other() -> None:
    nao = nk.load_nao()
    ends = _with_random(nao, ARMS, 25, 2)
    q = nao.clamp(ends[0] + np.linspace(0.0, 1.0, 15)[:, None] * (ends[1] - ends[0]))
    path, directions = _hands(nao, q, "LArm")
    options: dict[str, Any] = {"directions": directions, "near": nao.posture("StandInit"), "limits": "ignore"}
    found = nk.ik.follow(nao, path, collisions=True, **options)
    assert [jump.index for jump in found.jumps] == [7]
    assert found.jumps[0].cause == "its branch ends at sample 13, where LForeArm and torso overlap by 2.6 mm"
    assert nk.ik.follow(nao, path, **options).jumps == ()


def test_a_limb_is_reached_when_another_one_has_made_room() -> None:
    nao = nk.load_nao()
    angles = {"ShoulderPitch": (0.477, 0.985), "ShoulderRoll": (-0.141, -0.066), "ElbowYaw": (-0.076, 0.169)}
    angles |= {"ElbowRoll": (-0.623, 1.324), "WristYaw": (-0.322, 1.72), "Hand": (1.0, 1.0)}
    start = nao.posture("StandInit", {"LHand": 1.0, "RHand": 1.0})
    angle_of = {f"{side}{name}": pair[k] for name, pair in angles.items() for k, side in enumerate("LR")}
    q = nao.posture("StandInit", angle_of)
    path, directions = _hands(nao, q[None], "RArm", "LArm")
    options: dict[str, Any] = {"directions": directions, "near": start, "limits": "ignore"}
    overlapping = nk.ik.follow(nao, path, **options).q[0]
    assert nao.clearance(overlapping).distance < 0.0
    alone = nk.ik.arm(nao, "R", path["RArm"][0], direction=directions["RArm"][0], near=overlapping, limits="ignore")
    assert (nao.clearance(alone.solutions).distance < 0.0).all()
    found = nk.ik.follow(nao, path, collisions=True, **options)
    assert found.success
    assert found.message.startswith("1 of 1 sample reached")
    assert nao.clearance(found.q[0]).is_free


def test_a_path_that_overlaps_nowhere_is_unchanged() -> None:
    nao = nk.load_nao()
    path = {"LArm": np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)}
    one, other = (
        nk.ik.follow(nao, path, near=nao.posture("StandInit"), collisions=collisions) for collisions in (False, True)
    )
    np.testing.assert_array_equal(one.q, other.q)
    assert one.message == other.message


def test_a_member_of_a_family_that_overlaps_gives_way_to_another_branch_of_the_path() -> None:
    nao = nk.load_nao()
    q = _with_random(nao, ARMS, 1, 300)
    place = nao.position(nao.posture("StandInit", LShoulderRoll=-0.1, LElbowRoll=-1.0), "LArm")
    ways = nk.ik.arm(nao, "L", np.tile(place, (300, 1)), near=q)
    columns = list(ways.columns)
    other = int(np.argmax(nao.clearance(ways.q).distance))
    alone = np.tile(q[other], (300, 1))
    alone[:, columns] = ways.q[:, columns]
    gaps = nao.clearance(alone).distance
    one = int(np.argmin(gaps))
    assert gaps[one] < 0.0 < gaps[other]
    options = {"limits": "enforce", "threads": None, "collisions": True}
    limb = follow_limbs.LimbPath(nao, "LArm", ("LArm",), (np.tile(place, (2, 1)),), options, nao.posture("StandInit"))
    first = limb.at(0).solve(q[[other]])
    costs, none = np.array([0.0, 100.0]), np.zeros(2, dtype=np.int64)
    before = follow_branches._Layer(0, ways.best[[one, other]], costs, none, [first, first], none)
    layer = follow_branches._followed(limb, first, 1, before, q[[other, other]], np.ones(5))
    assert layer is not None
    found = q[[other] * len(layer.values)]
    found[:, list(first.columns)] = layer.values
    assert (nao.clearance(found).distance >= 0.0).all()
