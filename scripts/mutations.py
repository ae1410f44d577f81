"""Small faults of the kind that a review overlooks: where each is planted, and the tests that must detect it.

Faults of the viewer and its page are in `page_mutations.py`, those of rotations beyond conversions in
`rotation_mutations.py`, those of rigid motions in `screw_mutations.py`. Some faults that no test detected are not
planted, because they change no result: `CHANGES_NOTHING` names them.
"""

from __future__ import annotations

from mutation import Mutation, faults as _faults
from page_mutations import VIEWER
from rotation_mutations import ROTATIONS
from screw_mutations import SCREWS

CHANGES_NOTHING = {
    "the carrier of a universal joint placed by the group's first joint": "it has one carrier, that of its first joint",
    "the chosen triple not wrapped": "whole turns are chosen for each motor afterwards; the wrapping was removed",
    "the floor under the square in exp at 1e-20": "both quotients are constant to the last digit from 1e-16 down",
    "the floor under the norm in log at 1e-20": "atan2(n, r0)/n is constant to the last digit from 1e-8 down",
    "points on the floor ahead of the edge that a body rolls over do not stop it": "the edge is the hull's nearest to "
    "the centre of mass, and no point on the floor is ahead of it",
    "the canonical sign of quat_from_matrix blind to its last component": "if only the last component is not "
    "zero, it is a diagonal entry and hence positive; its check was removed",
}
"""Faults that are not planted, and the reason why no test can detect them."""


_COMMON = (
    *_faults(
        "_core/arrays.py",
        "test_arrays.py",
        (
            "finite-check-refuses-arrays-whose-squares-overflow",
            "                return True\n    return bool(np.isfinite(array).all())",
            "                return True\n            return False\n    return bool(np.isfinite(array).all())",
        ),
        (
            "finite-check-of-large-arrays-misses-nan",
            "if math.isfinite(array.sum()):",
            "if array.sum() != np.inf:",
        ),
        ("finite-check-of-small-arrays-misses-infinity", "np.isfinite(array).all()", "~np.isnan(array).any()"),
    ),
    *_faults(
        "_core/process.py",
        "test_signals.py::test_a_signal_that_wakes_nobody_ends_a_wait_all_the_same",
        ("wait-for-a-signal-that-only-the-main-thread-hears", "_LOOK_SECONDS = 0.1", "_LOOK_SECONDS = 1e4"),
    ),
    *_faults(
        "_core/files.py",
        "test_atomic.py",
        ("written-file-with-the-mode-of-a-new-one", "    os.chmod(temporary, stat.S_IMODE(before.st_mode))\n", ""),
        ("owner-compared-without-the-group", "if (now.st_uid, now.st_gid) != ", "if (now.st_uid, before.st_gid) != "),
        ("read-only-file-taken-where-somebody-may-write", "if not state.st_mode & 0o222:", "if not state.st_mode:"),
        ("descriptor-of-any-process-taken-for-our-own", "in (None, str(os.getpid())):", "in (None, match['process']):"),
        ("descriptor-through-one-link-only", "_MAX_LINKS = 40", "_MAX_LINKS = 2"),
        ("descriptor-opened-for-reading-is-written-to", "== os.O_RDONLY:", "== os.O_ACCMODE:"),
        ("what-was-printed-before-comes-after", "sys.stdout.flush()  # keeps", "pass  # keeps"),
        (
            "temporary-file-left-by-a-failure",
            "0o666), temporary\n        finally:\n            remove()\n",
            "0o666), temporary\n        finally:\n            pass\n",
        ),
        ("suffix-compared-in-its-letter-case", "ending.lower() not in suffixes", "ending not in suffixes"),
        ("new-file-named-as-a-folder", "if text.endswith(os.sep):", "if False:"),
        ("socket-not-refused-by-name", "if stat.S_ISSOCK(state.st_mode):", "if False:"),
        (
            "file-not-given-to-its-owner-replaced-all-the-same",
            "                return False\n            file",
            "                pass\n            file",
        ),
    ),
)

_URDF = (
    *_faults(
        "robot/urdf/reader.py",
        "test_tree.py test_model_from_tree.py",
        ("products-of-inertia-exchanged", "xx, xy, xz, yy, yz, zz = (", "xx, xz, xy, yy, yz, zz = ("),
        ("missing-axis-is-z", 'text = "1 0 0" if element is None', 'text = "0 0 1" if element is None'),
        ("axis-without-xyz-is-z", 'element.get("xyz", "1 0 0")', 'element.get("xyz", "0 0 1")'),
    ),
    *_faults(
        "robot/urdf/reader.py",
        "test_tree.py test_foreign_urdf.py::test_a_file_that_is_no_robot_is_refused_with_the_reason "
        "test_foreign_urdf.py::test_a_negative_speed_or_effort_is_no_limit",
        (
            "speed-read-as-effort",
            "self._bound(name, limit, attribute)",
            'self._bound(name, limit, "effort")',
        ),
        (
            "negative-mass-taken",
            '        if value < 0.0:\n            raise Refused(f"{_name(owner)} has mass',
            '        if False:\n            raise Refused(f"{_name(owner)} has mass',
        ),
        (
            "negative-speed-taken",
            '        if value < 0.0:\n            self.notes.append(f"joint {quoted(joint)} has {attribute}',
            '        if False:\n            self.notes.append(f"joint {quoted(joint)} has {attribute}',
        ),
        (
            "plain-file-expanded",
            "        if not asked:\n            raise BadModel",
            "        if False:\n            raise BadModel",
        ),
        ("range-of-one-value-taken-for-none", "        if lower > upper:", "        if lower >= upper:"),
        ("multiplier-left-out-is-zero", '"multiplier", 1.0)', '"multiplier", 0.0)'),
        ("offset-left-out-is-one", '"offset", 0.0)', '"offset", 1.0)'),
        ("loop-beside-the-tree-not-noticed", "if len(reached) != len(links):", "if False:"),
        ("link-moved-by-two-joints", "if joint.child in carried:", "if False:"),
        (
            "parent-keeps-the-name-that-was-renamed",
            'ends.append(renamed.get(str(end.get("link")), str(end.get("link"))))',
            'ends.append(str(end.get("link")))',
        ),
    ),
    *_faults(
        "robot/urdf/reader.py",
        "test_foreign_urdf.py::test_a_speed_of_0_is_no_limit_to_any_function",
        ("speed-of-0-taken", 'if value == 0.0 and attribute == "velocity":', "if False:"),
    ),
    *_faults(
        "robot/urdf/reader.py",
        "test_tree.py",
        (
            "negative-damping-kept",
            "if not 0.0 <= value < math.inf:\n            self.notes",
            "if not value < math.inf:\n            self.notes",
        ),
        (
            "friction-read-as-damping",
            "self._loss(name, dynamics, attribute)",
            'self._loss(name, dynamics, "damping")',
        ),
    ),
    *_faults(
        "robot/urdf/document.py",
        "test_foreign_urdf.py::test_meshes_beside_the_file_are_not_missing",
        (
            "mesh-of-a-package-looked-for-beside-the-file-alone",
            "(*self._given, *self._folder.parents, self._folder)",
            "(*self._given, self._folder)",
        ),
    ),
    *_faults(
        "robot/urdf/tree.py",
        "test_tree.py test_model_from_tree.py",
        (
            "fresh-name-of-a-link-is-that-of-a-joint",
            "taken = joints.union(links)",
            "taken = frozenset(links)",
        ),
    ),
    *_faults(
        "robot/urdf/couplings.py",
        "test_configurations.py::test_a_follower_shares_its_speed_limit_by_its_multiplier",
        (
            "follower-limits-speed-without-its-multiplier",
            "-follower.velocity / abs(follower.coupling.multiplier)",
            "-follower.velocity",
        ),
    ),
    *_faults(
        "robot/urdf/couplings.py",
        "test_foreign_urdf.py::test_a_follower_that_confines_one_end_is_noted",
        ("upper-limit-shared-without-a-note", "if (lower, upper) != before:", "if lower != before[0]:"),
        ("lower-limit-shared-without-a-note", "if (lower, upper) != before:", "if upper != before[1]:"),
    ),
    *_faults(
        "robot/urdf/couplings.py",
        "test_tree.py test_foreign_urdf.py::test_a_driving_joint_is_confined_to_what_suits_its_followers",
        (
            "chain-of-followers-composed-the-wrong-way-round",
            "mimic.through(direct[mimic.joint]) if mimic.joint in direct",
            "direct[mimic.joint].through(mimic) if mimic.joint in direct",
        ),
        ("other-followers-keep-the-old-driver", "mimic=other.coupling.through(inverse)", "mimic=other.mimic"),
        (
            "turned-round-coupling-not-inverted",
            "inverse = first.coupling.inverted(first.name)",
            "inverse = replace(first.coupling, joint=first.name)",
        ),
        ("lower-limit-not-shared", "lower, upper = _larger(lower, low), ", "lower, upper = lower, "),
        ("upper-limit-not-shared", "-_larger(-upper, -high)\n", "upper\n"),
        (
            "speed-of-a-driver-that-keeps-its-range-not-shared",
            "        return replace(driver, velocity=velocity)\n    if",
            "        return driver\n    if",
        ),
        ("constant-follower-confines-its-driver", "if follower.coupling.multiplier != 0.0]", "]"),
        ("locked-joint-not-counted-as-one-that-cannot-move", "if driver.lower < driver.upper and all(", "if all("),
        ("locked-follower-not-counted-as-one-that-cannot-move", "follower.lower < follower.upper for", "True for"),
        (
            "rounding-confines-a-driver",
            "other <= value or math.isclose(value, other, rel_tol=1e-9, abs_tol=1e-12)",
            "other <= value",
        ),
        (
            "driving-branch-not-first",
            "            siblings[:] = _drivers_first(siblings, branch, joints)\n",
            "            pass\n",
        ),
    ),
    *_faults(
        "robot/urdf/document.py",
        "test_urdf_documents.py",
        ("line-of-a-mistake-without-the-blank-ones", ' + content[: len(content) - len(text)].count(b"\\n")', ""),
        ("macros-that-nobody-calls-taken", 'self._name(element) == "macro"', "False"),
        (
            "expression-in-an-unused-property-refused",
            '_DEFINITIONS = ("property", "arg", "include")',
            '_DEFINITIONS = ("arg", "include")',
        ),
        ("expression-in-an-include-refused", '("property", "arg", "include")', '("property", "arg")'),
        ("any-prefix-counts-as-xacro", ' and "xacro" in value', ""),
        ("prefix-bound-to-xacro-not-known", 'prefixes = {"xacro:"} | {', 'prefixes = {"xacro:"} or {'),
        ("document-with-dollars-alone-not-looked-at", ' and b"${" not in content', ""),
    ),
    *_faults(
        "robot/urdf/srdf.py",
        "test_semantics.py",
        ("cosine-taken-for-sine", "math.atan2(numbers[1], numbers[0])", "math.atan2(numbers[0], numbers[1])"),
        ("chain-of-a-group-from-the-root", "while tip in self._above and tip != base:", "while tip in self._above:"),
        ("branches-count-as-a-chain", "if ordered and members <=", "if ordered or members <="),
        ("group-inside-itself-followed-for-ever", " and name not in inside:", ":"),
        (
            "second-state-of-a-name-forgets-the-first",
            'angles.setdefault(state.get("name", ""), {})',
            'angles[state.get("name", "")] = {}',
        ),
        ("floating-base-of-a-state-counted-as-missing", "elif len(text.split()) == 1:", "else:"),
        ("root-link-of-a-group-counted-as-missing", "if name not in self._links:", "if True:"),
        ("chain-in-the-order-of-the-alphabet", "sorted(members, key=self._order.__getitem__)", "sorted(members)"),
        ("fixed-joints-in-a-chain", 'if joint.kind != "fixed"}', "}"),
    ),
    *_faults(
        "robot/urdf/tree.py",
        "test_scene.py::test_a_urdf_visual_holds_what_the_file_says_in_numbers "
        "test_scene.py::test_primitives_poses_and_colours_are_read test_tree.py",
        ("colour-by-name-not-found", "_rgba(material) or colours.get(name)", "_rgba(material)"),
        (
            "named-colour-before-the-own-one",
            "_rgba(material) or colours.get(name)",
            "colours.get(name) or _rgba(material)",
        ),
        ("colours-above-one", "min(max(value, 0.0), 1.0)", "max(value, 0.0)"),
        (
            "cylinder-as-wide-as-long",
            'Cylinder(_numbers(shape, "radius", 1)[0]',
            'Cylinder(_numbers(shape, "length", 1)[0]',
        ),
        ("mesh-without-its-scale", '_vector(shape, "scale", "1 1 1")', "(1.0, 1.0, 1.0)"),
        ("turn-of-a-visual-dropped", '_vector(element, "rpy", "0 0 0")', "(0.0, 0.0, 0.0)"),
    ),
)

_ROBOT = (
    *_faults(
        "robot/build.py",
        "test_model_from_tree.py",
        ("turn-of-an-inertia-dropped", "        if any(row.origin.rpy):", "        if False:"),
        ("inertia-turned-backwards", "tensor = R @ tensor @ R.T", "tensor = R.T @ tensor @ R"),
        (
            "frames-turned-about-moving-axes",
            "if not any(origin.rpy) and not any(origin.xyz):",
            "if not any(origin.xyz):",
        ),
    ),
    *_faults(
        "robot/configurations.py",
        "test_configurations.py::test_joints_of_one_motor_agree_to_single_precision",
        ("couplings-compared-to-a-thousandth", "COUPLING_TOLERANCE = 1e-6", "COUPLING_TOLERANCE = 1e-3"),
        (
            "couplings-of-plain-numbers-compared-to-a-thousandth",
            "abs(mimic.multiplier) > COUPLING_TOLERANCE:",
            "abs(mimic.multiplier) > 1e-3:",
        ),
        (
            "couplings-of-arrays-compared-to-a-thousandth",
            "if np.any(difference > COUPLING_TOLERANCE):",
            "if np.any(difference > 1e-3):",
        ),
    ),
    *_faults(
        "robot/configurations.py",
        "test_model_details.py test_configurations.py",
        (
            "coupling-of-plain-numbers-compared-in-the-driver",
            "- asked) * abs(mimic.multiplier) > COUPLING",
            "- asked) > COUPLING",
        ),
        (
            "offset-of-plain-numbers-dropped",
            "asked = (value - mimic.offset) / mimic.multiplier",
            "asked = value / mimic.multiplier",
        ),
    ),
    *_faults(
        "robot/kinematics.py",
        "test_shared_names.py",
        ("name-of-a-link-loses-to-that-of-a-joint", "self._ids.setdefault(name, index)", "self._ids[name] = index"),
        (
            "shared-name-warned-of-where-both-frames-are-one",
            "if name in moved and moved[name] != link",
            "if name in moved",
        ),
        ("shared-name-warned-of-every-time", "self._ambiguous.pop(name, None)", "self._ambiguous.get(name)"),
    ),
    *_faults(
        "robot/limits.py",
        "test_limits.py::test_violations_are_listed_by_configuration_and_then_by_excess "
        "test_limits.py::test_the_unit_of_a_violation_is_that_of_the_joint_that_is_limited "
        "test_model_details.py::test_joints_with_one_limit_are_drawn_within_a_turn_of_it",
        ("violations-of-least-excess-first", "violation: -violation.excess", "violation: violation.excess"),
        ("violation-in-the-unit-of-the-other-joint", "self.units[column], at, table", "self.units[of], at, table"),
        ("half-a-turn-below-an-upper-limit", "self.upper - 2 * np.pi", "self.upper - np.pi"),
    ),
    *_faults(
        "robot/limits.py",
        "test_limits.py::test_where_a_table_reaches_out_of_the_box_the_box_holds",
        (
            "clamp-ignores-the-box-where-a-table-holds",
            "return np.clip(lower, *box), np.clip(upper, *box)",
            "return lower, upper",
        ),
        ("clamp-ignores-the-lower-box-where-a-table-holds", "np.clip(lower, *box)", "lower"),
        ("clamp-ignores-the-upper-box-where-a-table-holds", "np.clip(upper, *box)", "upper"),
    ),
    *_faults(
        "robot/limits.py",
        "test_limits.py test_configurations.py "
        "test_model_details.py::test_a_joint_outside_its_range_and_its_table_is_reported_once",
        (
            "table-before-its-first-value-answers-with-its-last",
            "        return table.lower[end], table.upper[end]",
            "        return table.lower[-1], table.upper[-1]",
        ),
        (
            "table-after-its-last-value-answers-with-its-first",
            "        return table.lower[end], table.upper[end]",
            "        return table.lower[0], table.upper[0]",
        ),
        (
            "lower-bound-of-a-table-not-interpolated",
            "table.lower[left] + share * (table.lower[right] - table.lower[left])",
            "table.lower[left]",
        ),
        (
            "upper-bound-of-a-table-by-the-lower-one",
            "share * (table.upper[right] - table.upper[left])",
            "share * (table.lower[right] - table.lower[left])",
        ),
        (
            "quick-answer-without-the-tables-of-the-other-joint",
            "if table.joint in values or table.of in values:",
            "if table.joint in values:",
        ),
        (
            "quick-answer-without-tables",
            "for table in self.tables:\n            if table.joint in values",
            "for table in ():\n            if table.joint in values",
        ),
        ("quick-answer-without-upper-limits", "if not lower <= value <= upper:", "if not lower <= value:"),
        (
            "quick-answer-without-the-lower-bound-of-a-table",
            "if not lower - LIMIT_TOLERANCE <= values.get",
            "if not values.get",
        ),
        ("mask-without-tables", "            boxes[..., column] |= outside\n", "            pass\n"),
        ("value-on-a-limit-outside-by-rounding", "LIMIT_TOLERANCE = 1e-6", "LIMIT_TOLERANCE = 0.0"),
        ("limits-with-a-thousandth-to-spare", "LIMIT_TOLERANCE = 1e-6", "LIMIT_TOLERANCE = 1e-3"),
        ("violation-of-box-and-table-counted-twice", "outside & ~boxes[..., column] & named", "outside & named"),
        (
            "table-looked-at-by-its-own-joint-alone",
            " or table.joint in joints or table.of in joints",
            " or table.joint in joints",
        ),
    ),
    *_faults(
        "robot/kinematics.py",
        "test_model.py::test_relative_poses_are_those_of_pinocchio_for_any_number_of_frames "
        "test_model.py::test_poses_are_those_of_pinocchio",
        ("relative-pose-turned-back", "np.matmul(T_reference[:3, :3].T, T[:3]", "np.matmul(T_reference[:3, :3], T[:3]"),
        ("relative-poses-turned-back", "T_reference[..., :3, :3].swapaxes(-1, -2)", "T_reference[..., :3, :3]"),
        ("relative-pose-from-the-root", "            T[:3, 3] -= T_reference[:3, 3]\n", ""),
        ("last-of-few-frames-not-placed", "for frame_id in frame_ids:", "for frame_id in frame_ids[:-1]:"),
        (
            "frames-beyond-a-few-not-placed",
            "pin.framesForwardKinematics(self._model, self.data, q)",
            "pin.forwardKinematics(self._model, self.data, q)",
        ),
        ("selection-transposed", "3 * column + row", "3 * row + column"),
    ),
    *_faults(
        "robot/kinematics.py",
        "test_model.py::test_the_centre_of_mass_is_the_mean_of_the_links "
        "test_model.py::test_a_payload_added_to_the_model_counts "
        "test_model.py::test_the_centre_of_mass_counts_root_and_tip_by_their_masses",
        (
            "centre-of-mass-without-the-root-link",
            "rest * held_x, share * y + rest * held_y, share * z + rest * held_z",
            "0.0, share * y, share * z",
        ),
        ("centres-of-mass-without-the-root-link", "share * centres + rest * held.lever", "share * centres"),
        (
            "mass-of-the-root-link-not-shared",
            "share, rest = moving / total, held.mass / total",
            "share, rest = 1.0, held.mass / total",
        ),
        ("robot-of-a-root-alone-has-no-mass", "if mass <= 0.0:", "if pin.computeTotalMass(self.model) <= 0.0:"),
        (
            "mass-without-the-root-link",
            "float(pin.computeTotalMass(self.model) + self._inertias[0].mass)",
            "float(pin.computeTotalMass(self.model))",
        ),
    ),
    *_faults(
        "robot/configurations.py",
        "test_configurations.py test_limits.py",
        (
            "degrees-of-one-configuration-not-noticed",
            "math.hypot(*q.tolist()) <= TURN:",
            "math.hypot(*q.tolist()) <= 99.0 * TURN:",
        ),
        (
            "degrees-noticed-from-ten-turns-on",
            "-float(joints.min())) <= TURN:",
            "-float(joints.min())) <= 10.0 * TURN:",
        ),
        ("negative-degrees-not-noticed", "max(float(joints.max()), -float(joints.min()))", "float(joints.max())"),
        ("degrees-noticed-within-a-turn", "wrong = (np.abs(joints) > TURN) & (", "wrong = ("),
        (
            "degrees-noticed-inside-wide-limits",
            "(np.abs(joints) > TURN) & ((joints < lower) | (joints > upper)) & self._bounded",
            "(np.abs(joints) > TURN) & self._bounded",
        ),
        ("metres-taken-for-degrees", "self._bounded = self._turning & np.isfinite", "self._bounded = np.isfinite"),
        (
            "joint-with-a-lower-limit-alone-taken-for-bounded",
            " & np.isfinite(limits.lower) & np.isfinite(limits.upper)",
            " & np.isfinite(limits.lower)",
        ),
        (
            "joint-with-an-upper-limit-alone-taken-for-bounded",
            " & np.isfinite(limits.lower) & np.isfinite(limits.upper)",
            " & np.isfinite(limits.upper)",
        ),
    ),
    *_faults(
        "robot/configurations.py",
        "test_limits.py",
        (
            "plain-values-set-into-the-floating-base",
            "{name: self._offset + column for name, column",
            "{name: column for name, column",
        ),
        ("joints-not-named-clamped-too", "slice(None) if joints is None else", "slice(None) if True else"),
        (
            "clamped-columns-of-a-floating-base-shifted",
            "inside[..., self._offset :][..., columns]",
            "inside[..., columns]",
        ),
    ),
    *_faults(
        "robot/configurations.py",
        "test_limits.py",
        ("floating-base-not-checked-on-the-quick-way", "if one and not self._floating and math", "if one and math"),
        (
            "bad-number-blamed-on-the-wrong-joint-of-a-floating-base",
            "column = error.index[-1] - self._offset",
            "column = error.index[-1]",
        ),
    ),
    *_faults(
        "robot/kinematics.py",
        "test_model.py::test_the_centre_of_mass_transforms_with_its_reference",
        ("centre-of-mass-turned-back-in-its-reference", '"...ji,...j->...i"', '"...ij,...j->...i"'),
    ),
)

_MEANING = (
    *_faults(
        "robot/semantics.py",
        "test_semantics.py::test_a_mimic_is_composed_and_turned_round",
        (
            "composed-mimic-without-the-outer-multiplier-in-its-offset",
            "self.offset + self.multiplier * driver.offset",
            "self.offset + driver.offset",
        ),
        ("composed-mimic-of-the-outer-multiplier-alone", "self.multiplier * driver.multiplier", "self.multiplier"),
        ("inverted-mimic-with-the-offset-of-the-other-joint", "-self.offset / self.multiplier)", "-self.offset)"),
        ("inverted-mimic-with-the-wrong-sign", "-self.offset / self.multiplier)", "self.offset / self.multiplier)"),
        (
            "range-of-a-negative-follower-upside-down",
            "ends = sorted(self.multiplier * end + self.offset for end in _ends(lower, upper))",
            "ends = [self.multiplier * end + self.offset for end in _ends(lower, upper)]",
        ),
        (
            "range-of-the-driver-of-a-negative-follower-upside-down",
            "ends = sorted((end - self.offset) / self.multiplier for end in _ends(lower, upper))",
            "ends = [(end - self.offset) / self.multiplier for end in _ends(lower, upper)]",
        ),
        (
            "range-of-a-constant-follower-of-an-unlimited-joint",
            "        if self.multiplier == 0.0:\n            return self.offset, self.offset\n",
            "",
        ),
    ),
    *_faults(
        "robot/semantics.py",
        "test_semantics.py",
        ("table-with-equal-values-taken", "np.diff(self.at) > 0.0", "np.diff(self.at) >= 0.0"),
        (
            "table-with-infinite-bounds-taken",
            "np.isfinite([self.at, self.lower, self.upper])",
            "np.isfinite([self.at])",
        ),
    ),
    *_faults(
        "robot/nao/parameters.py",
        "test_parameters.py::test_a_version_is_not_found_when_it_is_written_otherwise "
        "test_parameters.py::test_a_version_is_found_however_it_is_written",
        (
            "version-names-with-a-third-number",
            '("." not in number and wanted == f"{number}.0")',
            'wanted == f"{number}.0"',
        ),
        ("version-names-in-their-letter-case", "str(name).strip().lower()", "str(name).strip()"),
    ),
    *_faults(
        "robot/nao/model.py",
        "test_semantics.py test_model.py::test_body_values_are_those_of_the_joints_on_a_floating_base_too "
        "test_model.py::test_copies_answer_like_the_original",
        ("body-order-of-a-floating-base-shifted", "self._configurations.joints(q)", "self._configurations.checked(q)"),
        ("vertical-of-resting-postures-forgotten", "v6.REST.get(row.name))", "None)"),
        ("units-of-hands-forgotten", 'if joint.unit == "1"}', "if False}"),
        ("pickled-nao-of-another-version", '"version": self.version}', '"version": "v6"}'),
        ("body-values-clamped-without-being-asked", "strict=True)), limits=limits)", 'strict=True)), limits="clamp")'),
    ),
)

_MATHEMATICS = (
    *_faults(
        "rotations/_quaternions.py",
        "test_quaternions.py",
        ("canonical-sign-blind-to-the-last-component", "nonzero.argmax(axis=-1)", "nonzero[..., :3].argmax(axis=-1)"),
    ),
    *_faults(
        "rotations/_quaternions.py",
        "test_quaternions.py",
        ("slerp-at-a-right-angle-goes-the-other-way", "f.where(_inner(p, q) < 0.0,", "f.where(_inner(p, q) <= 0.0,"),
        (
            "slerp-takes-its-angle-by-arccos",
            "theta = f.atan2(sine, 1.0 + shift)",
            "theta = f.atan2(f.sqrt(f.larger(1.0 - (1.0 + shift) * (1.0 + shift), 0.0)), 1.0 + shift)",
        ),
    ),
    *_faults(
        "rotations/_exponential.py",
        "test_invariants.py",
        ("floor-of-the-logarithm-too-high", "r3 * r3), SMALLEST_NORMAL)", "r3 * r3), 1e-4)"),
    ),
    *_faults(
        "rotations/_elementary.py",
        "test_invariants.py",
        ("floor-of-the-exponential-too-high", "f.larger(square, SMALLEST_NORMAL)", "f.larger(square, 1e-8)"),
    ),
    *_faults(
        "rotations/_quaternions.py",
        "test_invariants.py",
        ("larger-unit-of-the-axis-so-early-that-it-overflows", "tiny = norm < 1e-140", "tiny = norm < 1e-8"),
        ("larger-unit-of-the-axis-too-late", "tiny = norm < 1e-140", "tiny = norm < 1e-200"),
    ),
    *_faults(
        "rotations/_three_angles.py",
        "test_davenport.py",
        ("axes-perpendicular-to-a-hundredth", "_PERPENDICULAR = 1e-9", "_PERPENDICULAR = 1e-2"),
    ),
    *_faults(
        "screws/lines/_line.py",
        "test_lines.py",
        ("lines-coincident-a-million-times-too-easily", "_COINCIDENT = 4.0 *", "_COINCIDENT = 4.0e6 *"),
    ),
    *_faults(
        "screws/lines/_pairs.py",
        "test_lines.py",
        (
            "feet-of-lines-coincident-a-million-times-too-easily",
            "coincident_below: float = 1e-12",
            "coincident_below: float = 1e-6",
        ),
    ),
    *_faults(
        "screws/lines/_pairs.py",
        "test_lines.py",
        ("distance-of-lines-by-the-direction-of-the-first", "mean = 0.5 * (e_b + same_way)", "mean = same_way"),
    ),
    *_faults(
        "screws/lines/_line.py",
        "test_lines.py",
        ("line-meets-the-plane-behind-its-point", "0.0, -height /", "0.0, height /"),
        ("line-parallel-to-a-plane-too-easily", "parallel_below: float = 1e-13", "parallel_below: float = 1e-6"),
    ),
    *_faults(
        "rotations/rank_one.py",
        "test_rank_one.py",
        (
            "rank-one-defective-a-million-times-too-easily",
            "np.abs(cosine) <= _ROUNDING *",
            "np.abs(cosine) <= 1e6 * _ROUNDING *",
        ),
        ("rank-one-singular-a-million-times-too-easily", "blur = _ROUNDING *", "blur = 1e6 * _ROUNDING *"),
        ("rank-one-normal-taken-for-clear-too-easily", "clear = norm(crossed) > 0.1", "clear = norm(crossed) > 1e-15"),
        ("rank-one-normal-taken-for-clear-too-hardly", "clear = norm(crossed) > 0.1", "clear = norm(crossed) > 0.2"),
    ),
)

_MULTIDOF = (
    *_faults(
        "joints/grouping.py",
        "test_grouping.py",
        (
            "coincident-rule-measured-on-axes",
            'np.linalg.norm(centres - centre, axis=1) if rule == "coincident" else distances(centre, centres, axes)',
            "distances(centre, centres, axes)",
        ),
        ("axes-of-a-ball-perpendicular-to-a-hundredth", "_PERPENDICULAR = 0.9e-9", "_PERPENDICULAR = 1e-2"),
        (
            "joints-of-one-motor-merged",
            "if len({node.coupling.joint for node in members}) < len(members) or not",
            "if not",
        ),
    ),
    *_faults(
        "joints/pairs.py",
        "test_grouping.py test_pairs.py",
        ("directions-parallel-to-a-hundredth", "PARALLEL = 1e-6", "PARALLEL = 1e-2"),
    ),
    *_faults(
        "joints/_assembly.py",
        "test_multidof_model.py::test_a_follower_is_as_fast_as_its_driver_makes_it",
        ("follower-as-fast-as-its-driver", "speed = abs(node.coupling.multiplier) * self", "speed = self"),
    ),
    *_faults(
        "joints/_assembly.py",
        "test_multidof_model.py::test_all_frames_velocities_and_the_centre_of_mass_are_the_naos",
        (
            "carrier-of-a-universal-joint-follows-its-second-angle",
            "(self.model.getJointId(group.name), 0, derived=False)",
            "(self.model.getJointId(group.name), 1, derived=False)",
        ),
    ),
    *_faults(
        "joints/_turn_selection.py",
        "test_multidof_whole_turns.py test_multidof_configurations.py",
        ("selection-without-a-tolerance-of-limits", "values - self.upper) - LIMIT_TOLERANCE", "values - self.upper)"),
        (
            "selection-with-a-hundredth-to-spare",
            "values - self.upper) - LIMIT_TOLERANCE",
            "values - self.upper) - 1e-2",
        ),
        (
            "whole-turns-where-limits-hold-one-by-rounding",
            "limits.upper - limits.lower >= TURN - 2.0 * LIMIT_TOLERANCE",
            "limits.upper - limits.lower > TURN",
        ),
        ("angle-not-taken-by-whole-turns-to-its-target", "nearest = nearest_turn(angle, target)", "nearest = angle"),
        ("driver-of-a-winding-follower-within-one-turn", "if not winding and (query", "if True and (query"),
    ),
)

_CROSSCHECK = (
    *_faults(
        "crosscheck/report.py",
        "test_crosscheck.py::test_angles_differ_modulo_a_turn",
        (
            "crosscheck-of-angles-without-modulus",
            "np.abs(error - 2.0 * np.pi * np.round(error / (2.0 * np.pi)))",
            "np.abs(error)",
        ),
    ),
    *_faults(
        "crosscheck/report.py",
        "test_crosscheck.py::test_a_row_that_compared_nothing_is_not_ok "
        "test_crosscheck.py::test_a_report_in_which_a_row_compared_nothing_is_not_ok",
        ("crosscheck-row-without-pairs-counted-as-passed", "self.pairs > 0 and self.worst", "self.worst"),
    ),
    *_faults(
        "crosscheck/rotation_checks.py",
        "test_crosscheck.py::test_exponentials_are_taken_of_vectors_within_and_out_of_half_a_turn",
        (
            "crosscheck-without-rotation-vectors-out-of-half-a-turn",
            "np.where(sample.spread < 0.5, 1.0, 3.0)",
            "np.where(sample.spread < 0.5, 1.0, 1.0)",
        ),
    ),
)

_THIN = _faults(
    "export/inertia.py",
    "test_urdf.py::test_a_sheet_thinner_than_a_millionth_is_made_as_thick "
    "test_urdf.py::test_a_negative_tensor_is_called_negative_and_becomes_a_ball_of_water",
    ("negative-tensor-called-none", ' if moments[0] >= -_SMALLEST * body.mass else "a negative"', ""),
    ("bodies-a-thousand-times-as-thin", "_THINNEST = 1e-6", "_THINNEST = 1e-9"),
)

_BATCH = (
    *_faults(
        "_kernels/operations.py",
        "test_batch_kernels.py",
        (
            "quarter-turns-without-their-third-part",
            "r = r - quarters * spread(m, 2.02226624879595063154e-21)",
            "r = r + spread(m, 0.0)",
        ),
        ("cosine-of-one-term-less", "c = c * z + spread(m, 2.48015872894767294178e-05)", "c = c * z"),
        ("arc-tangent-left-of-the-origin-folded", "spread(m, math.pi) - angle, angle)", "angle, angle)"),
        ("arc-tangent-of-a-steep-direction-not-turned", "spread(m, math.pi / 2.0) - angle, angle)", "angle, angle)"),
    ),
    *_faults(
        "_kernels/operations.py",
        "test_batch_kernels.py::test_exact_half_turns_have_the_canonical_sign",
        (
            "half-turns-with-the-sign-of-their-third-part",
            "where_less(zero, r1 * r1, r1, r2)",
            "where_less(zero, r1 * r1, r2, r2)",
        ),
    ),
    *_faults(
        "_kernels/operations.py",
        "test_batch_kernels.py",
        ("far-angles-left-to-the-polynomials", "if top > far:", "if top < 0:"),
    ),
    *_faults(
        "_kernels/operations.py",
        "test_batch_methods.py",
        ("infinity-in-an-earlier-tile-forgotten", "peak = max(peak, top)", "peak = top"),
    ),
    *_faults(
        "_kernels/program.py",
        "test_batch_kernels.py",
        ("weights-of-a-nanometre-dropped", "_NEGLIGIBLE = 1e-16", "_NEGLIGIBLE = 1e-9"),
        ("register-given-away-before-its-last-reader", "if last[register] == k}", "if last[register] >= k}"),
        ("registers-of-the-result-given-away", "if register >= 0 and register not in wanted]", "if register >= 0]"),
        ("inverse-of-the-base-the-same", "-1.0 if inverse else 1.0", "1.0"),
    ),
    *_faults(
        "_kernels/tree.py",
        "test_batch_kernels.py",
        ("common-joint-of-other-chains", "if len(set(places)) > 1:", "if len(set(places)) > 2:"),
        ("axis-to-the-other-side", "1.0 if self.axis[k] > 0.0 else -1.0", "1.0"),
    ),
    *_faults(
        "_kernels/robot_programs.py",
        "test_batch_kernels.py",
        (
            "jacobian-of-a-sliding-joint-that-follows-another-replaced",
            "linear[v] = builder.combination(linear[v], [(axis, weight)])",
            "linear[v] = builder.combination(builder.zero, [(axis, weight)])",
        ),
        (
            "centre-of-mass-of-a-sliding-follower-without-its-offset",
            "        inside = builder.combination(inside, [(along, share * joint.offset)])\n",
            "",
        ),
        ("own-moment-of-a-body-left-out", "[(_moment(builder, tree, place), 1.0)]", "[]"),
    ),
    *_faults(
        "_kernels/robot_programs.py",
        "test_batch_kernels.py",
        (
            "coriolis-of-a-sliding-joint-once",
            "builder.cross(carried.w, speed, 2.0, dv)",
            "builder.cross(carried.w, speed, 1.0, dv)",
        ),
        ("turning-axis-not-carried-along", "builder.cross(carried.w, speed, 1.0, dw)", "dw"),
        ("point-without-its-centripetal-acceleration", "builder.cross(motion.w, swing, 1.0, ", "("),
        (
            "numbers-of-a-base-not-turned-with-it",
            "builder.cross(w, v, 1.0, dv) if self._accelerated else dv",
            "dv",
        ),
    ),
    *_faults(
        "robot/answers.py",
        "test_batch_kernels.py",
        ("changed-numbers-of-the-model-not-seen", " or self._numbers.changed()", ""),
    ),
    *_faults(
        "robot/build.py",
        "test_batch_kernels.py",
        ("changed-mass-of-the-root-not-seen", "self._first.mass != self._first_mass", "False"),
        ("shifted-mass-not-seen", " or bodies.changed()", ""),
        ("changed-frame-not-seen", "placements.changed() or frames.changed() or", "placements.changed() or"),
    ),
    *_faults(
        "robot/model.py",
        "test_batch_methods.py",
        ("input-of-clamped-configurations-written-over", "            output.check_no_overlap(q)\n", ""),
    ),
    *_faults(
        "robot/answers.py",
        "test_batch_methods.py",
        ("result-written-over-its-input", "if both and np.may_share_memory(self.out, values):", "if False:"),
        ("degrees-of-a-batch-not-noticed", "if not peak <= TURN:", "if False:"),
        ("quaternions-of-a-batch-not-looked-at", "        self._checks.check_base(arrays[0])\n", ""),
    ),
)

_ANALYTIC = (
    *_faults(
        "ik/analytic.py",
        "test_analytic.py",
        ("eaik-given-a-point-on-an-axis", "np.array([0.0731, 0.1137, 0.1913])", "np.zeros(3)"),
        (
            "answers-of-eaik-not-refined",
            "(worst > _PRECISE) & (worst < _REFINED)",
            "(worst > 1.0) & (worst < _REFINED)",
        ),
        ("least-squares-answers-taken-for-solutions", "(answers.errors <= self.tolerance)", "(answers.errors <= 1.0)"),
        ("one-whole-turn-inside-the-limits", "np.maximum(most - least + 1.0, 1.0)", "np.ones(len(u))"),
        ("mimic-joint-without-its-offset", "values[finite] - limb.chain.offset", "values[finite]"),
        ("locked-joint-at-zero", "held.get(driver.joint, 0.0) + driver.offset", "0.0 + driver.offset"),
        ("branch-nearby-taken-for-a-family", "0.4, 1e-13, 1e-10", "0.4, 1e-8, 1e-10"),
        ("solutions-of-the-search-inside-the-limits-dropped", "_together(inside, others)", "inside"),
        ("member-of-a-family-not-the-nearest", "share > 1e-3", "share > 2.0"),
        (
            "branches-not-sorted",
            "inside.where(np.lexsort((self._away(inside), inside.owner)))",
            "inside.where(np.argsort(inside.owner))",
        ),
    ),
)

_FOLLOWING = (
    *_faults(
        "ik/follow_branches.py",
        "test_follow.py",
        (
            "branch-nearest-to-the-sample-before",
            "total = before.cost[:, None] + _sq",
            "total = 0.0 * before.cost[:, None] + _sq",
        ),
        ("family-not-followed-from-the-branch-before", "    references[:, list(first.columns)] = before.values\n", ""),
        ("motion-to-the-end-not-counted", "last = last + _squares(", "last = last + 0.0 * _squares("),
    ),
    *_faults(
        "ik/follow_branches.py",
        "test_follow.py",
        ("jump-that-only-has-to-shrink", "_JUMP_SHRINKAGE = 0.5", "_JUMP_SHRINKAGE = 2.0"),
        ("coarse-step-taken-for-a-jump", "_MAX_DEVIATION = 0.25", "_MAX_DEVIATION = 0.0"),
    ),
    *_faults(
        "ik/follow.py",
        "test_follow.py",
        (
            "share-of-the-speed-limit-upside-down",
            ".max(axis=1, initial=0.0) / speed",
            ".max(axis=1, initial=0.0) * speed",
        ),
        ("segments-taken-at-the-speed-limit", "taken = np.where(short, needed, given)", "taken = needed"),
    ),
    *_faults(
        "ik/follow_limbs.py",
        "test_follow.py",
        ("direction-shifted-with-the-torso", "seen = array if free else array - ", "seen = array - "),
    ),
    *_faults(
        "ik/follow.py",
        "test_follow.py",
        ("way-from-the-reference-not-counted", "start = None if reference is None else references[0]", "start = None"),
        ("quaternion-of-the-base-changes-its-sign", "quat_unwrap(found[:, 3:])", "found[:, 3:]"),
        ("torso-that-gives-way-stays", "np.where(is_found, torso, path.torso)", "path.torso"),
    ),
)

_WHOLE_BODY = (
    *_faults(
        "ik/body_errors.py",
        "test_whole_body.py::test_the_torso_goes_where_both_hips_agree",
        (
            "hips-agree-by-the-wrong-sign",
            "return _change_leg(body, -gap, slope, x)",
            "return _change_leg(body, gap, slope, x)",
        ),
    ),
    *_faults(
        "ik/body_errors.py",
        "test_whole_body.py::test_derivatives_are_those_of_the_errors",
        (
            "gaze-without-the-change-of-its-ratio",
            "        change = -slope * g0\n",
            "        change = 0.0\n",
        ),
    ),
    *_faults(
        "ik/body.py",
        "test_whole_body.py::test_derivatives_are_those_of_the_errors",
        (
            "centre-of-mass-not-turned-with-the-torso",
            "J[2, k] = torso[2, k] + w0 * com[1] - w1 * com[0]",
            "J[2, k] = torso[2, k]",
        ),
    ),
    *_faults(
        "ik/limit_regions.py",
        "test_whole_body.py::test_rows_of_limits_hold_for_the_steps_that_end_inside",
        (
            "upper-bounds-of-tables-not-seen",
            "total += max(0.0, low - value, value - high)",
            "total += max(0.0, low - value)",
        ),
        ("row-of-a-table-without-its-slope", "A[count, of] = -sign * slope", "A[count, of] = 0.0"),
    ),
    *_faults(
        "ik/quadratic_program.py",
        "test_whole_body.py::test_the_quadratic_program_meets_its_optimality_conditions",
        ("active-row-that-pulls-the-wrong-way-kept", "share[i] > 0.0 and force[i]", "share[i] > 1e9 and force[i]"),
    ),
    *_faults(
        "robot/support_polygon.py",
        "test_whole_body.py::test_the_polygon_is_the_hull_of_the_sensors",
        ("distance-outside-by-the-edge-line", "inside, -away))", "inside, inside))"),
    ),
    *_faults(
        "robot/support_polygon.py",
        "test_support_polygon.py",
        ("distance-beyond-a-corner-to-the-edge-line", "axis=-1), 0.0, 1.0)", "axis=-1), -9.0, 9.0)"),
        ("distance-beyond-the-end-of-an-edge-to-its-line", "axis=-1), 0.0, 1.0)", "axis=-1), 0.0, 9.0)"),
        ("points-on-an-edge-are-vertices", "(by - ay) * (x - ax) > 0.0", "(by - ay) * (x - ax) >= 0.0"),
    ),
)

_IK = (
    *_faults(
        "ik/limit_regions.py",
        "test_numeric.py::test_a_target_that_needs_a_joint_below_its_range_names_the_lower_limit",
        (
            "lower-limit-told-as-the-upper-one",
            "np.where(below[rows, joint] > 0.0, self.lower[joint], self.upper[joint])",
            "self.upper[joint]",
        ),
    ),
    *_faults(
        "ik/legs_equations.py",
        "test_legs.py::test_hips_on_the_axis_of_ankle_roll_and_beside_it",
        (
            "hip-of-both-legs-halfway-between-them",
            "hip + gap * (two / (one + two))",
            "hip + gap * 0.5",
        ),
    ),
    *_faults(
        "ik/legs_disagree.py",
        "test_legs.py::test_a_way_as_narrow_as_a_point_is_found "
        "test_legs.py::test_no_hip_yaw_pitch_of_a_fine_scan_turns_the_feet_less",
        (
            "hip-yaw-pitch-with-a-single-value-inside-the-limits-missed",
            "        elif not joined and is_inside(",
            "        elif False and is_inside(",
        ),
        (
            "hip-yaw-pitch-at-limits-of-hip-roll-mirrored",
            "-y * math.cos(rho), ends",
            "y * math.cos(rho), ends",
        ),
    ),
    *_faults(
        "ik/legs_disagree.py",
        "test_legs.py::test_no_hip_yaw_pitch_of_a_fine_scan_turns_the_feet_less",
        ("turns-of-the-feet-not-balanced-between-ends", "if growth < 0.0 <= grows:", "if False:"),
    ),
    *_faults(
        "ik/legs.py",
        "test_legs.py::test_the_torso_gives_way_until_both_feet_are_met "
        "test_legs.py::test_no_smaller_change_of_the_torso_meets_both_feet",
        (
            "torso-moved-as-far-as-it-may",
            "np.argsort(np.abs(values[:count]))",
            "np.argsort(-np.abs(values[:count]))",
        ),
    ),
    *_faults(
        "ik/legs.py",
        "test_legs.py::test_feet_that_cross_are_said_to",
        (
            "feet-that-cross-mistaken",
            "np.asarray(sides[0] < sides[1])",
            "np.asarray(sides[0] > sides[1])",
        ),
    ),
)

_MOTION = (
    *_faults(
        "motion/interpolation.py",
        "test_motion.py",
        (
            "bezier-parameter-bisected-forever-to-the-left",
            "low, high = np.where(miss <= 0.0, u, low)",
            "low, high = np.where(miss < -1.0, u, low)",
        ),
        (
            "key-of-a-joint-belongs-to-the-segment-before",
            'np.searchsorted(times, t, side="right") - 1, 0',
            'np.searchsorted(times, t, side="left") - 1, 0',
        ),
        (
            "handle-before-a-key-taken-for-the-one-after",
            "after, before = handles[:-1, 1], handles[1:, 0]",
            "after, before = handles[:-1, 0], handles[1:, 1]",
        ),
    ),
    *_faults(
        "motion/editing.py",
        "test_editing.py",
        ("mirrored-turns-keep-their-sign", 'kind == "prismatic" else -1.0', 'kind == "prismatic" else 1.0'),
        ("blend-as-long-as-a-motion-refused", "if blend > motion.duration:", "if blend >= motion.duration:"),
    ),
    *_faults(
        "motion/checking.py",
        "test_checking.py::test_overlapping_links_are_found_between_keys_and_only_if_asked "
        "test_checking.py::test_of_very_many_stretches_the_worst_are_listed",
        ("what-is-left-out-below-not-counted", "above.left_out + below.left_out", "above.left_out"),
        ("shallowest-overlaps-listed", "key=lambda row: row.value)[:_MOST", "key=lambda row: -row.value)[:_MOST"),
    ),
    *_faults(
        "motion/checking.py",
        "test_checking.py",
        (
            "speeds-of-one-direction-only",
            'found = _both_sides(curve, "speed", -limit, limit, SPEED_TOLERANCE * limit)',
            'found = _both_sides(curve, "speed", -10.0 * limit, limit, SPEED_TOLERANCE * limit)',
        ),
        (
            "coupled-limits-above-only",
            "((table.upper, 1.0), (table.lower, -1.0))",
            "((table.upper, 1.0),)",
        ),
    ),
    *_faults(
        "motion/mending.py",
        "test_editing.py",
        (
            "joints-clamped-at-their-keys-only",
            "(pieces.values > upper + LIMIT_TOLERANCE)).any(axis=1)",
            "(pieces.values > upper + 9.0)).any(axis=1)",
        ),
    ),
)

_NAOQI = (
    *_faults(
        "naoqi/virtual/body.py",
        "test_virtual_engine.py",
        (
            "right-hip-counts-more-than-the-left",
            "wanted[self._right] = wanted[self._left]\n        command",
            "wanted[self._left] = wanted[self._right]\n        command",
        ),
        (
            "limp-joints-move",
            "np.where(self._stiffness > 0.0, self.max_speed * TICK, 0.0)",
            "np.where(self._stiffness >= 0.0, self.max_speed * TICK, 0.0)",
        ),
    ),
    *_faults(
        "naoqi/virtual/engine.py",
        "test_virtual_engine.py",
        (
            "tasks-overtake-those-that-wait",
            "            if not task.reactive:\n                taken |= task.resources",
            "            if task.reactive:\n                taken |= task.resources",
        ),
        (
            "reactive-tasks-keep-joints-that-others-took",
            "other.give_up(shared)",
            "other.give_up(frozenset())",
        ),
    ),
    *_faults(
        "naoqi/virtual/engine.py",
        "test_virtual_engine.py",
        ("parts-of-a-tick-are-lost", "self._rest = max(0.0, self._rest - count)", "self._rest = 0.0"),
    ),
    *_faults(
        "naoqi/virtual/body.py",
        "test_virtual_engine.py",
        (
            "a-posture-turns-the-robot",
            "self._T_world_sole = change @ self._T_world_sole",
            "self._T_world_sole = self._T_world_sole @ change",
        ),
        (
            "the-standing-foot-slides-under-a-lifted-one",
            "[own, 1 - own] <= LOWER)",
            "[own, 1 - own] <= 9.0)",
        ),
    ),
    *_faults(
        "naoqi/virtual/limb_solvers.py",
        "test_virtual_cartesian.py",
        (
            "the-joints-of-the-standing-leg-are-at-zero",
            "np.where(chain.place < 0, chain.ratio * q[limb.drivers], 0.0)",
            "np.zeros(len(chain.place))",
        ),
    ),
    *_faults(
        "naoqi/virtual/walk.py",
        "test_virtual_walk.py",
        ("a-walk-that-was-stopped-has-arrived", "self.arrived = not self._stopped", "self.arrived = True"),
    ),
    *_faults(
        "naoqi/live.py",
        "test_lola.py",
        ("endless-frames-are-read", "if self._left < 0:", "if self._left < -(10**9):"),
    ),
    *_faults(
        "naoqi/live.py",
        "test_live.py",
        (
            "torso-inclined-to-the-other-side",
            "matrix_from_rpy(np.append(angles, 0.0))",
            "matrix_from_rpy(np.append(-angles, 0.0))",
        ),
    ),
)

_COLLISIONS = (
    *_faults(
        "_kernels/hulls.py",
        "test_collisions.py::test_distances_are_those_of_coal_parallel_crossing_or_degenerate "
        "test_collisions.py::test_the_nearest_point_of_four_corners_in_a_plane_is_that_of_its_nearest_triangle "
        "test_collisions.py::test_an_expanding_polytope_is_opened_in_one_piece "
        "test_collisions.py::test_clearances_are_those_of_a_loop_over_coal "
        "test_collisions.py::test_without_compiled_code_clearances_are_the_same",
        ("corner-that-is-not-needed-kept", "    if along <= 0.0:\n        return a, (i, -1, -1)\n", ""),
        ("side-of-a-triangle-forgotten", "(_of_segment(W, j, k), _of_segment(W, k, i))", "(_of_segment(W, j, k),)"),
        ("flat-simplex-taken-for-a-volume", "if flat or _dot(p, normal)", "if _dot(p, normal)"),
        ("faces-that-go-in-two-pieces", "if _edge(E, edges, F[face, (side + 1) % 3], F[face, side]) >= 0:", "if True:"),
        ("depth-of-the-first-face", "along - depth <= _EXACT or", "True or"),
        ("near-pairs-skipped", "- hulls.width[a] - hulls.width[b]", "- hulls.width[a]"),
    ),
    *_faults(
        "robot/collisions.py",
        "test_collisions.py::test_without_compiled_code_clearances_are_the_same "
        "test_collisions.py::test_contacts_have_points_on_both_shapes_at_their_distance "
        "test_collisions.py::test_random_configurations_can_be_free_of_collisions",
        (
            "points-in-the-other-order",
            "[result.getNearestPoint1(), result.getNearestPoint2()]",
            "[result.getNearestPoint2(), result.getNearestPoint1()]",
        ),
        ("near-shapes-left-out", "between - width[a] - width[b]", "between - width[a]"),
        (
            "random-configurations-that-overlap",
            "q[shapes.clearance(q, 0.0).is_free]",
            "q[shapes.clearance(q, -0.01).is_free]",
        ),
    ),
    *_faults(
        "ik/collision_free.py",
        "test_collision_free.py",
        (
            "lost-target-with-the-first-solution",
            "np.argmax(np.where(exists, found.distance, -np.inf)",
            "np.argmax(exists",
        ),
        (
            "solutions-that-are-not-there-counted",
            "np.count_nonzero(exists & ~keep)",
            "np.count_nonzero(~keep)",
        ),
    ),
    *_faults(
        "ik/whole_body.py",
        "test_collision_free.py",
        (
            "pose-apart-that-misses-its-targets-kept",
            "(other.report[:, STATUS] == REACHED) & (distance >",
            "(distance >",
        ),
        ("posture-pulls-back-to-the-overlap", "plan = plan._replace(posture=0.0)", "pass"),
    ),
    *_faults(
        "ik/follow.py",
        "test_collision_free.py",
        ("limb-that-others-made-room-for-not-reached", "free & (limb.reasons == Reason.COLLISION)", "free & False"),
        (
            "branches-apart-from-the-reference-only",
            "choose(limb, _complete(q, references), ",
            "choose(limb, references, ",
        ),
    ),
    *_faults(
        "ik/follow_branches.py",
        "test_collision_free.py",
        ("overlapping-member-among-free-ones", "if not found.count.any():", "if not found.count[p]:"),
    ),
)

_WORLD = (
    *_faults(
        "robot/ground.py",
        "test_ground.py",
        ("robot-set-down-on-the-first-sole-under-it", "(-own[:, 2] > best)", "(best == -np.inf)"),
        ("body-rolls-back-from-its-centre-of-mass", "side = -(nearest @ across)", "side = (nearest @ across)"),
        (
            "height-from-the-outermost-points-alone",
            "exact: bool = True,\n",
            "exact: bool = False,\n",
        ),
        (
            "straight-down-turned-about-x",
            "rotation_between(-down, _UPRIGHT, axis=[0.0, 1.0, 0.0])",
            "rotation_between(-down, _UPRIGHT, axis=[1.0, 0.0, 0.0])",
        ),
        ("named-soles-lifted-by-other-links", "    if not given:\n        # Of", "    if len(down):\n        # Of"),
    ),
    *_faults(
        "world/balance.py",
        "test_balance.py",
        ("margin-outside-by-the-edge-line", "inside if inside >= 0.0 else -np.sqrt(away)", "inside"),
        ("collinear-corners-in-the-polygon", "if turn > 0.0:", "if turn >= 0.0:"),
        ("other-links-do-not-carry", "for k in np.flatnonzero(others.any(axis=1)).tolist():", "for k in ():"),
        (
            "robot-frame-turned-half-a-turn-where-the-feet-are-on-both-sides-of-pi",
            "np.arctan2(np.sin(turns).sum(axis=-1), np.cos(turns).sum(axis=-1))",
            "turns.mean(axis=-1)",
        ),
        ("feet-frame-as-high-as-their-mean", "places[..., 2].min(axis=-1)", "places[..., 2].mean(axis=-1)"),
    ),
    *_faults(
        "world/cameras.py",
        "test_cameras.py",
        ("tangential-distortion-exchanged", "p1 * ab2 + p2 * (s + 2.0 * a * a)", "p2 * ab2 + p1 * (s + 2.0 * a * a)"),
        ("rational-terms-left-out-of-the-derivative", "- radial * (k4 + s", "- 0.0 * (k4 + s"),
        ("any-root-of-the-distortion-is-taken", "if end > 0.0), default=math.inf", "if end > 1e9), default=math.inf"),
        ("image-begins-at-the-first-centre", "(u >= -0.5)", "(u >= 0.0)"),
    ),
    *_faults(
        "world/camera_ground.py",
        "test_camera_ground.py",
        ("ground-behind-the-camera", "valid = (t > 0.0) & (t < np.inf)", "valid = np.abs(t) < np.inf"),
        (
            "support-turns-without-moving-the-camera",
            "own[..., :3, :] -= np.swapaxes",
            "own[..., :3, :] -= 0.0 * np.swapaxes",
        ),
        ("noise-of-the-pixel-not-squared", "pixel_noise**2", "pixel_noise"),
        (
            "visible-ground-cut-at-the-horizon-alone",
            "-farthest * d[..., 2] - above",
            "-farthest * d[..., 2] - 0.0",
        ),
        ("horizon-with-the-ground-above", "-up[..., 0]], axis=-1)", "up[..., 0]], axis=-1)"),
    ),
    *_faults(
        "world/odometry.py",
        "test_odometry.py",
        ("support-changes-at-half-the-force", "_SHARE = 0.6", "_SHARE = 0.5"),
        (
            "support-changes-to-any-lower-sole",
            "-lower) & (heights[:, before] > -lower)",
            "0.0) & (heights[:, before] > -9.0)",
        ),
        ("gyrometer-and-leg-added", "* steps - by_leg", "* steps + by_leg"),
        ("times-may-stand-still", "(steps <= 0.0,", "(steps < 0.0,"),
    ),
)

_CALIBRATION = (
    *_faults(
        "calibration/unknowns.py",
        "test_jacobians.py",
        ("calibrated-frames-chained-from-the-inside", "for link in reversed(above) if", "for link in above if"),
    ),
    *_faults(
        "calibration/observations.py",
        "test_jacobians.py",
        ("points-turned-the-other-way", "- cross_matrix(points) @", "+ cross_matrix(points) @"),
        ("rotation-vector-changed-as-a-small-one", "right_jacobian_inverse(turn) @ error.J", "error.J"),
    ),
    *_faults(
        "calibration/solve.py",
        "test_calibrate.py::test_outliers_are_named_and_do_not_bend_the_result",
        ("outliers-named-but-kept", "(~_beyond(residuals)).astype(float)", "np.ones(len(residuals))"),
        ("what-noise-explains-called-an-outlier", "_RARE = 1e-6", "_RARE = 1e-2"),
    ),
    *_faults(
        "calibration/solve.py",
        "test_jacobians.py::test_sliding_joints_and_followers_have_derivatives_too",
        ("followers-with-the-whole-offset", "m.multiplier * offsets[m.joint]", "offsets[m.joint]"),
    ),
    *_faults(
        "calibration/design.py",
        "test_calibrate.py::test_the_next_posture_is_that_whose_observation_shrinks_the_uncertainty_most",
        (
            "postures-out-of-sight-tell-something",
            "J[~one.given.camera.sees(seen.residuals * one.given.noise)] = 0.0",
            "J[np.isnan(J)] = 0.0",
        ),
    ),
    *_faults(
        "calibration/starts.py",
        "test_calibrate.py::test_the_pose_of_points_is_found_from_their_rays",
        ("board-behind-the-camera", "M *= np.sign((rays * (local @ M.T)).sum())", "pass"),
    ),
)

MUTATIONS: tuple[Mutation, ...] = (
    *_COMMON,
    *_URDF,
    *_ROBOT,
    *_MEANING,
    *_MATHEMATICS,
    *ROTATIONS,
    *SCREWS,
    *_MULTIDOF,
    *_BATCH,
    *_COLLISIONS,
    *_THIN,
    *_WHOLE_BODY,
    *_IK,
    *_CROSSCHECK,
    *VIEWER,
    *_ANALYTIC,
    *_FOLLOWING,
    *_MOTION,
    *_NAOQI,
    *_WORLD,
    *_CALIBRATION,
)
