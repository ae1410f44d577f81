"""`nao-kin ik`, as people use it: numbers, files, pipes, and wrong words."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture
from viewer_pages import messages_of

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.rotations import quat_from_matrix, rpy_from_matrix

# No camera looks at a point on the axes of the neck.
IN_THE_NECK = [0.0, 0.0, 0.1265]


def said(capsys: Capture, *arguments: str, code: int = 0) -> str:
    assert run(["ik", *arguments]) == code
    return str(capsys.readouterr().out)


refused = partial(command_line.refused, "ik")


def words(numbers: object) -> str:
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


def table(out: str) -> dict[str, list[float]]:
    """The rows of a printed table, by joint."""
    rows = [line.split() for line in out.splitlines()]
    return {row[0]: [float(cell) for cell in row[1:]] for row in rows if row and row[0].startswith(("L", "R", "Head"))}


def test_a_pose_is_understood_in_every_form(capsys: Capture, nao: nk.NaoModel) -> None:
    T = nao.fk(nao.posture("Crouch"), "RLeg")
    rpy = rpy_from_matrix(T[:3, :3])
    forms = (
        (words(T), ()),
        (words([*T[:3, 3], *rpy]), ()),
        (words([*T[:3, 3], *np.degrees(rpy)]), ("--deg",)),
        (words([*T[:3, 3], *quat_from_matrix(T[:3, :3])]).replace(" ", ", "), ()),
    )
    expected = nk.ik.leg(nao, "R", T)
    for text, more in forms:
        answer = json.loads(said(capsys, "RLeg", "--target", text, *more, "--json"))
        assert answer["success"]
        assert answer["reason"] == "REACHED"
        values = np.array(list(answer["joints"].values()))
        np.testing.assert_allclose(np.radians(values) if more else values, expected.best, atol=1e-9)
        assert list(answer["joints"])[:2] == ["LHipYawPitch", "RHipRoll"]
        assert answer["residual"]["position"] < 1e-10


def test_a_quaternion_that_is_none_is_refused_and_brackets_are_not(capsys: Capture, tmp_path: Path) -> None:
    says = (
        "4 numbers are an orientation as a quaternion, whose length must be 1, not 0.198494; expected 3 numbers for a"
    )
    assert says in refused(capsys, "LArm", "--target", "0.15 0.12 0.05 0")
    assert "whose length must be 1, not 0;" in refused(capsys, "Head", "--target", "0 0 0 0")
    assert "a position with a quaternion" in refused(capsys, "LLeg", "--target", "0 0.05 -0.3 1.0015 0 0 0")
    said(capsys, "Head", "--target", "0.9995 0 0 0")
    file = tmp_path / "targets.csv"
    file.write_text("x,y,z,r0,r1,r2,r3\n0,0.05,-0.3,1,0,0,0\n0,0.05,-0.3,1,0.2,0,0\n")
    assert "line 3: 7 numbers are a position with a quaternion" in refused(capsys, "LLeg", str(file))
    plain = said(capsys, "LArm", "--target", "0.15 0.12 0.05")
    assert plain.startswith("target: a position\nreached")
    for text in ("[0.15, 0.12, 0.05]", "(0.15, 0.12, 0.05)", "[0.15 0.12\n 0.05]"):
        assert said(capsys, "LArm", "--target", text) == plain
    identity = said(capsys, "Head", "--target", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]")
    assert identity.startswith("target: an orientation\n")
    assert json.loads(said(capsys, "Head", "--target", "1 0 0 0", "--json"))["target"] == "orientation"
    standing = "0 0.05 -0.33 0 0 0 0 -0.05 -0.33 0 0 0"
    assert said(capsys, "Legs", "--target", standing).startswith("target: the poses of both feet\n")


def test_all_prints_every_branch_and_its_family(capsys: Capture, nao: nk.NaoModel) -> None:
    T = nao.fk(nao.posture("StandInit"), "LLeg")
    arguments = ("LLeg", "--target", words(T), "--all", "--limits", "ignore")
    expected = nk.ik.leg(nao, "L", T, limits="ignore").branches
    rows = table(said(capsys, *arguments))
    np.testing.assert_allclose(np.array(list(rows.values())), expected.T, atol=1e-5)
    answer = json.loads(said(capsys, *arguments, "--json"))
    assert answer["count"] == 8
    found = np.array([list(solution["joints"].values()) for solution in answer["solutions"]])
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert {solution["family"] for solution in answer["solutions"]} == {"NONE"}


def test_hands_cameras_head_and_other_robots_are_placed(capsys: Capture, nao: nk.NaoModel) -> None:
    hand = json.loads(said(capsys, "LArm", "--target", "0.15 0.12 0.05", "--criterion", "limits", "--json"))
    q = nao.configuration(hand["joints"])
    np.testing.assert_allclose(nao.fk(q, "LArm")[:3, 3], [0.15, 0.12, 0.05], atol=1e-9)
    chosen = nk.ik.arm(nao, "L", [0.15, 0.12, 0.05], criterion="limits").best
    np.testing.assert_allclose(list(hand["joints"].values()), chosen, atol=1e-12)
    assert np.abs(chosen - nk.ik.arm(nao, "L", [0.15, 0.12, 0.05]).best).max() > 0.1

    wanted = nao.fk(nao.posture("Crouch"), "LArm")
    pointing = ("LArm", "--target", words(wanted[:3, 3]), "--direction", words(2.0 * wanted[:3, 0]), "--json")
    hand = json.loads(said(capsys, *pointing))
    forearm = nao.fk(nao.configuration(hand["joints"]), "LArm")
    np.testing.assert_allclose(forearm[:3, [0, 3]], wanted[:3, [0, 3]], atol=1e-9)

    gaze = json.loads(said(capsys, "CameraBottom", "--target", "1 0.3 0", "--json"))
    camera = nao.fk(nao.configuration(gaze["joints"]), "CameraBottom")
    seen = camera[:3, :3].T @ (np.array([1.0, 0.3, 0.0]) - camera[:3, 3])
    np.testing.assert_allclose(seen[1:], 0.0, atol=1e-9)

    turned = nao.fk(nao.configuration({"HeadYaw": 0.4, "HeadPitch": 0.1}), "Head")
    for target in (turned[:3, :3], quat_from_matrix(turned[:3, :3])):
        head = json.loads(said(capsys, "Head", "--target", words(target), "--json"))
        assert head["joints"] == pytest.approx({"HeadYaw": 0.4, "HeadPitch": 0.1})
    assert run(["ik", "Head", "--target", words(turned), "--json"]) == 0
    assert "only the orientation of a pose is used" in capsys.readouterr().err

    numbers = json.loads(said(capsys, "LArm", "--target", "0.15 0.12 0.05", "--numeric", "--json"))
    q = nao.configuration(numbers["joints"])
    np.testing.assert_allclose(nao.fk(q, "LArm")[:3, 3], [0.15, 0.12, 0.05], atol=1e-7)


def test_both_feet_are_placed_on_their_one_motor(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    q = nao.random(2, 5)
    feet = nao.fk(q, ["LLeg", "RLeg"])
    np.save(tmp_path / "feet.npy", feet)
    one = json.loads(said(capsys, "Legs", "--target", words(feet[0]), "--json"))
    assert one["success"]
    assert len(one["joints"]) == 11
    assert one["yaw_errors_rad"] == pytest.approx({"left": 0.0, "right": 0.0}, abs=1e-9)
    np.savetxt(tmp_path / "q.csv", q, delimiter=",", header=",".join(nao.joint_names), comments="", fmt="%.17g")
    assert run(["fk", str(tmp_path / "q.csv"), "--frame", "RLeg", "--frame", "LLeg", "--csv"]) == 0
    (tmp_path / "feet.csv").write_text(capsys.readouterr().out)
    for name in ("feet.npy", "feet.csv"):
        lines = said(capsys, "Legs", str(tmp_path / name), "--csv").splitlines()
        found = np.array([line.split(",") for line in lines[1:]], dtype=float)
        np.testing.assert_allclose(nao.fk(found, ["LLeg", "RLeg"]), feet, atol=1e-8)
    disagreeing = ("Legs", "--target", "0 0.05 -0.3 0 0 0.2 0 -0.05 -0.3 0 0 0.2", "--priority", "left")
    assert "the hips disagree by" in said(capsys, *disagreeing, code=1)
    answer = json.loads(said(capsys, *disagreeing, "--json", code=1))
    assert answer["yaw_errors_rad"]["left"] == pytest.approx(0.0, abs=1e-9)
    assert abs(answer["yaw_errors_rad"]["right"]) > 0.3
    assert answer["reason"] == "HIPS_DISAGREE"


def test_a_robot_without_a_closed_form_is_searched(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="bar"><link name="base"/><link name="tip"/><joint name="turn" type="revolute">'
        '<parent link="base"/><child link="tip"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    target = words(nk.rotations.rot_z(0.5))
    answer = json.loads(said(capsys, "tip", "--target", target, "--urdf", str(urdf), "--json"))
    assert answer["joints"] == pytest.approx({"turn": 0.5}, abs=1e-6)


def test_analytic_prints_all_branches_of_another_robot(capsys: Capture) -> None:
    pytest.importorskip("eaik")
    outside = ("LLeg", "--target", "0 0 -0.3 0 0 0", "--analytic", "--lock", "LHipRoll=9")
    assert "LHipRoll" in refused(capsys, *outside)
    romeo = nk.load_robot("romeo")
    q = romeo.configuration({"LWristRoll": 0.2, "LElbowRoll": -0.6, "LShoulderYaw": 0.3})
    target = words(romeo.fk(q, "LWristPitch", reference="base_link"))
    locks = ("--lock", "TrunkYaw=0", "--lock", f"LWristRoll={float(np.degrees(0.2))!r}", "--deg")
    arguments = ("LWristPitch", "--robot", "romeo", "--analytic", "--target", target, "--all", "--json")
    assert "8 joints, and EAIK solves 6; lock 2 of TrunkYaw" in refused(capsys, *arguments)
    answer = json.loads(said(capsys, *arguments, *locks))
    assert answer["success"]
    nearest = min(abs(found["joints"]["LElbowRoll"] - np.degrees(-0.6)) for found in answer["solutions"])
    assert nearest < 1e-6
    free = json.loads(said(capsys, *arguments, *locks, "--limits", "ignore"))
    assert free["count"] == len(free["solutions"]) >= 4
    assert {found["family"] for found in free["solutions"]} == {"NONE"}


def test_a_sliding_joint_is_told_in_metres(capsys: Capture, tmp_path: Path) -> None:
    urdf = tmp_path / "lift.urdf"
    urdf.write_text(
        '<robot name="lift"><link name="base"/><link name="tip"/><joint name="slide" type="prismatic">'
        '<parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    out = said(capsys, "tip", "--target", "0 0 -0.5", "--urdf", str(urdf), "--deg", code=1)
    assert out.startswith("target: a position\nslide needs -0.5 m, limit 0")


def test_what_is_not_reached_says_why_and_exits_with_one(capsys: Capture) -> None:
    out = said(capsys, "LLeg", "--target", "0 0.05 -0.5 0 0 0", code=1)
    assert out.startswith("target: a pose\nout of reach; the nearest pose is off by ")
    assert "targets are in metres" in said(capsys, "LLeg", "--target", "0 50 -300 0 0 0", code=1)
    assert "LHipYawPitch needs" in said(capsys, "LLeg", "--target", "0 0.05 -0.3 0 0 3.5", code=1)
    answer = json.loads(said(capsys, "LLeg", "--target", "0 0.05 -0.5 0 0 0", "--json", code=1))
    assert set(answer["joints"]) > {"LKneePitch", "LAnkleRoll"}  # of the nearest pose
    assert answer["residual"]["position"] > 0.1
    assert answer["reason"] == "OUT_OF_REACH"
    # A leaning head has a nearest orientation, and nothing was asked of its place.
    out = said(capsys, "Head", "--target", "0.94346 0 0.31449 0.10483", code=1)
    assert "the nearest pose is off by 0.171 rad" in out
    assert "nearest" in out.splitlines()[3]
    assert set(table(out)) == {"HeadYaw", "HeadPitch"}


def test_messages_are_in_degrees_too(capsys: Capture) -> None:
    turned = ("LLeg", "--target", "0 0.05 -0.3 0 0 70", "--deg")
    assert said(capsys, *turned, code=1).startswith("target: a pose\nLHipYawPitch needs -75.6°, limit -65.6")
    assert json.loads(said(capsys, *turned, "--json", code=1))["message"].startswith("LHipYawPitch needs -75.6°")
    feet = ("Legs", "--target", "0 0.05 -0.3 0 0 10 0 -0.05 -0.3 0 0 10", "--deg")
    assert "the feet are turned by -10° (left) and -10° (right)" in said(capsys, *feet, code=1)


def test_the_output_of_fk_is_a_file_of_targets(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    q = nao.random(0, 20)
    walk, feet = tmp_path / "walk.csv", tmp_path / "feet.csv"
    np.savetxt(walk, q, delimiter=",", header=",".join(nao.joint_names), comments="", fmt="%.17g")
    for style in ("rpy", "quaternion", "matrix"):
        assert run(["fk", str(walk), "--frame", "LLeg", "--frame", "RLeg", "--csv", "--as", style]) == 0
        feet.write_text(capsys.readouterr().out)
        lines = said(capsys, "RLeg", str(feet), "--csv").splitlines()
        assert lines[0].split(",") == list(nao.joint_names)
        found = np.array([line.split(",") for line in lines[1:]], dtype=float)
        np.testing.assert_allclose(nao.fk(found, "RLeg"), nao.fk(q, "RLeg"), atol=1e-8)


def test_json_and_npy_files_are_read_too(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    q = nao.random(3, 4)
    T = nao.fk(q, "LLeg")
    np.save(tmp_path / "feet.npy", T)
    (tmp_path / "feet.json").write_text(json.dumps(T.tolist()))
    assert run(["fk", "--posture", "Sit", "--json", "--deg", "--frame", "LLeg"]) == 0
    (tmp_path / "sit.json").write_text(capsys.readouterr().out)
    for name in ("feet.npy", "feet.json"):
        answer = json.loads(said(capsys, "LLeg", str(tmp_path / name), "--json"))
        values = np.array([list(target["joints"].values()) for target in answer["targets"]])
        np.testing.assert_allclose(values, nk.ik.leg(nao, "L", T).best, atol=1e-12)
    one = json.loads(said(capsys, "LLeg", str(tmp_path / "sit.json"), "--near", "Sit", "--json"))
    sit = nao.angles(nao.posture("Sit"))
    assert one["joints"] == pytest.approx({name: sit[name] for name in one["joints"]}, abs=1e-6)


def test_a_list_prints_a_line_for_each_and_names_what_is_missed(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    T = nao.fk(nao.random(5, 9), "LLeg")
    T[2:, 2, 3] -= 1.0
    np.save(tmp_path / "feet.npy", T)
    assert run(["ik", "LLeg", str(tmp_path / "feet.npy")]) == 1
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert len(lines) == 10
    assert lines[1].endswith("REACHED")
    assert lines[3].endswith("OUT_OF_REACH")
    assert "nan" not in out
    assert err.splitlines()[0].startswith("nao-kin: target 2: out of reach; ")
    assert err.splitlines()[-1] == "nao-kin: and 2 more of 9 targets"
    assert run(["ik", "LLeg", str(tmp_path / "feet.npy"), "--csv"]) == 1
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 10
    assert err.splitlines()[-1] == "nao-kin: targets 2, 3, 4, 5, 6, 7, 8 have the nearest pose in their row"


def test_a_target_without_any_pose_has_no_row(capsys: Capture, tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", [[1.0, 0.0, 0.2], IN_THE_NECK, IN_THE_NECK])
    assert run(["ik", "CameraTop", str(tmp_path / "points.npy"), "--csv"]) == 1
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 2
    assert err.splitlines()[-1] == "nao-kin: targets 1, 2 have no row"


def test_the_file_of_the_reference_may_have_other_columns(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    file = tmp_path / "near.csv"
    names = ["yaw" if name == "HeadYaw" else name for name in nao.joint_names]
    values = map(repr, nao.posture("Crouch").tolist())
    file.write_text(",".join(["state", *names]) + "\n" + ",".join(["walk", *values]) + "\n")
    target = ("LArm", "--target", "0.1 0.15 0.0", "--csv")
    by_posture = said(capsys, *target, "--near", "Crouch")
    by_file = (*target, "--near", str(file))
    assert "(--ignore-other) leaves it out" in refused(capsys, *by_file)
    assert "missing joints: HeadYaw" in refused(capsys, *by_file, "--ignore-other")
    assert said(capsys, *by_file, "--ignore-other", "--columns", "yaw=HeadYaw") == by_posture
    assert said(capsys, *by_file, "--columns", "state=", "--columns", "yaw=HeadYaw") == by_posture


def test_a_page_shows_the_robot_and_its_other_solutions_as_ghosts(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    T = nao.fk(nao.posture("StandInit"), "LLeg")
    page = tmp_path / "leg.html"
    out = said(capsys, "LLeg", "--target", words(T), "--limits", "ignore", "--html", str(page))
    assert out.startswith(f"{page}\ntarget: a pose\nreached, 8 solutions")
    (ghosts,) = (m for m in messages_of(page.read_text("utf-8")) if m.get("kind") == "ghosts")
    assert ghosts["count"] == 7
    said(capsys, "LLeg", "--target", words(T), "--html", str(page), "--force")
    refused = {m.get("kind"): m for m in messages_of(page.read_text("utf-8"))}
    assert refused["ghosts"]["count"] == 7  # those outside the limits, to see why
    assert refused["targets"]["targets"][0]["name"] == "LLeg"
    assert pytest.approx(T) == np.reshape(refused["targets"]["targets"][0]["matrix"], (4, 4)).T
    np.save(tmp_path / "feet.npy", nao.fk(nao.random(5, 4), "LLeg"))
    said(capsys, "LLeg", str(tmp_path / "feet.npy"), "--html", str(page), "--force")
    messages = messages_of(page.read_text("utf-8"))
    kinds = {m.get("kind") for m in messages}
    assert "ghosts" not in kinds
    assert "clip" in kinds


def test_a_page_beside_json_or_csv_leaves_them_what_they_are(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    page = str(tmp_path / "leg.html")
    arguments = ("LLeg", "--target", words(nao.fk(nao.posture("StandInit"), "LLeg")), "--html", page)
    assert json.loads(said(capsys, *arguments, "--json"))["html"] == page
    assert "overwrite=True (--force) replaces it" in refused(capsys, *arguments, "--csv")
    assert run(["ik", *arguments, "--csv", "--force"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[0].split(",") == list(nao.joint_names)
    assert err == f"{page}\n"


def test_poses_in_another_frame_are_refused(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "hand.json"
    assert run(["fk", "--posture", "StandInit", "--frame", "LArm", "--reference", "CameraTop", "--json"]) == 0
    path.write_text(capsys.readouterr().out)
    assert 'poses in "CameraTop"; expected them in the torso' in refused(capsys, "LArm", str(path))
    assert run(["fk", "--posture", "StandInit", "--frame", "LArm", "--reference", "torso", "--json"]) == 0
    path.write_text(capsys.readouterr().out)
    assert json.loads(said(capsys, "LArm", str(path), "--json"))["success"]


def test_a_flat_list_is_one_target_and_full_turns_are_asked_about(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "one.json").write_text("[0, 0.05, -0.3, 0, 0, 0]")
    assert said(capsys, "LLeg", str(tmp_path / "one.json")).startswith("target: a pose\nreached, 1 solution")
    assert run(["ik", "LLeg", "--target", "0 0.05 -0.3 0 0 45"]) == 1
    assert "45 rad is more than a full turn; degrees=True (--deg, of a file --file-deg)" in capsys.readouterr().err
    assert run(["ik", "LLeg", "--target", "0 0.05 -0.3 0 0 20", "--deg"]) == 0
    assert capsys.readouterr().err == ""


def test_every_solution_of_a_list_has_its_line(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    np.save(tmp_path / "feet.npy", nao.fk(nao.random(5, 2), "LLeg"))
    lines = said(capsys, "LLeg", str(tmp_path / "feet.npy"), "--all", "--limits", "ignore").splitlines()
    assert len(lines) == 1 + 2 * 8
    assert lines[8].endswith("solution 8 of 8")
    assert lines[9].split()[0] == "1"


def test_without_a_solution_no_page_is_written(capsys: Capture, tmp_path: Path) -> None:
    page = tmp_path / "leg.html"
    said(capsys, "CameraTop", "--target", " ".join(map(str, IN_THE_NECK)), "--html", str(page), code=1)
    assert not page.exists()
    assert "folder" in refused(capsys, "LLeg", "--target", "0 0 0 0 0 0", "--html", str(tmp_path))
    assert "write to standard output" in refused(
        capsys, "LLeg", "--target", "0 0 0 0 0 0", "--html", "/dev/stdout", "--json"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("LLeg",), "give one target with --target"),
        (("LLeg", "a.csv", "--target", "1 2 3"), "FILE and --target exclude each other"),
        (("LLeg", "--target", "1 2"), "2 numbers; expected 3 numbers for a position"),
        (("LLeg", "--target", "1 2 x"), "'x' is not a finite number"),
        (("Head", "--target", "1 2 3"), "in the neck, which has one position: give an orientation, or look at a point"),
        (("LLeg", "--target", "0 0.05 -0.3", "--direction", "1 0 0"), "for positions of a hand"),
        (("LArm", "--target", "0.1 0.1 0", "--direction", "1 0"), "2 numbers, expected 3"),
        (("Legs", "--target", "0 0 0"), "expected 12, 14 or 32"),
        (("Legs", "--target", words(np.zeros(12)), "--numeric"), "Legs has two"),
        (("LLeg", "--target", "0 0.05 -0.3 0 0 0", "--priority", "left"), "--priority is for Legs"),
        (("LLeg", "--target", "0 0.05 -0.3 0 0 0", "--numeric", "--analytic"), "--numeric and --analytic exclude"),
        (("LLeg", "--target", "0 0.05 -0.3", "--analytic"), "--analytic takes poses"),
        (("LLeg", "--target", "0 0.05 -0.3 0 0 0", "--lock", "LHipRoll=0"), "--lock needs --analytic"),
    ],
)
def test_wrong_words_are_refused_in_one_line(capsys: Capture, arguments: tuple[str, ...], message: str) -> None:
    assert message in refused(capsys, *arguments)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", "x,y\n1,2\n", "line 1: the header names x, y; expected one of"),
        ("a.csv", "x,y,z\n1,2,3\n1,two,3\n", "line 3, column 2: y is 'two'"),
        ("a.csv", "x,y,z\n1,2\n", "line 2: 2 values, the header names 3"),
        ("a.csv", "frame,x,y,z\nRArm,1,2,3\n", "no targets for 'LArm'"),
        ("a.json", "[[1,2,3],[1,2]]", "target 1 has 2 numbers, the first 3"),
        ("a.json", "[[1,2,NaN]]", "target 0: NaN is not a finite number"),
        ("a.json", "[]", "expected a list of targets"),
        ("a.json", '{"poses": {"RArm": [1, 2, 3]}}', "target 0: no pose of 'LArm'"),
        ("a.npy", "text", "not a .npy file"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_place(
    capsys: Capture, tmp_path: Path, name: str, content: str, message: str
) -> None:
    (tmp_path / name).write_text(content)
    assert message in refused(capsys, "LArm", str(tmp_path / name))


def test_arrays_of_other_shapes_are_refused(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    for array, message in (
        (np.zeros((2, 5)), "5 numbers"),
        (np.array([[0.0, 0.0, np.inf]]), "row 0 has a number that is not finite"),
        (np.array(["a"]), "array of numbers"),
        (np.float64(3.0), "array of numbers"),
        (np.zeros((0, 4, 4)), "no targets"),
    ):
        np.save(path, array)
        assert message in refused(capsys, "LLeg", str(path))


def test_degrees_of_a_target_and_of_a_file_of_targets(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit", HeadYaw=0.4, HeadPitch=0.2)
    T = nao.fk(q, "LLeg")
    six = [*T[:3, 3].tolist(), *nk.rotations.rpy_from_matrix(T[:3, :3]).tolist()]
    file, out = tmp_path / "targets.csv", tmp_path / "q.csv"
    for names, turn, options in ((("roll", "pitch", "yaw"), 1.0, ()), (("roll", "pitch", "yaw"), 1.0, ("--deg",)),
                                 (("roll", "pitch", "yaw"), np.degrees(1.0), ("--file-deg",)),
                                 (("roll_deg", "pitch_deg", "yaw_deg"), np.degrees(1.0), ())):  # fmt: skip
        row = [*six[:3], *(turn * angle for angle in six[3:])]
        file.write_text(",".join(("x", "y", "z", *names)) + "\n" + ",".join(map(str, row)) + "\n")
        assert run(["ik", "LLeg", str(file), "-o", str(out), "--force", *options]) == 0
        assert capsys.readouterr().err == ""
        # The headings say the unit of what is written: the next command reads them without an option.
        assert ("LKneePitch [deg]" in out.read_text()) == ("--deg" in options)
        found = nk.stream.read_log(nao, out).q[0]
        assert np.allclose(nao.fk(found, "LLeg"), T, rtol=0.0, atol=1e-9)
    file.write_text("x,y,z,roll,pitch,yaw\n" + 2 * "0,0.05,-0.3,0,0,0.2\n")
    assert run(["ik", "LLeg", str(file), "--csv", "--file-deg"]) == 0
    assert "are these radians" in capsys.readouterr().err
    assert run(["ik", "LLeg", "--target", "0 0.05 -0.3 0 0 20", "--file-deg"]) == 2
    assert "--file-deg needs FILE or --near" in capsys.readouterr().err
