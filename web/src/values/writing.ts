import type { About } from "../types.ts";

const dictionary = ({ coordinates }: About, q: ArrayLike<number>) =>
  `{${coordinates.map(({ joint, column }) => `${JSON.stringify(joint)}: ${q[column]}`).join(", ")}}`;

const names = ({ naoqi }: About) => JSON.stringify(naoqi).replaceAll(",", ", ");

function angles({ naoqi, joints }: About, q: ArrayLike<number>) {
  const values = naoqi.map((name) => {
    const joint = joints.find((candidate) => candidate.name === name);
    return joint ? joint.multiplier * q[joint.column] + joint.offset : 0;
  });
  return `[${values.join(", ")}]`;
}

const field = (text: string) => (/[",;\t\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** The texts that a configuration is copied as. Numbers have all their digits, in rad, m and shares. */
export const FORMATS: Record<
  string,
  {
    title: string;
    hint: string;
    offered(about: About): boolean;
    write(about: About, q: ArrayLike<number>, isInside?: boolean): string;
  }
> = {
  json: {
    title: "JSON",
    hint: "{joint: rad}",
    offered: () => true,
    write: (about, q) => `${dictionary(about, q)}\n`,
  },
  csv: {
    title: "CSV",
    hint: "for nao-kin fk and view",
    offered: () => true,
    write: ({ coordinates }, q) =>
      `${coordinates.map(({ joint }) => field(joint)).join(",")}\n${coordinates.map(({ column }) => q[column]).join(",")}\n`,
  },
  python: {
    title: "Python",
    hint: "q = nao.configuration({…})",
    offered: () => true,
    write: (about, q, isInside = true) =>
      `q = nao.configuration(${dictionary(about, q)}${isInside ? "" : ', limits="ignore"'})\n`,
  },
  setAngles: {
    title: "setAngles",
    hint: "NAOqi, at a tenth of full speed",
    offered: ({ naoqi }) => naoqi.length > 0,
    write: (about, q) => `motion.setAngles(${names(about)}, ${angles(about, q)}, 0.1)\n`,
  },
  angleInterpolation: {
    title: "angleInterpolation",
    hint: "NAOqi, in two seconds",
    offered: ({ naoqi }) => naoqi.length > 0,
    write: (about, q) => `motion.angleInterpolation(${names(about)}, ${angles(about, q)}, 2.0, True)\n`,
  },
};
