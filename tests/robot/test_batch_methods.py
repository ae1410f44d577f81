"""Batches as users pass them: any shape and layout, results where they want them, and one clear line for the rest."""

from __future__ import annotations

import os
import subprocess
import sys
import tracemalloc
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence

import numpy as np
import pinocchio as pin
import pytest
from loops import for_all

import nao_kin as nk
from nao_kin._core.arrays import CROSSOVER
from nao_kin._kernels import program_run
from nao_kin._kernels.cache import has_numba
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape

FEET = ["LLeg", "RLeg"]
Ask = Callable[..., np.ndarray]


def methods(robot: nk.RobotModel) -> dict[str, tuple[Ask, tuple[int, ...]]]:
    """Every method, and the shape of its answer for one configuration."""
    return {
        "fk": (lambda q, **o: robot.fk(q, FEET, **o), (2, 4, 4)),
        "one": (lambda q, **o: robot.fk(q, "LArm", **o), (4, 4)),
        "relative": (lambda q, **o: robot.fk(q, FEET, reference="Head", **o), (2, 4, 4)),
        "quaternion": (lambda q, **o: robot.fk(q, "LArm", as_="quaternion", **o), (7,)),
        "rpy": (lambda q, **o: robot.fk(q, FEET, as_="rpy", **o), (2, 6)),
        "rotation": (lambda q, **o: robot.rotation(q, FEET, **o), (2, 3, 3)),
        "position": (lambda q, **o: robot.position(q, "LArm", **o), (3,)),
        "jacobian": (lambda q, **o: robot.jacobian(q, "LArm", **o), (6, robot.nv)),
        "relative jacobian": (lambda q, **o: robot.jacobian(q, "LArm", reference="LLeg", **o), (6, robot.nv)),
        "com": (lambda q, **o: robot.com(q, **o), (3,)),
        "com_jacobian": (lambda q, **o: robot.com_jacobian(q, **o), (3, robot.nv)),
        "com of links": (lambda q, **o: robot.com(q, links=["Head", "l_wrist"], reference="LLeg", **o), (3,)),
        "com_jacobian of links": (lambda q, **o: robot.com_jacobian(q, links="LForeArm", **o), (3, robot.nv)),
        "velocity": (lambda q, **o: robot.velocity(q, np.ones(robot.nv), FEET, **o), (2, 6)),
        "acceleration": (lambda q, **o: robot.acceleration(q, np.ones(robot.nv), np.ones(robot.nv), "LArm", **o), (6,)),
    }


METHODS = sorted(methods(nk.load_nao()))
each_method = for_all("name", METHODS)
needs_numba = pytest.mark.skipif(not has_numba(), reason="needs Numba")


@each_method
@for_all("shape", [(), (1,), (40,), (0,), (2, 0, 3), (2, 3, 1, 4)])
def test_every_leading_shape_comes_back(nao: nk.NaoModel, name: str, shape: tuple[int, ...]) -> None:
    ask, tail = methods(nao)[name]
    q = nao.random(0, shape)
    few, many = ask(q), ask(q, threads=1)
    assert few.shape == many.shape == (*shape, *tail)
    assert few.dtype == many.dtype == np.float64
    assert many.flags.c_contiguous
    assert many.flags.writeable
    np.testing.assert_allclose(few, many, rtol=0, atol=1e-13)


@each_method
def test_every_layout_and_kind_of_number_is_read(nao: nk.NaoModel, name: str) -> None:
    ask, _ = methods(nao)[name]
    q = nao.random(0, 100)
    expected = ask(q, threads=1)
    read_only = q.copy()
    read_only.flags.writeable = False
    wide = np.zeros((200, nao.nq + 3))
    wide[::2, 1:-2] = q
    unaligned = np.frombuffer(b"x" + q.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(q.shape)
    layouts = {
        "read-only": read_only,
        "Fortran": np.asfortranarray(q),
        "sliced": wide[::2, 1:-2],
        "reversed": q[::-1].copy()[::-1],
        "unaligned": unaligned,
        "list": q.tolist(),
        "big-endian": q.astype(">f8"),
    }
    for what, layout in layouts.items():
        for threads in (1, 2):
            np.testing.assert_array_equal(ask(layout, threads=threads), expected, err_msg=what)
    whole = np.round(q)
    np.testing.assert_array_equal(ask(whole.astype(int), threads=1), ask(whole, threads=1))
    single = q.astype(np.float32)
    np.testing.assert_array_equal(ask(single, threads=1), ask(single.astype(np.float64), threads=1))
    np.testing.assert_array_equal(q, nao.random(0, 100))


@each_method
@for_all("count", [3, 40])
@for_all("threads", [None, 1])
def test_results_go_where_they_are_wanted(nao: nk.NaoModel, name: str, count: int, threads: int | None) -> None:
    ask, tail = methods(nao)[name]
    q = nao.random(0, count)
    for kind in (np.float64, np.float32):
        out = np.full((count, *tail), np.nan, dtype=kind)
        assert ask(q, out=out, threads=threads) is out
        np.testing.assert_array_equal(out, ask(q, dtype=kind, threads=threads))


def test_an_out_that_cannot_be_used_is_refused(nao: nk.NaoModel) -> None:
    q = nao.random(0, 40)
    for threads in (None, 1):
        with pytest.raises(WrongShape, match=r"out must have shape \(40, 4, 4\), got \(40, 4\)"):
            nao.fk(q, "LArm", out=np.empty((40, 4)), threads=threads)
        with pytest.raises(BadArgument, match="out must be an array of float32, got float64"):
            nao.fk(q, "LArm", out=np.empty((40, 4, 4)), dtype=np.float32, threads=threads)
        with pytest.raises(BadArgument, match="contiguous"):
            nao.fk(q, "LArm", out=np.empty((40, 4, 8))[..., ::2], threads=threads)
        fixed = np.empty((40, 4, 4))
        fixed.flags.writeable = False
        with pytest.raises(BadArgument, match="writable"):
            nao.fk(q, "LArm", out=fixed, threads=threads)
        memory = np.zeros(40 * 25 + 120)
        memory[: q.size] = q.reshape(-1)
        with pytest.raises(BadArgument, match="must not be in the memory of an input"):
            nao.com(memory[: q.size].reshape(q.shape), out=memory[900:1020].reshape(40, 3), threads=threads)


@for_all("limits", ["ignore", "enforce", "clamp"])
@for_all("threads", [None, 1])
def test_an_input_is_never_written_over(nao: nk.NaoModel, limits: str, threads: int | None) -> None:
    memory = np.zeros(2000)
    q = memory[:1000].reshape(40, 25)
    q[...] = nao.random(0, 40)
    before = memory.copy()
    with pytest.raises(BadArgument, match="memory of an input"):
        nao.fk(q, "LArm", limits=limits, out=memory[900:1540].reshape(40, 4, 4), threads=threads)  # type: ignore[arg-type]
    np.testing.assert_array_equal(memory, before)


@each_method
@for_all("bad", [np.nan, -np.inf])
@for_all("place", [(7, 11), (39, 3)])
def test_the_first_number_that_is_not_finite_is_named(
    nao: nk.NaoModel, name: str, bad: float, place: tuple[int, int]
) -> None:
    ask, _ = methods(nao)[name]
    q = nao.random(0, 40)
    q[place] = q[39, 24] = bad
    for threads in (None, 1, 2):
        for kind in (np.float64, np.float32):
            with pytest.raises(NotFinite) as caught:
                ask(q, threads=threads, dtype=kind)
            assert caught.value.index == place
            assert nao.joint_names[place[1]] in str(caught.value)
        with pytest.raises(NotFinite) as caught:
            ask(q.reshape(5, 8, 25), threads=threads)
        assert caught.value.index == (*divmod(place[0], 8), place[1])


@for_all("threads", [None, 1])
def test_velocities_that_are_not_finite_are_named(nao: nk.NaoModel, threads: int | None) -> None:
    q, v = nao.random(0, 40), np.zeros((40, nao.nv))
    v[3, 4] = np.nan
    with pytest.raises(NotFinite, match=r"v must be finite, got nan at index \[3, 4\]"):
        nao.velocity(q, v, "LArm", threads=threads)
    with pytest.raises(NotFinite, match=r"a must be finite, got nan at index \[3, 4\]"):
        nao.acceleration(q, np.zeros(nao.nv), v, "LArm", threads=threads)


@each_method
def test_wrong_shapes_and_no_numbers_are_refused(nao: nk.NaoModel, name: str) -> None:
    ask, _ = methods(nao)[name]
    for threads in (None, 1):
        for shape in ((40, 24), (40,), (25, 40), ()):
            with pytest.raises(WrongShape):
                ask(np.zeros(shape), threads=threads)
        for nothing in (np.array([None] * 25), "zero", np.zeros(25, complex), [[0.0] * 25, [0.0] * 24]):
            with pytest.raises(BadArgument):
                ask(nothing, threads=threads)
        with pytest.raises(BadArgument, match="masked"):
            ask(np.ma.masked_array(np.zeros(25), mask=[True] * 25), threads=threads)


def test_rates_broadcast_with_the_configurations(nao: nk.NaoModel) -> None:
    q, v = nao.random(0, (4, 1)), np.random.default_rng(0).normal(size=(5, nao.nv))
    found = nao.velocity(q, v, "LArm", threads=1)
    assert found.shape == (4, 5, 6)
    np.testing.assert_allclose(found, nao.velocity(q, v, "LArm"), rtol=0, atol=1e-14)
    expected = np.einsum("aij,bj->abi", nao.jacobian(q[:, 0], "LArm"), v)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
    with pytest.raises(WrongShape):
        nao.velocity(nao.random(0, 3), v, "LArm")
    with pytest.raises(WrongShape, match="v must have shape"):
        nao.velocity(q, v[:, :-1], "LArm")


@needs_numba
def test_what_is_broadcast_is_not_copied(nao: nk.NaoModel) -> None:
    q, v = nao.random(0, (200, 1)), np.random.default_rng(0).normal(size=(1, 300, nao.nv))
    nao.velocity(q[:2], v[:, :2], "LArm", threads=1)
    tracemalloc.start()
    found = nao.velocity(q, v, "LArm", threads=1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1.1 * found.nbytes + 4e6  # a block of rows on its way
    np.testing.assert_array_equal(found[7], nao.velocity(q[7], v[0], "LArm", threads=1))


@pytest.mark.full
@needs_numba
def test_a_result_takes_no_more_memory_than_itself(nao: nk.NaoModel) -> None:
    q = nao.random(0, 100_000)
    for ask, _ in methods(nao).values():
        ask(q[:100], threads=1)
        tracemalloc.start()
        result = ask(q, threads=2)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 1.1 * result.nbytes + 4e6


def test_accelerations_are_the_derivatives_of_velocities(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    q, v, a = nao.random(rng, 20), rng.normal(size=(20, nao.nv)), rng.normal(size=(20, nao.nv))
    h = 1e-5
    for expression in ("mixed", "frame", "root"):
        before = nao.velocity(q - h * v + h * h / 2 * a, v - h * a, FEET, expression)  # type: ignore[arg-type]
        after = nao.velocity(q + h * v + h * h / 2 * a, v + h * a, FEET, expression)  # type: ignore[arg-type]
        rate = nao.acceleration(q, v, a, FEET, expression)  # type: ignore[arg-type]
        np.testing.assert_allclose(rate, (after - before) / (2 * h), rtol=0, atol=1e-7)


def test_the_jacobian_of_the_centre_of_mass_is_its_derivative(each_nao: nk.NaoModel) -> None:
    q, h = each_nao.random(0, 10), 1e-6
    for k in range(each_nao.nv):
        step = h * np.eye(each_nao.nq)[k]
        slope = (each_nao.com(q + step) - each_nao.com(q - step)) / (2 * h)
        np.testing.assert_allclose(each_nao.com_jacobian(q)[..., k], slope, rtol=0, atol=1e-9)


@for_all("name, base", [("v6", "fixed"), ("v6", "floating"), ("romeo", "floating"), ("tiago", "fixed")])
@for_all("expression", ["mixed", "frame", "root"])
def test_the_jacobian_in_a_reference_is_the_derivative_of_the_pose_in_it(name: str, base: str, expression: str) -> None:
    """Differences of fk(reference=) along v, for frames of one limb, of two, and of the trunk."""
    robot = nk.load_nao(name, base=base) if name[0] == "v" else nk.load_robot(name, base=base)
    if name == "v6":
        robot = robot.with_offsets(joints={"LElbowYaw": 0.1, "RHipYawPitch": -0.2})
    model, rng, h = robot.model, np.random.default_rng(4), 1e-6
    q = np.array([pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq)) for _ in range(4)])
    table = robot.joints
    first, middle, last = table.links[0], table.links[len(table.links) // 2], table.links[-1]
    above = table.links[table.path(len(table.links) - 1)[0]]
    root = robot.tree.root
    pairs = [(last, middle), (middle, root), (root, last), (last, last), (last, above), (above, last), (first, last)]
    for frame, reference in pairs:
        v = rng.normal(size=model.nv)
        ahead, behind = (
            robot.fk([pin.integrate(model, row, step * v) for row in q], frame, reference=reference) for step in (h, -h)
        )
        T = robot.fk(q, frame, reference=reference)
        linear = (ahead - behind)[:, :3, 3] / (2 * h)
        angular = nk.rotations.log(ahead[:, :3, :3] @ behind[:, :3, :3].swapaxes(1, 2)) / (2 * h)
        if expression == "frame":
            linear, angular = (np.einsum("nji,nj->ni", T[:, :3, :3], part) for part in (linear, angular))
        if expression == "root":
            linear = linear + np.cross(T[:, :3, 3], angular)
        one, other = (table.path(robot.frame_placement(each)[0]) for each in (frame, reference))
        still = np.setdiff1d(np.arange(model.nv), table.columns[list(set(one) ^ set(other))])
        for threads in (None, 1):
            J = robot.jacobian(q, frame, expression, reference=reference, threads=threads)  # type: ignore[arg-type]
            np.testing.assert_allclose(J @ v, np.concatenate([linear, angular], axis=-1), rtol=0, atol=2e-8)
            assert not J[..., still].any()  # also of a floating base, which moves both alike


def test_the_jacobian_in_the_root_is_the_one_without_reference(nao: nk.NaoModel) -> None:
    q = nao.random(0, 40)
    free = nk.load_nao(base="floating")
    q_free = np.concatenate([np.tile(free.neutral()[:7], (40, 1)), q], axis=-1)
    for threads in (None, 1):
        for expression in ("mixed", "frame", "root"):
            options = {"expressed_in": expression, "threads": threads}
            J = nao.jacobian(q, "LArm", **options)  # type: ignore[arg-type]
            np.testing.assert_allclose(nao.jacobian(q, "LArm", reference="base_link", **options), J, rtol=0, atol=1e-15)  # type: ignore[arg-type]
            J = free.jacobian(q_free, "LArm", **options)  # type: ignore[arg-type]
            np.testing.assert_array_equal(free.jacobian(q_free, "LArm", reference="world", **options), J)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="unknown frame 'world'"):
        nao.jacobian(q, "LArm", reference="world")
    with pytest.raises(UnknownName, match="nearest: LArm"):
        nao.jacobian(q[0], "RArm", reference="LArn")
    with pytest.raises(NotFinite):
        nao.jacobian(q[0] * np.nan, "RArm", reference="LArm")


@for_all("name, base", [("v6", "fixed"), ("v3.3", "floating"), ("romeo", "floating"), ("tiago", "fixed")])
def test_the_centre_of_mass_of_links_and_its_jacobian_are_those_of_pinocchio(name: str, base: str) -> None:
    """Every limb: Pinocchio's subtrees, which are the links that a joint carries; and differences along v."""
    robot = nk.load_nao(name, base=base) if name[0] == "v" else nk.load_robot(name, base=base)
    model = robot.model
    data, rng = model.createData(), np.random.default_rng(1)
    q = np.array([pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq)) for _ in range(3)])
    for joint in range(1, model.njoints, 5):
        carried = set(model.subtrees[joint])
        links = [link for link in robot.link_names if model.frames[robot.frame_table[link]].parentJoint in carried]
        mass = sum(model.inertias[k].mass for k in carried)
        assert robot.mass_of(links) == pytest.approx(mass, rel=1e-12, abs=1e-12)
        if mass == 0.0:
            continue
        for threads in (None, 1):
            com = robot.com(q, links=links, threads=threads)
            for row, found in zip(q, com, strict=True):
                pin.centerOfMass(model, data, row)
                np.testing.assert_allclose(found, data.oMi[joint].act(data.com[joint]), rtol=0, atol=1e-12)
            v, h = rng.normal(size=model.nv), 1e-6
            for reference in (None, links[0], robot.link_names[-1], *(["world"] if base == "floating" else [])):
                ahead, behind = (
                    robot.com([pin.integrate(model, row, step * v) for row in q], links=links, reference=reference)
                    for step in (h, -h)
                )
                J = robot.com_jacobian(q, links=links, reference=reference, threads=threads)
                np.testing.assert_allclose(J @ v, (ahead - behind) / (2 * h), rtol=0, atol=1e-7)


def test_the_centre_of_mass_of_chosen_links_is_the_mean_of_theirs(each_nao: nk.NaoModel) -> None:
    """Read from the XML of the URDF, with calibrated joints, and after a joint has been moved in the model."""
    links = ["torso", "Head", "RForeArm", "l_ankle"]
    inertials = {link.get("name"): link.find("inertial") for link in ET.parse(each_nao.urdf_path).iter("link")}
    rows = [inertials[link if link in inertials else link.removesuffix("_link")] for link in links]
    masses = np.array([float(row.find("mass").get("value")) for row in rows])  # type: ignore[union-attr]
    places = np.array([[*map(float, row.find("origin").get("xyz").split()), 1.0] for row in rows])  # type: ignore[union-attr]
    robot = each_nao.with_offsets(joints={"HeadYaw": 0.1, "RElbowYaw": -0.2})
    for _ in range(2):
        for threads, reference in ((None, None), (1, None), (None, "LLeg"), (1, "LLeg")):
            q = robot.random(3, 4)
            wanted = np.einsum("l,nlij,lj->ni", masses / masses.sum(), robot.fk(q, links, reference=reference), places)
            found = robot.com(q, links=links, reference=reference, threads=threads)
            np.testing.assert_allclose(found, wanted[:, :3], rtol=0, atol=1e-14)
        assert robot.mass_of(links) == pytest.approx(masses.sum(), rel=1e-12)
        robot.model.jointPlacements[robot.model.getJointId("HeadPitch")].translation = np.array([0.1, 0.2, 0.3])
    np.testing.assert_array_equal(robot.com(q, links=[*links, "Head"]), robot.com(q, links=links[::-1]))
    np.testing.assert_allclose(robot.com(q, links=robot.link_names), robot.com(q), rtol=0, atol=1e-14)
    assert robot.mass_of(robot.link_names) == pytest.approx(robot.mass, rel=1e-12)


def test_links_without_mass_and_links_that_do_not_exist_are_refused(nao: nk.NaoModel) -> None:
    q = nao.random(0, 40)
    assert nao.mass_of([]) == nao.mass_of("LHand_link") == 0.0
    for ask in (nao.com, nao.com_jacobian):
        for threads in (None, 1):
            with pytest.raises(BadArgument, match="nao_v6 with only LHand_link has no mass, so no centre of mass"):
                ask(q, links="LHand_link", threads=threads)
            with pytest.raises(BadArgument, match="links must name at least one link"):
                ask(q, links=[], threads=threads)
            with pytest.raises(UnknownName, match="unknown link 'Hed' \\(nearest: Head\\)"):
                ask(q, links=["Hed", "Neck"], threads=threads)
            with pytest.raises(NotFinite):
                ask(np.where(np.arange(25) == 1, np.nan, q), links="Head", threads=threads)
    with pytest.raises(UnknownName, match="unknown link 'HeadYaw'"):
        nao.mass_of("HeadYaw")  # a joint


def test_a_quaternion_of_another_length_is_refused() -> None:
    nao = nk.load_nao(base="floating")
    q = nao.random(0, (5, 8))
    q[2, 3, 3:7] *= 1 + 1e-5
    for threads in (None, 1):
        with pytest.raises(BadArgument, match=r"unit quaternion \(x, y, z, w\), got one of norm 1.00001"):
            nao.fk(q, "LArm", threads=threads)
    q[2, 3, 3:7] /= 1 + 1e-5
    q[..., 3:7] *= 1 - 9e-7
    few, many = nao.fk(q, "LArm"), nao.fk(q, "LArm", threads=1)
    np.testing.assert_allclose(few, many, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(many[..., :3, :3]), 1.0, rtol=0, atol=1e-14)


@for_all("count", [3, 40])
@for_all("threads", [None, 1])
def test_infinity_in_a_base_is_named_before_its_norm(count: int, threads: int | None) -> None:
    nao = nk.load_nao(base="floating")
    for place, name in (((2, 3), "base"), ((2, 12), nao.joint_names[5])):
        for bad in (np.inf, np.nan):
            q = nao.random(0, count)
            q[0, 3:7] *= 1.0 + (place[1] > 7)  # with a number in a joint, a quaternion of norm 2 before it
            q[place] = bad
            with pytest.raises(NotFinite) as caught:
                nao.fk(q, "LArm", threads=threads)
            assert caught.value.index == place
            assert name in str(caught.value)


def test_rates_and_angles_in_single_precision_are_right_to_several_millionths(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    q, v, a = nao.random(rng, 500), rng.uniform(-3, 3, (500, nao.nv)), rng.uniform(-3, 3, (500, nao.nv))
    for ask in (
        lambda **o: nao.velocity(q, v, FEET, **o),
        lambda **o: nao.acceleration(q, v, a, FEET, **o),
        lambda **o: nao.fk(q, FEET, as_="quaternion", **o),
    ):
        single, double = ask(dtype=np.float32, threads=1), ask(threads=1)
        np.testing.assert_allclose(single, double, rtol=1e-6, atol=1e-5)
    single, double = (nao.fk(q, FEET, as_="rpy", dtype=d, threads=1) for d in (np.float32, np.float64))
    turned = np.exp(1j * single[..., 3:]) - np.exp(1j * double[..., 3:])  # ±π is one angle
    flat = np.cos(double[..., 4]) > 0.1  # beside lock roll and yaw are each ill-determined
    np.testing.assert_allclose(np.abs(turned)[flat], 0.0, rtol=0, atol=2e-5)


@needs_numba
def test_few_configurations_go_through_pinocchio_and_many_through_the_kernels(nao: nk.NaoModel) -> None:
    q = nao.random(0, 20 * CROSSOVER)
    by_kernels, one_by_one = nao.fk(q, threads=1), np.array([nao.fk(row) for row in q])
    few = np.concatenate([nao.fk(part) for part in np.split(q[: 10 * (CROSSOVER - 1)], 10)])
    np.testing.assert_array_equal(few, one_by_one[: len(few)])
    # The two differ somewhere in their last bits, so this shows which one answered.
    many = np.concatenate([nao.fk(part) for part in np.split(q, 20)])
    np.testing.assert_array_equal(many, by_kernels)
    assert not np.array_equal(by_kernels, one_by_one)


def test_many_threads_may_ask_at_once(nao: nk.NaoModel) -> None:
    from concurrent.futures import ThreadPoolExecutor

    q = nao.random(0, 2000)
    expected = {frame: nao.fk(q, frame, threads=1) for frame in nao.frame_names[:24]}
    fresh = nk.load_nao()
    with ThreadPoolExecutor(8) as pool:
        found = pool.map(lambda frame: fresh.fk(q, frame, threads=1), expected)
        for poses, frame in zip(found, expected, strict=True):
            np.testing.assert_array_equal(poses, expected[frame])


# --- threads ----------------------------------------------------------------------------------------------------------

FORKED = """
import os, signal, threading
import numpy as np, nao_kin as nk
nao = nk.load_nao()
q = nao.random(0, 1000)
expected = nao.fk(q, "LArm", threads=1)
def same():
    return np.array_equal(nao.fk(q, "LArm", threads=2), expected)
def waiting():
    return sum(thread.name.startswith("nao_kin_batch") for thread in threading.enumerate())
assert same() and same() and waiting() >= 1
before = waiting()
assert same() and waiting() == before
child = os.fork()
if child == 0:
    signal.alarm(20)
    os._exit(0 if same() else 1)
assert os.waitpid(child, 0)[1] == 0
"""


@needs_numba
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_threads_wait_for_the_next_call_survive_a_fork_and_let_the_program_end() -> None:
    subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED], check=True, timeout=60)


@needs_numba
def test_a_second_thread_is_woken_only_where_it_pays(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    woken: list[int] = []

    def map_parts(function: Callable[[slice], int], parts: Sequence[slice]) -> list[int]:
        woken.append(len(parts))
        return [function(part) for part in parts]

    monkeypatch.setattr(program_run._threads, "map", map_parts)
    monkeypatch.setattr(program_run, "usable_cores", lambda: 2)
    frames = ["LArm", "RArm", "LLeg", "RLeg", "Head"]
    nao.fk(nao.random(0, 10_000), frames)
    assert woken == []
    q = nao.random(0, 50_000)
    poses = nao.fk(q, frames)
    assert woken == [2]
    np.testing.assert_array_equal(poses, nao.fk(q, frames, threads=1))
