// A robot of a head, two hips on one motor and two arms, one of which slides: enough of `about` for what is pure.
const joint = (name, column, multiplier = 1, offset = 0, follows = "") => ({
  name,
  column,
  multiplier,
  offset,
  follows,
});
const coordinate = (name, column, lower, upper, unit = "rad") => ({ joint: name, column, lower, upper, unit });

export const ABOUT = {
  floating: false,
  neutral: [0, 0, 0, 0, 0],
  joints: [
    joint("HeadYaw", 0),
    joint("HeadPitch", 1),
    joint("LHip", 2),
    joint("RHip", 2, 1, 0, "LHip"),
    joint("LArm", 3),
    joint("RArm", 4),
  ],
  coordinates: [
    coordinate("HeadYaw", 0, -2, 2),
    coordinate("HeadPitch", 1, -0.7, 0.5),
    coordinate("LHip", 2, -1, 0.7),
    coordinate("LArm", 3, -0.1, 0.1, "m"),
    coordinate("RArm", 4, null, null),
  ],
  tables: [{ joint: 1, of: 0, at: [-2, 0, 2], lower: [-0.3, -0.7, -0.3], upper: [0.2, 0.5, 0.2] }],
  mirror: [
    { column: 0, of: 0, multiplier: -1, offset: 0 },
    { column: 1, of: 1, multiplier: 1, offset: 0 },
    { column: 2, of: 2, multiplier: 1, offset: 0 },
    { column: 3, of: 4, multiplier: -1, offset: 0 },
    { column: 4, of: 3, multiplier: -1, offset: 0 },
  ],
  chains: [
    { title: "Head", joints: [{ name: "HeadYaw" }, { name: "HeadPitch" }] },
    { title: "LLeg", joints: [{ name: "LHip" }] },
    { title: "RLeg", joints: [{ name: "RHip" }] },
  ],
  naoqi: ["HeadYaw", "HeadPitch", "LHip", "RHip", "LArm", "RArm"],
  cameras: [{ name: "front" }, { name: "three-quarter" }],
  frames: [{ name: "LHand" }, { name: "a, b & c=d" }],
};

export const Q = [0.25, -1e-7, -0.5, 0.05, 1.5];

/** The same robot with a right hip that turns the other way round, half as far and with an offset. */
export const GEARED = {
  ...ABOUT,
  joints: ABOUT.joints.map((one) => (one.name === "RHip" ? { ...one, multiplier: -0.5, offset: 0.125 } : one)),
};
