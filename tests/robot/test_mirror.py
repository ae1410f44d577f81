"""Mirror images of configurations."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import nao_kin as nk

MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("version", ["v3.2", "v4", "v6"])
def test_everything_that_stands_in_a_mirror_is_on_the_other_side(
    version: str, base: Literal["fixed", "floating"]
) -> None:
    nao = nk.load_nao(version, base=base)
    rng = np.random.default_rng(0)
    q = nao.random(rng=rng, n=20).reshape(4, 5, -1)
    q[0, 0, nao.nq_base :] = nao.lower
    q[0, 1, nao.nq_base :] = nao.upper
    if base == "floating":
        q[..., :3] = rng.normal(size=(4, 5, 3))
    image = nao.mirror(q)
    reference = None if base == "fixed" else "world"
    for frame in ("Head", "LArm", "RArm", "LLeg", "RLeg", "Torso"):
        other = {"L": "R", "R": "L"}.get(frame[0], frame[0]) + frame[1:]
        T = nao.fk(q, frame, reference=reference)
        assert np.allclose(nao.fk(image, other, reference=reference), MIRROR @ T @ MIRROR, rtol=0.0, atol=1e-12), frame
    assert np.allclose(nao.com(image), nao.com(q) * (1.0, -1.0, 1.0), rtol=0.0, atol=2e-3)
    assert np.allclose(nao.mirror(image), q, rtol=0.0, atol=1e-15)


def test_the_mirror_image_of_a_configuration_is_that_of_a_motion_with_one_key() -> None:
    nao = nk.load_nao()
    for name in nao.posture_names:
        q = nao.posture(name)
        motion = nk.Motion([0.0], nao.joint_names, q[None])
        assert np.array_equal(nao.mirror(q), nk.motion.mirror(nao, motion).configurations(nao).q[0])


def test_what_is_no_configuration_is_refused() -> None:
    nao = nk.load_nao()
    with pytest.raises(nk.errors.WrongShape):
        nao.mirror(np.zeros(24))
    with pytest.raises(nk.errors.NotFinite, match="HeadYaw"):
        nao.mirror(np.full(25, np.nan))


def test_a_calibrated_robot_is_mirrored_by_its_reported_values() -> None:
    nao = nk.load_nao()
    rng = np.random.default_rng(1)
    offsets = {name: float(value) for name, value in zip(nao.joint_names, rng.normal(0.0, 0.01, 25), strict=True)}
    hands = ("LHand", "RHand")
    calibrated = nao.with_offsets(joints={name: value for name, value in offsets.items() if name not in hands})
    for name in nao.posture_names:
        assert np.array_equal(calibrated.mirror(nao.posture(name)), nao.mirror(nao.posture(name)))


def test_joints_that_are_no_mirror_images_are_refused() -> None:
    try:
        solo = nk.load_robot("solo12")  # its names say front and hind, left and right in no way that is known
    except nk.errors.MissingExtra:
        pytest.skip("example-robot-data is not installed")
    with pytest.raises(nk.errors.BadArgument, match="FL_HAA and FL_HAA are not mirror images"):
        solo.mirror(solo.neutral())
    arm = nk.load_robot("ur5_robot")
    with pytest.raises(nk.errors.BadArgument, match="are not mirror images"):
        arm.mirror(arm.neutral())


@pytest.mark.parametrize(("multiplier", "offset", "fits"), [(-1.0, 0.0, True), (-2.0, 0.0, False), (-1.0, 0.1, False)])
def test_a_mimic_joint_that_does_not_follow_as_the_mirror_image_is_refused(
    multiplier: float, offset: float, fits: bool, tmp_path: Path
) -> None:
    def joint(side: str, y: float, mimic: str = "") -> str:
        return (
            f'<link name="{side}"/><joint name="{side}J" type="revolute"><parent link="b"/><child link="{side}"/>'
            f'<origin xyz="0 {y} 0"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
            f"{mimic}</joint>"
        )

    follows = f'<mimic joint="LJ" multiplier="{multiplier}" offset="{offset}"/>'
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r"><link name="b"/>{joint("L", 0.1)}{joint("R", -0.1, follows)}</robot>')
    robot = nk.RobotModel.from_urdf(path)
    if fits:
        assert robot.mirror([0.3]).tolist() == [0.3]
        assert robot.mirror_image("RJ") == nk.semantics.Mimic("LJ", -1.0)
        return
    for call in (lambda: robot.mirror([0.3]), lambda: robot.mirror_image("RJ"), lambda: robot.mirror_image("LJ")):
        with pytest.raises(
            nk.errors.BadArgument,
            match=r"no mirror image: RJ = (-2 LJ \+0|-1 LJ \+0.1) of the mimic joint would not hold in it",
        ):
            call()
