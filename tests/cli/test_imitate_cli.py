"""`nao-kin imitate`: files in, motions out, a page, a report, and one line for each error."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Capture

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.naoqi.virtual import VirtualNao

WAVE = str(nk.imitation.SAMPLES["wave"])
SHORT = ("--end", "0.5", "--legs", "ignore")


def test_a_motion_is_written_with_a_report(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "wave.xar"
    assert run(["imitate", WAVE, "-o", str(out), "--end", "0.5"]) == 0
    output = capsys.readouterr()
    assert output.out == f"{out}\n"
    assert "right forearm: " in output.err
    assert "can perform the motion" in output.err
    motion = nk.motion.read_motion(out)
    assert {"LHipYawPitch", "RShoulderPitch"} <= set(motion.joint_names)


def test_json_says_how_far_the_robot_is_from_the_person(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "wave.csv"
    assert run(["imitate", WAVE, str(out), *SHORT, "--mirror", "--json", "--weight", "place=1"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["output"] == str(out)
    assert report["frames"] == 11
    assert report["check"]["ok"] is True
    assert report["directions"]["left_forearm"].keys() == {"mean", "most", "outside_limits", "made_room"}
    assert report["least_lean"] is None


@pytest.mark.parametrize("posture", ["StandInit", "Crouch"])
def test_the_virtual_nao_plays_what_is_written_for_naoqi(
    nao: nk.NaoModel, tmp_path: Path, capsys: Capture, posture: str
) -> None:
    names = ("wave.py", "wave.xar")
    for name in names:
        assert run(["imitate", WAVE, str(tmp_path / name), "--end", "0.6", "--lead", "0.8"]) == 0
        assert "° away at most" in capsys.readouterr().err
    motion = nk.motion.read_motion(tmp_path / "wave.py")
    assert motion.start == 0.8
    with VirtualNao(nao, stepped=True, posture=posture, behaviors=tmp_path) as virtual:
        virtual.call("ALMotion", "wakeUp")
        said = len(virtual.log.lines)
        for name in names:
            if name.endswith(".py"):
                lists: dict[str, list] = {}
                exec((tmp_path / name).read_text(), lists)
                arguments = [lists[key] for key in ("names", "times", "keys")]
                call = virtual.post("ALMotion", "angleInterpolationBezier", *arguments)
            else:
                call = virtual.post("ALBehaviorManager", "runBehavior", "wave")
            virtual.step(1.0)
            command = virtual.call("ALMotion", "getAngles", list(motion.joint_names), False)
            np.testing.assert_allclose(command, motion.sample(1.0), atol=1e-3)
            virtual.step(motion.end)
            assert call.done()
        assert virtual.log.lines[said:] == []  # nothing is late, clipped or refused


def test_files_for_naoqi_have_few_keys_and_begin_late(tmp_path: Path, capsys: Capture) -> None:
    motions = {}
    for name, more in (("few.py", ()), ("led.csv", ("--lead", "1")), ("all.csv", ())):
        assert run(["imitate", WAVE, str(tmp_path / name), *SHORT, "--json", *more]) == 0
        report = json.loads(capsys.readouterr().out)
        motions[name] = nk.motion.read_motion(tmp_path / name)
        if name == "few.py":
            assert report["keys"] == sum(map(len, motions[name].keys))
            assert report["error_deg"] < 1.0
    few, led, every = motions.values()
    assert (few.start, led.start, every.start) == (1.0, 1.0, 0.0)
    assert sum(map(len, few.keys)) < 0.5 * sum(map(len, led.keys))
    assert min(np.diff(times).min() for times in few.times) > 0.009
    assert np.abs(few.sample(led.key_times) - led.sample(led.key_times)).max() < np.radians(1.0)


def test_an_npz_also_has_the_floating_base(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "clip.npz"
    assert run(["imitate", WAVE, str(path), *SHORT]) == 0
    capsys.readouterr()
    assert nk.motion.read_motion(path).start == 0.0
    with np.load(path) as arrays:  # without pickles
        # What BeyondMimic's and mjlab's MotionLoader read, and what a pickle of GMR has.
        shapes = {name: arrays[name].shape for name in arrays.files}
        assert arrays["root_rot"][0] @ arrays["body_quat_w"][0, 0, [1, 2, 3, 0]] == pytest.approx(1.0)
    assert shapes["fps"] == (1,)
    for name, last in (("pos", (3,)), ("quat", (4,)), ("lin_vel", (3,)), ("ang_vel", (3,))):
        assert shapes[f"body_{name}_w"] == (26, 43, *last)
    assert shapes["joint_pos"] == shapes["joint_vel"] == shapes["dof_pos"] == (26, 42)
    assert (shapes["root_pos"], shapes["local_body_pos"], shapes["link_body_list"]) == ((26, 3), (26, 43, 3), (43,))


def test_a_page_shows_the_person_too(tmp_path: Path, capsys: Capture) -> None:
    page = tmp_path / "wave.html"
    assert run(["imitate", WAVE, str(tmp_path / "wave.csv"), *SHORT, "--html", str(page)]) == 0
    assert str(page) in capsys.readouterr().out
    assert page.stat().st_size > 1_000_000


@pytest.mark.full
def test_the_same_call_gives_the_same_files(tmp_path: Path, capsys: Capture) -> None:
    written = []
    for k in range(2):
        files = [tmp_path / f"wave {k}.json", tmp_path / f"wave {k}.html"]
        assert run(["imitate", WAVE, str(files[0]), "--end", "0.2", "--html", str(files[1])]) == 0
        written.append([file.read_bytes() for file in files])
    assert written[0] == written[1]
    capsys.readouterr()


def test_outputs_are_checked_before_the_work(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nk.imitation, "read_skeleton", None)
    for arguments in (["out.mp4"], ["out.csv", "--to", "xap"], ["out.csv", "--html", "page.mp4"], ["out"]):
        assert run(["imitate", WAVE, *(str(tmp_path / word) if "." in word else word for word in arguments)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_a_motion_that_breaks_a_limit_is_exit_code_one(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(nk.imitation.Imitation, "ok", property(lambda self: False))
    assert run(["imitate", WAVE, str(tmp_path / "wave.csv"), *SHORT]) == 1
    capsys.readouterr()


@pytest.mark.parametrize(
    ("name", "content"), [("n.json", '{"chest": "Spine1", "neck": "Head"}'), ("n.csv", "chest,Spine1\nneck,Head\n")]
)
def test_a_file_of_names(name: str, content: str, tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / name).write_text(content)
    arguments = ["imitate", WAVE, str(tmp_path / "wave.csv"), "--end", "0.1", "--legs", "ignore"]
    assert run([*arguments, "--names", str(tmp_path / name), "--names", "head=Neck"]) == 0
    assert run([*arguments, "--force", "--names", str(tmp_path / name), "--names", "neck=Neck"]) == 2
    assert "--names names neck twice" in capsys.readouterr().err
    for wrong in ("[1]", "a,b,c", '{"neck": 3}'):
        (tmp_path / name).write_text(wrong)
        assert run([*arguments, "--force", "--names", str(tmp_path / name)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.bvh", "out.csv"], "nowhere.bvh: "),
        ([WAVE, "out.csv", "--names", "left_wrist"], "--names 'left_wrist': expected POINT=JOINT"),
        ([WAVE, "out.csv", "--names", "left_wirst=LeftHand"], "unknown point 'left_wirst' (nearest: left_wrist"),
        ([WAVE, "out.csv", "--start", "9"], "no frame from 9 to 3.2 s; the skeleton has 0 to 3.2 s"),
        ([WAVE, "out.csv", "--legs", "walk"], "legs"),
        ([WAVE], "give one file or folder to write"),
    ],
)
def test_errors_are_one_line(
    arguments: list[str], message: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["imitate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
