import { Motion } from "./motion.ts";
import type { About } from "../types.ts";

type Robot = Pick<About, "coordinates">;

/** Samples a second of a smooth motion in a format that knows straight lines only. */
const SAMPLES = 50;

// What the header of a CSV file cannot hold, or takes for its column of times.
const NO_HEADING = /[[\](),;\t\r\n"]|^\s|\s$|^(time|t)$/i;

const rowsOf = (coordinates: Robot["coordinates"], { values, width, count }: Motion) =>
  Array.from({ length: count }, (_, i) => coordinates.map(({ column }) => values[i * width + column]));

/** A motion that a format cannot hold. */
export class NotWritten extends Error {}

/** The JSON file of nao_kin.motion: every number as it is. */
export function jsonText({ coordinates }: Robot, motion: Motion) {
  const rows = rowsOf(coordinates, motion).map((row) => `  ${JSON.stringify(row)}`);
  return `{"format": "nao_kin motion",
 "units": {"time": "s", "angle": "rad"},
 "interpolation": "${motion.interpolation}",
 "joint_names": ${JSON.stringify(coordinates.map(({ joint }) => joint))},
 "times": ${JSON.stringify(Array.from(motion.times))},
 "keys": [
${rows.join(",\n")}]}
`;
}

/**
 * The CSV file of nao_kin.motion: seconds and radians, hands as shares. It knows straight lines only, so a smooth motion
 * is sampled.
 *
 * @throws {NotWritten} a joint's name that a header cannot hold
 */
export function csvText({ coordinates }: Robot, motion: Motion) {
  for (const { joint } of coordinates) {
    if (NO_HEADING.test(joint)) throw new NotWritten(`CSV cannot hold a joint's name such as “${joint.slice(0, 40)}”`);
  }
  const unit = (joint: string) => (joint === "LHand" || joint === "RHand" ? "1" : "rad");
  const straight = motion.interpolation === "linear" ? motion : sampled(motion);
  const rows = rowsOf(coordinates, straight).map((row, i) => [straight.times[i], ...row].join(","));
  return [["time [s]", ...coordinates.map(({ joint }) => `${joint} [${unit(joint)}]`)].join(","), ...rows, ""].join(
    "\n",
  );
}

export const WRITERS: Record<string, { type: string; write(robot: Robot, motion: Motion): string }> = {
  csv: { type: "text/csv", write: csvText },
  json: { type: "application/json", write: jsonText },
};

/** A motion of straight lines: at the keys as before, between them many samples a second. */
function sampled(motion: Motion) {
  const times = new Set(Array.from(motion.times));
  const steps = Math.floor((motion.end - motion.start) * SAMPLES);
  for (let step = 1; step <= steps; step++) {
    const time = motion.start + step / SAMPLES;
    // No sample beside a key that is there anyway.
    const key = motion.segment(time);
    const near = [key, key + 1].some((i) => Math.abs(motion.times[i] - time) < 1e-3);
    if (!near && time < motion.end) times.add(time);
  }
  const ascending = [...times].sort((a, b) => a - b);
  return Motion.of(
    ascending,
    ascending.map((time) => motion.at(time)),
  );
}
