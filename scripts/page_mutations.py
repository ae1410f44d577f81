"""Faults of the viewer: in the modules of the page, most of which node tests, and in the program that serves it."""

from __future__ import annotations

from mutation import Mutation, faults as _faults

_CLOSED_FORMS_AND_DRAGS = (
    *_faults(
        "web/src/ik/limb.ts",
        "test_closed_forms.py",
        (
            "page-forgets-the-coupled-limit",
            "    if (!this.table) return true;\n    const [low, high] = this.tableRange",
            "    return true;\n    const [low, high] = this.tableRange",
        ),
    ),
    *_faults(
        "web/src/ik/limb.ts",
        "test_closed_forms.py",
        ("page-sorts-branches-the-other-way", "].distance > branch.distance", "].distance < branch.distance"),
    ),
    *_faults(
        "web/src/ik/leg.ts",
        "test_closed_forms.py",
        (
            "hip-beside-the-axis-of-ankle-roll-taken-for-on-it",
            "const ON_AXIS = 1e-12;",
            "const ON_AXIS = 1e-7;",
        ),
    ),
    *_faults(
        "web/src/ik/leg.ts",
        "test_closed_forms.py",
        (
            "other-foot-turns-the-other-way-round",
            "return Math.atan2(E[3] - E[1], E[0] + E[4]);",
            "return Math.atan2(E[1] - E[3], E[0] + E[4]);",
        ),
    ),
    *_faults(
        "web/src/drag/follow.ts",
        "test_drag.py",
        ("other-foot-carried-along-by-the-shared-motor", "q: other.merged(moved, others)", "q: moved"),
    ),
    *_faults(
        "web/src/drag/pointer.ts",
        "test_drag.py",
        ("camera-turns-while-a-handle-is-held", "    this.page.viewer.controls.enabled = false;\n", ""),
    ),
    *_faults(
        "web/src/pick/facts.ts",
        "test_pointer.py",
        ("any-limb-moved-once-one-is-selected", "return one !== null && one === two;", "return one !== null;"),
    ),
    *_faults(
        "web/src/meshcat_viewer.ts",
        "test_seeing.py",
        ("a-frame-asks-for-the-next", "    isAwake = false;\n", "    isAwake = false;\n    viewer.set_dirty();\n"),
    ),
    *_faults(
        "web/src/drag/limb_drag.ts",
        "test_drag.py",
        ("ghosts-stay-when-a-handle-is-let-go", "    this.ghosts.clear();\n", ""),
    ),
    *_faults(
        "web/src/drag/drag.ts",
        "test_pointer.py",
        ("escape-lets-go-and-gives-nothing-back", "    else stance.set(q, up);\n", ""),
        ("history-not-told-that-it-is-let-go", "    this.announce(false);\n", ""),
    ),
    *_faults(
        "web/src/drag/stops.ts",
        "test_pointer.py",
        ("coupled-partner-of-a-dragged-joint-left-out", "      if (share >= 1) continue;\n", "      continue;\n"),
    ),
    *_faults(
        "web/src/drag/joint_drag.ts",
        "test_pointer.py",
        ("mimic-joints-dragged-without-their-multiplier", ".multiplyScalar(multiplier);", ";"),
    ),
    *_faults(
        "web/src/pick/pick.ts",
        "test_pointer.py",
        ("search-ends-at-the-first-shape", "if (entry > least) break;", "if (least < Infinity) break;"),
    ),
    *_faults(
        "web/src/scene/ghosts.ts",
        "test_drag.py",
        (
            "ghosts-not-looked-at-again-when-the-robot-moves",
            "> SAME);",
            "> SAME || copy.visible);",
        ),
    ),
    *_faults(
        "web/src/scene/footprint.ts",
        "test_seeing.py",
        (
            "edge-of-the-ground-cut-at-the-other-end",
            "inside[k] / (inside[k] - inside[i])",
            "inside[i] / (inside[i] - inside[k])",
        ),
    ),
    *_faults(
        "web/src/stance.ts",
        "test_seeing.py",
        ("ground-in-view-of-the-head-as-it-was", "    eyes.drawGround();\n", ""),
    ),
    *_faults(
        "ik/limbs.py",
        "test_closed_forms.py",
        ("table-of-a-limb-described-with-its-padding", "list(ranges.at[:bends])", "list(ranges.at)"),
    ),
)

_PURE = (
    *_faults(
        "web/src/connection.ts",
        "backoff.test.js",
        ("page-waits-twice-as-long-before-its-first-try", "2 ** failures", "2 ** (failures + 1)"),
    ),
    *_faults(
        "web/src/reports.ts",
        "backoff.test.js",
        ("newest-report-of-a-page-taken-for-an-outdated-one", "Number(number) < newest", "Number(number) <= newest"),
        ("reports-of-other-pages-taken-for-outdated", "who === mine && ", ""),
    ),
    *_faults(
        "web/src/math/numbers.ts",
        "numbers.test.js",
        ("minus-half-a-turn-not-wrapped", "angle <= -Math.PI ?", "angle < -Math.PI ?"),
    ),
    *_faults(
        "web/src/math/rotations.ts",
        "rotations.test.js",
        ("angle-of-half-a-turn-is-no-number-by-rounding", "Math.asin(Math.min(1, half))", "Math.asin(half)"),
    ),
    *_faults(
        "web/src/math/rotations.ts",
        "roll_pitch_yaw.test.js",
        ("pitch-by-the-arcsine", "Math.atan2(-m[2], c * m[0] + s * m[1])", "Math.asin(-m[2])"),
    ),
    *_faults(
        "web/src/math/surfaces.ts",
        "closed.test.js",
        ("solids-inside-out-taken-for-closed", "return volume > 0;", "return volume !== 0;"),
    ),
    *_faults(
        "web/src/math/surfaces.ts",
        "polygon.test.js",
        (
            "outlines-that-share-an-edge-overlap",
            "one[(i + 1) % one.length], p) <= 0)",
            "one[(i + 1) % one.length], p) < 0)",
        ),
    ),
    *_faults(
        "web/src/scene/labels.ts",
        "label_layout.test.js",
        ("labels-forget-the-places-that-they-had", "      anchor.place = place;\n", ""),
    ),
    *_faults(
        "web/src/robot/settling.ts",
        "nearest_posture.test.js",
        ("one-arm-makes-another-posture", "Math.min(Math.abs(value - q[i]), ELSEWHERE)", "Math.abs(value - q[i])"),
    ),
    *_faults(
        "web/src/robot/settling.ts",
        "settling.test.js",
        (
            "body-rolls-over-points-beside-its-edge",
            "clamp(-(a.x * x + a.y * y) / square, 0, 1)",
            "-(a.x * x + a.y * y) / square",
        ),
    ),
    *_faults(
        "web/src/values/link.ts",
        "link.test.js",
        (
            "base-before-the-joints-of-a-link-forgotten",
            "jointsAtZero(about, state.q ?? about.neutral)",
            "jointsAtZero(about, about.neutral)",
        ),
        ("base-without-orientation-admitted", "Math.hypot(...base.slice(3))", "Math.hypot(...base)"),
        (
            "numbers-of-a-link-not-looked-at",
            "parts.length !== count || !parts.every((part) => NUMBER.test(part))",
            "parts.length !== count",
        ),
    ),
    *_faults(
        "web/src/panel/past.ts",
        "values.test.js",
        ("one-step-too-few-can-be-undone", "this.past.length > this.most", "this.past.length >= this.most"),
    ),
    *_faults(
        "web/src/values/units.ts",
        "values.test.js",
        ("numbers-of-any-length-typed", "  if (trimmed.length > LONGEST) return NaN;\n", ""),
    ),
    *_faults(
        "web/src/values/configurations.ts",
        "values.test.js",
        (
            "table-replaces-a-narrower-range",
            "low = Math.max(low, interpolate(table.at, table.lower, q[table.of]));",
            "low = interpolate(table.at, table.lower, q[table.of]);",
        ),
        ("mirror-reads-what-it-has-written", "multiplier * q[of] + offset", "multiplier * image[of] + offset"),
    ),
    *_faults(
        "web/src/values/reading.ts",
        "reading.test.js",
        (
            "pasted-value-of-a-joint-that-follows-scaled-the-wrong-way",
            "(value - joint.offset) / joint.multiplier",
            "value / joint.multiplier - joint.offset",
        ),
        (
            "joints-of-one-motor-may-disagree-when-pasted",
            "if (before && Math.abs(before.value - coordinate) * Math.abs(joint.multiplier) >",
            "if (before && (before.value - coordinate) * joint.multiplier >",
        ),
    ),
    *_faults(
        "web/src/values/literals.ts",
        "reading.test.js",
        ("lines-inside-quotation-marks-not-counted", '      line += found[0].split("\\n").length - 1;\n', ""),
    ),
    *_faults(
        "web/src/values/configurations.ts",
        "reading.test.js",
        (
            "naoqi-told-the-motor-instead-of-the-joint",
            "joint.multiplier * q[joint.column] + joint.offset",
            "q[joint.column]",
        ),
    ),
    *_faults(
        "web/src/pick/facts.ts",
        "pose_numbers.test.js",
        ("quaternion-without-its-sign", "Math.sign(first) / Math.hypot", "1 / Math.hypot"),
    ),
    *_faults(
        "web/src/pick/facts.ts",
        "link_facts.test.js",
        ("frame-of-the-farthest-carrier", "b.path.length - a.path.length", "a.path.length - b.path.length"),
    ),
    *_faults(
        "web/src/scene/quality.ts",
        "quality.test.js",
        ("a-level-that-failed-is-tried-as-soon-again", "Math.min(2 * this.patience, MOST_PATIENCE)", "this.patience"),
    ),
    *_faults(
        "web/src/timeline/motion.ts",
        "samples.test.js",
        ("plots-show-the-joints-that-move-least", "b.range - a.range", "a.range - b.range"),
        (
            "plots-end-before-the-motion",
            "(i === count - 1 ? end : start + ((end - start) * i) / (count - 1))",
            "start + ((end - start) * i) / count",
        ),
    ),
    *_faults(
        "web/src/drag/stops.ts",
        "stops.test.js",
        ("partner-outside-holds-a-joint-that-would-help", "const least = Math.min(0, room(0));", "const least = 0;"),
    ),
    *_faults(
        "web/src/drag/swept_angle.ts",
        "swept_angle.test.js",
        ("places-behind-the-camera-turn-a-joint", "along > 0 && Number.isFinite(along)", "Number.isFinite(along)"),
    ),
    *_faults(
        "web/src/drag/follow.ts",
        "nearest_place.test.js",
        ("search-for-a-place-takes-the-first-way-that-helps", "      .sort((a, b) => a.away - b.away)\n", ""),
    ),
    *_faults(
        "web/src/timeline/motion.ts",
        "motion.test.js",
        ("speed-of-a-smooth-segment-only-at-its-ends", "turn > 0 && turn < 1 ?", "turn > 1 && turn < 1 ?"),
        ("time-of-a-key-belongs-to-the-segment-before", "this.times[i] > time", "this.times[i] >= time"),
    ),
    *_faults(
        "web/src/timeline/motion.ts",
        "motion.test.js",
        (
            "smooth-keys-weighted-by-the-other-side",
            "[before + 2 * after, 2 * before + after]",
            "[2 * before + after, before + 2 * after]",
        ),
    ),
    *_faults(
        "web/src/timeline/key_frames.ts",
        "motion.test.js",
        ("keys-after-the-hour", "clamp(rounded(wanted), 0, LATEST)", "Math.max(rounded(wanted), 0)"),
    ),
    *_faults(
        "web/src/timeline/recorder.ts",
        "motion.test.js",
        ("bound-of-a-recording-forgets-the-width", "Math.floor(MOST_NUMBERS / width)", "MOST_NUMBERS"),
    ),
    *_faults(
        "web/src/timeline/recorder.ts",
        "motion.test.js",
        ("one-key-fewer-than-may-be", "kept.size > most", "kept.size >= most"),
    ),
    *_faults(
        "web/src/timeline/formats.ts",
        "motion_files.test.js",
        ("hand-in-a-file-of-degrees-taken-for-an-angle", "isHand(name) ? 1 : scale.angle", "scale.angle"),
    ),
    *_faults(
        "web/src/timeline/formats.ts",
        "motion_files.test.js",
        (
            "joint-in-a-file-that-follows-scaled-the-wrong-way",
            "(value - joint.offset) / joint.multiplier",
            "(value - joint.offset) * joint.multiplier",
        ),
    ),
    *_faults(
        "web/src/ik/limb.ts",
        "limb.test.js",
        ("whole-turn-of-a-locked-pair-not-tried", "turns = -2; turns < 3", "turns = 0; turns < 2"),
    ),
    *_faults(
        "web/src/ik/limb.ts",
        "limb.test.js",
        (
            "the-other-end-of-a-range-is-blamed",
            "low - value > value - high ? low : high",
            "low - value > value - high ? high : low",
        ),
    ),
    *_faults(
        "web/src/ik/leg.ts",
        "leg.test.js",
        ("second-hip-triple-not-wrapped", "wrapped(2 * this.geometry.kappa - q[1])", "2 * this.geometry.kappa - q[1]"),
    ),
    *_faults(
        "web/src/ik/head.ts",
        "head.test.js",
        ("camera-looks-backwards-at-what-is-behind-it", "if (ahead > along)", "if (ahead > -Infinity)"),
    ),
    *_faults(
        "web/src/ik/head.ts",
        "head.test.js",
        ("neck-beyond-its-own-range-where-the-table-is-wider", ".map((bound) => clamp(bound, low, high))", ""),
    ),
)

_PROGRAM = (
    *_faults(
        "viewer/access.py",
        "test_access.py",
        (
            "token-compared-without-its-length",
            "hmac.compare_digest(token.encode(), self.token.encode())",
            "hmac.compare_digest(token.encode()[: len(self.token)], self.token.encode())",
        ),
        ("hosts-compared-with-their-case", 'name.strip().lower().rstrip(".")', 'name.strip().rstrip(".")'),
        (
            "first-of-two-hosts-believed",
            'if len(hosts) == 1 else None\n        if match is None:\n            return "A request',
            'if hosts else None\n        if match is None:\n            return "A request',
        ),
        ("names-that-end-like-localhost-let-in", 'name.endswith(".localhost")', 'name.endswith("localhost")'),
        (
            "origin-of-another-port-let-in",
            "same = parts.netloc.lower() == host.strip().lower()",
            'same = parts.netloc.lower().partition(":")[0] == host.strip().lower().partition(":")[0]',
        ),
        (
            "loopback-answers-to-any-number",
            "return not self._local and _address(name) is not None",
            "return _address(name) is not None",
        ),
    ),
    *_faults(
        "viewer/access.py",
        "test_access.py",
        ("gzip-sent-to-who-refuses-it", " and not _NO_GZIP.fullmatch(part)", ""),
        ("page-kept-without-asking-again", '"Cache-Control", "no-cache")', '"Cache-Control", "max-age=3600")'),
    ),
    *_faults(
        "viewer/server.py",
        "test_server.py::test_no_more_than_so_many_pages_are_served "
        "test_server.py::test_a_page_that_has_the_scene_is_sent_only_the_rest "
        "test_server.py::test_the_page_of_a_picture_opens_one_socket_without_a_token",
        ("one-page-too-many", "len(self.server._pages) >= _MAX_PAGES", "len(self.server._pages) > _MAX_PAGES"),
        (
            "page-of-an-earlier-program-keeps-what-is-gone",
            "for key in BLANKS.keys() - set(shown):",
            "for key in ():",
        ),
        ("role-of-a-picture-good-for-a-second-page", "        self.access.expected.discard(self.role)\n", ""),
    ),
    *_faults(
        "viewer/messages.py",
        "test_server.py::test_a_robot_of_the_same_name_with_other_lengths_is_another_scene",
        (
            "digest-of-the-scene-forgets-what-is-in-it",
            'b"".join(self._messages.values())',
            'b"".join(self._messages.values())[:0]',
        ),
    ),
    *_faults(
        "viewer/description.py",
        "test_from_python_alone.py",
        ("robot-one-takes-robot-ten-along", '(f"robot {number} ", f"ground', '(f"robot {number}", f"ground'),
    ),
    *_faults(
        "viewer/viewer.py",
        "test_from_python_alone.py",
        (
            "shapes-of-a-robot-leave-with-its-equal",
            "set().union(*(other.parts() for other in self._robots))",
            "set[str]()",
        ),
    ),
    *_faults(
        "viewer/viewer.py",
        "test_from_python_alone.py",
        (
            "third-robot-inside-the-second",
            "self._edge += _GAP + 2.0 * added.reaches_aside",
            "self._edge += _GAP + added.reaches_aside",
        ),
    ),
    *_faults(
        "viewer/viewer.py",
        "test_server.py::test_a_slider_of_one_page_moves_the_robot_here_and_in_the_other_page",
        (
            "report-of-a-page-loses-its-source",
            "self._show_joints(q, up, source)",
            "self._show_joints(q, up)",
        ),
    ),
    *_faults(
        "viewer/handles.py",
        "test_from_python_alone.py",
        (
            "halved-recording-loses-its-first-and-last",
            "indices.append(len(self._times) - 1)",
            "pass",
        ),
        ("robot-that-stood-still-drifts-in-a-recording", "if now - last > 2.0 * step:", "if False:"),
    ),
    *_faults(
        "viewer/targets.py",
        "test_targets.py",
        ("place-of-a-target-shared-with-its-callback", "return np.array(self._T)", "return self._T"),
    ),
    *_faults(
        "viewer/streams.py",
        "test_targets.py",
        (
            "old-points-of-a-plot-stay-in-saved-pages",
            "self._messages.drop(stream.key(stream.sent.popleft()))",
            "stream.sent.popleft()",
        ),
    ),
    *_faults(
        "viewer/shown_scene.py",
        "test_from_python_alone.py",
        ("joints-that-wait-to-be-told-forgotten", "before | dict.fromkeys(joints)", "dict.fromkeys(joints)"),
        (
            "callbacks-share-one-configuration",
            "subscription.callback, q.copy(), tuple(joints)",
            "subscription.callback, q, tuple(joints)",
        ),
    ),
    *_faults(
        "viewer/shown_scene.py",
        "test_scene.py",
        ("coupled-joint-at-zero-not-warned-of", "if row.value != 0.0 or row.of_value != 0.0)", "if row.value != 0.0)"),
    ),
    *_faults(
        "viewer/overlays.py",
        "test_from_python.py::test_what_is_no_shape_is_refused_and_nothing_changes",
        ("corner-behind-the-last-vertex", "corners.max() >= len(rows)", "corners.max() > len(rows)"),
    ),
    *_faults(
        "viewer/meshes.py",
        "test_lights.py",
        ("right-eye-numbered-away-from-the-nose", "math.atan2(-side * (centre[1]", "math.atan2(-(centre[1]"),
    ),
    *_faults(
        "viewer/description.py",
        "test_scene.py",
        (
            "link-fixed-to-another-outshines-it",
            "own = {self._carriers[name]: rgb[name] for name in numbers if name in self._carriers} | rgb",
            "own = rgb | {self._carriers[name]: rgb[name] for name in numbers if name in self._carriers}",
        ),
    ),
    *_faults(
        "viewer/description.py",
        "test_scene.py",
        (
            "mirror-image-with-the-wrong-sign",
            '"multiplier": sign * driver.multiplier',
            '"multiplier": driver.multiplier',
        ),
    ),
    *_faults(
        "viewer/notebook.py",
        "test_notebook.py::test_a_frame_that_opens_gets_what_has_changed_since_it_was_made_and_nothing_else",
        ("frame-is-sent-what-it-has", "if get(key) is not before(key)", "if True"),
    ),
    *_faults(
        "_core/supervisor.py",
        "test_supervisor.py::test_a_folder_is_in_use_by_one_supervisor_at_a_time "
        "test_supervisor.py::test_what_a_program_has_started_is_killed_with_it "
        "test_supervisor.py::test_sigkill_leaves_neither_browser_nor_folder",
        (
            "only-the-program-itself-is-killed",
            "os.killpg(program.pid, signal.SIGKILL)",
            "os.kill(program.pid, signal.SIGKILL)",
        ),
        ("folder-in-use-shared-with-who-tidies-up", "fcntl.LOCK_EX | fcntl.LOCK_NB", "fcntl.LOCK_SH | fcntl.LOCK_NB"),
    ),
)

_IN_A_BROWSER = (
    *_faults(
        "web/src/robot/standing.ts",
        "test_standing.py::test_of_two_soles_that_could_carry_it_the_robot_stands_on_the_one_that_turns_it_less",
        ("robot-set-down-on-the-sole-that-turns-it-most", "b.z - a.z)[0]", "a.z - b.z)[0]"),
    ),
    *_faults(
        "web/src/panel/past.ts",
        "test_panel.py::test_undo_gives_back_a_direction_up_that_was_given",
        ("undo-forgets-the-direction-up", "stance.jump(state.q, state.up);", "stance.jump(state.q, null);"),
    ),
    *_faults(
        "web/src/panel/past.ts",
        "test_panel.py::test_one_history_has_every_change_and_is_reached_from_everywhere",
        ("undo-leaves-the-key-frames", "player.editor.restore(state.edited);", "{}"),
    ),
    *_faults(
        "web/src/panel/keys.ts",
        "test_panel.py::test_undo_works_in_a_number_unless_it_is_being_typed",
        ("undo-of-the-robot-while-a-number-is-typed", 'target.matches("[data-typed]")', "false"),
    ),
    *_faults(
        "web/src/panel/keys.ts",
        "test_panel.py::test_space_plays_and_pauses",
        ("space-plays-where-it-checks-a-box", """'dialog, input:is([type="checkbox"], [type="radio"])'""", '"dialog"'),
    ),
    *_faults(
        "web/src/drag/targets.ts",
        "test_targets_page.py::test_undo_puts_a_target_back_in_a_live_page_and_in_a_saved_one",
        ("moved-target-is-no-step", "    this.note(target, true);\n", ""),
    ),
    *_faults(
        "web/src/drag/drag.ts",
        "test_targets_page.py::test_undo_puts_a_target_back_in_a_live_page_and_in_a_saved_one",
        (
            "escape-gives-back-the-last-part-of-a-hold",
            "if (first.cancel) first.cancel();",
            "if (this.held.gesture.cancel) this.held.gesture.cancel();",
        ),
    ),
    *_faults(
        "web/src/drag/handles.ts",
        "test_drag.py::test_the_read_out_is_always_in_view_and_follows_what_is_clicked",
        ("click-on-a-ring-not-read", "...{ limb, axis, mesh, isLine", "...{ axis, mesh, isLine"),
    ),
    *_faults(
        "web/src/panel/address.ts",
        "test_panel.py::test_a_joint_at_a_coupled_limit_is_still_inside_where_a_link_leads",
        (
            "link-puts-a-joint-beyond-its-limit",
            "page.stance.jump(unrounded(page.robot.about, q, ROUNDING), up ?? null)",
            "page.stance.jump(q, up ?? null)",
        ),
    ),
)

VIEWER: tuple[Mutation, ...] = (*_CLOSED_FORMS_AND_DRAGS, *_PURE, *_PROGRAM, *_IN_A_BROWSER)
