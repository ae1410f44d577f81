import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { Refused } from "../src/values/literals.ts";
import { readConfiguration } from "../src/values/reading.ts";
import { FORMATS } from "../src/values/configurations.ts";
import { ABOUT, GEARED, Q } from "./small_robot.js";

// The tests are bundled into web/build, from wherever they are run.
const exported = (name) => readFileSync(new URL(`../../tests/data/motions/${name}.txt`, import.meta.url), "utf8");

const read = (text) => readConfiguration(ABOUT, [1, 0, 0, 0, 0], text);

for (const [name, { write }] of Object.entries(FORMATS)) {
  test(`what is copied as ${name} is read back to the last bit`, () => {
    assert.deepEqual(read(write(ABOUT, Q)).q, Q);
    assert.deepEqual(read(write(ABOUT, Q, false)).q, Q);
  });
}

test("a joint that follows a motor is told, and read, by what it does itself", () => {
  const [begin, q] = [
    [0, 0, 0, 0, 0],
    [0, 0, -0.5, 0, 0],
  ];
  for (const text of ['{"RHip": 0.375}', '{"RHip": 0.375, "LHip": -0.5}', '{"LHip": -0.5, "RHip": 0.375}']) {
    assert.deepEqual(readConfiguration(GEARED, begin, text).q, q, text);
  }
  assert.throws(
    () => readConfiguration(GEARED, begin, '{"RHip": 0.374, "LHip": -0.5}'),
    /RHip and LHip share one motor/,
  );
  const call = FORMATS.setAngles.write(GEARED, q);
  assert.ok(call.includes("[0, 0, -0.5, 0.375, 0, 0]"), call);
  assert.deepEqual(readConfiguration(GEARED, begin, call).q, q);
});

test("each way of writing is recognised", () => {
  const [q, rest] = [0.5, [0, 0, 0, 0]];
  for (const [kind, first, text] of [
    ["JSON", q, '{"HeadYaw": 0.5}'],
    ["JSON", q, '[{"HeadYaw": 0.5}]'],
    ["JSON", q, "{'HeadYaw': .5,}"],
    ["CSV", q, "HeadYaw\n0.5\n"],
    ["CSV", q, 'HeadPitch;"HeadYaw"\r\n0;0.5\r\n\r\n'],
    ["Python", q, "# as yesterday\nq = nao.configuration({\n  'HeadYaw': 0.5,  # left\n})"],
    ["Python", 0, "q = nao.configuration({'HeadPitch': 0})"],
    ["Python", q, "import nao_kin as nk\nangles = {'HeadYaw': 5e-1}\nq = nao.configuration(angles, limits='clamp')"],
    ["setAngles", q, 'motion.setAngles("HeadYaw", 0.5, 0.1)'],
    ["setAngles", q, "names = ['HeadYaw', 'RHip']\nangles = [0.5, 0]\nmotion.setAngles(names, angles, 0.1)"],
    ["setAngles", q, 'session.service("ALMotion").setAngles("HeadYaw", 0.5, 0.1)'.replace('service("ALMotion")', "m")],
    ["setAngles", q, 'motion.setAngles("Body", [0.5, 0, 0, 0, 0, 0], 0.1)'],
    ["setAngles", q, 'm.setAngles("Head", np.array([0.5, 0]), 0.1)'],
    ["setAngles", q, 'm.setAngles(["Head", "Legs", "LArm"], [0.5, 0, 0, 0, 0], 0.1)'],
    ["angleInterpolation", q, 'm.angleInterpolation("Head", [[0.5], [0.0]], 1.0, True)'],
    ["a list", q, "[0.5, 0, 0, 0, 0]"],
    ["a list", q, "0.5, 0.0, .0, 0, 0"],
    ["a list", q, "[0.5, 0, 0, 0, 0, 0]"],
    ["a list", q, "[ 5.e−01  0.  0.\n  0.   0. ]"],
    ["a list", q, "import numpy as np\nq = np.array([0.5, 0., 0.,\n   0, 0], dtype=float)\nprint(q)"],
    ["a list", q, "[np.float64(0.5), np.float64(0.0), 0, 0, 0]"],
    ["a list", q, "array([[0.5, 0., 0., 0., 0.]])"],
    ["angleInterpolation", q, 'm.angleInterpolation(["HeadYaw", "LHip"], [[0.5], [0]], [[1.0], [1.0]], True)'],
    ["angleInterpolation", q, 'm.angleInterpolation(names="HeadYaw", angleLists=[0.5], timeLists=[1], isAbsolute=1)'],
  ]) {
    const found = read(text);
    assert.equal(found.kind, kind, text);
    assert.deepEqual(found.q, [first, ...rest], text);
  }
});

test("what users of NAO write in their scripts is read", () => {
  const [a, b] = [Math.PI / 6, (-20 * Math.PI) / 180];
  for (const [kind, yaw, pitch, text] of [
    ["setAngles", a, 0, 'motionProxy.setAngles("HeadYaw", 30*almath.TO_RAD, 0.1)'],
    ["setAngles", a, 0, "self.motion.setAngles(['HeadYaw'], [30.0 * almath.TO_RAD], 0.2);"],
    ["setAngles", a, b, "motion.setAngles(['HeadYaw', 'HeadPitch'], [math.radians(30), -math.radians(20)], .1)"],
    ["setAngles", a, b, 'm.setAngles("Head", np.deg2rad([30, -20]).tolist(), 0.1)'],
    ["setAngles", a, b, 'm.setAngles("Head", almath.TO_RAD * np.array([30, -20]), 0.1)'],
    [
      "setAngles",
      a,
      b,
      'm.setAngles("HeadYaw", math.radians(30), 0.1)\nm.setAngles("HeadPitch", math.radians(-20), 0.1)',
    ],
    [
      "angleInterpolationWithSpeed",
      a,
      b,
      `from naoqi import ALProxy
if __name__ == "__main__":
    motionProxy = ALProxy("ALMotion", "127.0.0.1", 9559)
    HeadYawAngle = +30.0; HeadPitchAngle = -20  # degrees
    pTargetAngles = [HeadYawAngle, HeadPitchAngle, 0, 0, 0, 0]
    pTargetAngles = np.radians(pTargetAngles)
    try:
        motionProxy.angleInterpolationWithSpeed("Body", pTargetAngles, 0.2)
    except BaseException, err:
        print err`,
    ],
    ["angleInterpolation", a, 0, 'm.angleInterpolation("HeadYaw", 30.0*almath.TO_RAD, 1.0, True)'],
    [
      "angleInterpolationBezier",
      0.5,
      0,
      'm.angleInterpolationBezier(["HeadYaw"], [[1.0]], [[[0.5, [3, -0.3, 0], [3, 0, 0]]]])',
    ],
    [
      "angleInterpolation",
      0.5,
      -0.25,
      'names = list()\ntimes = []\nkeys = list()\n\nnames.append("HeadYaw")\ntimes.append([1])\nkeys.append([0.5])\nnames.append("HeadPitch"); times.append([2]); keys.append([-0.25])',
    ],
    ["Python", 0.5, -0.25, "HeadYaw = 0.5\nHeadPitch = -.25 # rad"],
    ["Python", a, 0, "angles = {}\nangles['HeadYaw'] = math.radians(30)"],
    ["JSON", 0.5, -0.25, "angles = dict(HeadYaw=0.5, HeadPitch=-0.25)"],
    ["JSON", a, 0, '"""Look to the left."""\n{"HeadYaw": 30 * almath.TO_RAD}'],
    ["a list", 0.5, -0.25, "tensor([0.5000, -0.2500, 0.0000, 0, 0], dtype=torch.float64)"],
    ["a list", 0.5, -0.25, "[ 0.5 -0.25  0.\n  0.   0. ]"],
  ]) {
    const found = read(text);
    assert.equal(found.kind, kind, text);
    [yaw, pitch, 0, 0, 0].forEach((value, i) => assert.ok(Math.abs(found.q[i] - value) < 1e-15, text));
  }
});

test("a timeline that Choregraphe exported is a motion", () => {
  const joints = ["HeadYaw", "HeadPitch", "LHand", "RHand", "LHipYawPitch"];
  const about = { ...ABOUT, joints: joints.map((name, column) => ({ ...ABOUT.joints[0], name, column })) };
  const calculated = exported("simplified_export");
  assert.throws(() => readConfiguration(about, Q, calculated), /line 19: expected , or \), found "- 180/);
  const simplified = calculated
    .replace("-(90. - 180)/90, .5 * 1.0", "1.0, .5")
    .replace("math.radians(-9) + 18 * almath.TO_RAD", "9 * almath.TO_RAD");
  assert.deepEqual(readConfiguration(about, Q, simplified).tracks, [
    { name: "HeadPitch", times: [0.52, 0.8, 1.04], values: [-0.39, 0.64, 0] },
    { name: "RHand", times: [0.5, 1], values: [1, 0.5] },
    { name: "LHipYawPitch", times: [2], values: [(9 * Math.PI) / 180] },
  ]);
  const up = exported("bezier_export").split("    def down")[0];
  assert.deepEqual(readConfiguration(about, Q, up).tracks, [
    { name: "HeadYaw", times: [0, 0.6, 1.2], values: [0.5, -0.25, 0.5] },
    { name: "LHand", times: [1.2], values: [0.75] },
  ]);
});

test("a refused text says what was wrong with it, and where", () => {
  for (const [text, says] of [
    ["", /empty text/],
    ["hello", /names without values/],
    ['{"HeadYow": 1}', /line 1: unknown joint "HeadYow" \(nearest: HeadYaw/],
    ['{\n"HeadYaw": 1,\n"HeadYaw": 2}', /line 3: joint "HeadYaw" is given twice/],
    ['{"HeadYaw": "fast"}', /HeadYaw is "fast", expected a finite number/],
    ['{"HeadYaw": NaN}', /HeadYaw is NaN/],
    ['{"HeadYaw": 1e999}', /HeadYaw is a number too large/],
    ['{"HeadYaw": 1e300}', /HeadYaw is 1e\+300 rad, far outside/],
    ['{"HeadYaw": 30}', /looks like degrees/],
    ['{"HeadYaw": null}', /HeadYaw is null/],
    ['{"HeadYaw": [1]}', /HeadYaw is a list/],
    ['{"HeadYaw": 1', /line 1: expected , or }, found the end/],
    ["{HeadYaw: 1}", /line 1: expected a joint's name in quotes, found "HeadYaw: 1}"/],
    ['{"__proto__": 1}', /unknown joint "__proto__"/],
    ['{"constructor": {"x": 1}}', /unknown joint "constructor"/],
    ['[{"HeadYaw": 1}, {"HeadYaw": 2}]', /2 configurations, expected one/],
    ["HeadYaw,HeadPitch\n1\n", /line 2: 1 values, the header names 2 joints/],
    ["HeadYaw\n1\n2\n", /2 rows of values/],
    ['HeadYaw,"HeadPitch\n"\nfast,1', /line 3: HeadYaw is "fast"/],
    ["HeadYaw\nfast\n", /line 2: HeadYaw is "fast"/],
    ['"HeadYaw\n1', /quotation mark that is not closed/],
    ['{"LHip": 0.1, "RHip": 0.2}', /LHip and RHip share one motor/],
    ["m.setAngles(['HeadYaw', 'LHip'], [1], 0.1)", /2 names and 1 angles/],
    ["m.setAngles(names, [1], 0.1)", /without the names/],
    [
      "m.angleInterpolation('HeadYaw', [1, 2], [2, 1], True)",
      /line 1: 2 keys of "HeadYaw", expected .* ascending times/,
    ],
    ["m.angleInterpolation('HeadYaw', [1, 'a'], [1, 2], True)", /2 keys of "HeadYaw", expected numbers/],
    ["m.angleInterpolation(['HeadYaw'], [[1, 2]])", /2 keys of "HeadYaw"/],
    ["x = 1\nHeadYaw = 30", /line 2: HeadYaw is 30 rad, far outside its limits; .* degrees/],
    ["q['HeadYow'] = 0.5", /no joint values found/],
    ["m.setAngles('HeadYaw', 1 + 1, 0.1)", /line 1: expected , or \), found "\+ 1/],
    ["q = [x * 2 for x in q]", /line 1: expected , or \], found "\* 2 for/],
    ["m.setAngles('HeadYaw', a * TO_RAD, 0.1)", /HeadYaw is not a number/],
    ["HeadYaw = 0.5 if ready else 0", /line 1: expected the end of the line, found " if ready/],
    ["m.changeAngles('HeadYaw', 0.5, 0.1)", /a call of "changeAngles"/],
    ["m.angleInterpolation('HeadYaw', 1, 1, False)", /relative angles/],
    ["m.openHand('LHand')", /a call of "openHand", expected one of configuration, setAngles/],
    ["x = [1, 2]", /a list of 2 numbers, expected 5 \(q\) or 6 \(NAOqi's Body\)/],
    ["1, 2, 3", /a list of 3 numbers/],
    ["[0.5, 0, 0, 0 1, 0]", /expected , or \]/],
    ["[0.5, 0, 0, 0, 0, 4000]", /RArm is 4000/],
    ["[0.5, 'a', 0, 0, 0]", /no joint values found/],
    ["m.setAngles('Head', [0.5], 0.1)", /2 names and 1 angles/],
    ["m.setAngles('Hed', [0.5], 0.1)", /unknown joint "Hed"/],
    ["<script>alert(1)</script>", /./],
  ]) {
    assert.throws(
      () => read(text),
      (error) => error instanceof Refused && says.test(error.message),
      text,
    );
  }
});

test("hostile and huge texts are refused at once, in one short line", () => {
  for (const text of [
    "[".repeat(99_000),
    "{".repeat(99_000),
    `{${'"a":1,'.repeat(16_000)}}`,
    `{"${"x".repeat(90_000)}": 1}`,
    `${"x,".repeat(49_000)}\n`,
    `${"1".repeat(90_000)}`,
    `m.setAngles(${"f(".repeat(40_000)}`,
    "\n".repeat(99_000),
    `"${'""'.repeat(49_000)}`,
    "# ".repeat(49_000),
    `{"HeadYaw": ${"9".repeat(90_000)}}`,
    `f${" ".repeat(99_000)}`,
    "a . ".repeat(24_000),
    "-".repeat(99_000),
    `x = [1${",1".repeat(999)}]\n${"y = x * TO_RAD\n".repeat(999)}`,
    `x = []\n${"x.append(x)\n".repeat(999)}x = x * TO_RAD`,
    "[1 ".repeat(33_000),
    "x".repeat(50_000_000),
  ]) {
    const begin = performance.now();
    assert.throws(
      () => read(text),
      (error) => error instanceof Refused && error.message.length < 250,
    );
    assert.ok(performance.now() - begin < 2000, text.slice(0, 10));
  }
});
