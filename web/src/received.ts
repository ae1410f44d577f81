// Written by scripts/generate_page_messages.py from nao_kin/viewer/messages.py.

import type { About, Control, Vector } from "./types.ts";

/** The contents of each kind of message from Python. */
export interface Received {
  geometry: { name: string; geometry: object };
  model: { name: string; about: About };
  robot: { model: string };
  joints: { q: Float64Array; up: Vector | null; source: string };
  still: object;
  hulls: {
    links: number[];
    counts: number[];
    radii: number[];
    parts: [number, number][];
    points: Float32Array;
    pairs: Uint16Array;
  };
  robot_added: { robot: number; name: string; model: string; opacity: number };
  robot_joints: { robot: number; q: Float64Array; up: Vector | null };
  robot_removed: { robot: number };
  robots: { robots: number[] };
  shown: { shown: Record<string, boolean>; source: string };
  frames: { names: string[]; size: number | null };
  ghosts: { qs: Float64Array; count: number; opacity: number; first: number | null };
  targets: { targets: { name: string; matrix: number[]; point: boolean; source?: string }[] };
  shapes: { shapes: { link: number; geometry: object; matrix: number[] }[] };
  controls: { controls: Control[] };
  colours: {
    robot: number;
    links: { link: number; rgb: Vector }[];
    stops: Vector[] | null;
    label: string;
    low: string;
    high: string;
  };
  lights: { lights: { name: string; rgb: Vector }[] };
  reach: {
    cells: Uint16Array | null;
    values?: Uint16Array;
    frame?: string;
    voxel?: number;
    first?: Vector;
    cut?: { axis: "x" | "y" | "z"; place: number } | null;
    stops?: Vector[] | null;
    label?: string;
    low?: string;
    high?: string;
  };
  extra: {
    name: string;
    shape: "points" | "mesh" | "line" | "arrow" | "label";
    frame: string | null;
    width?: number;
    text?: string;
    positions?: Float32Array;
    size?: number;
    colour?: Vector;
    colours?: Uint8Array | null;
    parts?: { geometry: object; colour: Vector; opacity: number }[];
  };
  extras: { names: string[] };
  image: { camera: string; format: string; data: Uint8Array };
  images: { cameras: string[] };
  plot: {
    name: string;
    lines: string[];
    run: number;
    first: number;
    margins: boolean;
    times: Float64Array;
    values: Float64Array;
  };
  plots: { names: string[] };
  camera: { camera: string | number[] };
  capture: { id: string; camera: string | number[]; width: number; height: number };
  film: { id: string; camera: string | number[]; width: number; height: number; fps: number; form: "webm" | "zip" };
  version: { version: string };
  complete: object;
}
