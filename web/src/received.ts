// Written by scripts/generate_page_messages.py from nao_kin/viewer/messages.py.

import type { Vector } from "./math/rotations.ts";
import type { Control } from "./types.ts";

/** The contents of each kind of message from Python. */
export interface Received {
  geometry: { name: string; geometry: object };
  model: { name: string; about: About };
  robot: { model: string };
  joints: { q: Float64Array; up: Vector | null; source: string };
  clip: {
    times: Float64Array;
    q: Float32Array | Float64Array;
    handles: Float64Array | null;
    fps: number;
    ups: Float32Array | null;
    figure: { object: object; clip: object } | null;
    play: boolean;
    loop: boolean;
  };
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
  images: { names: string[] };
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

export type About = {
  name: string;
  floating: boolean;
  root: string;
  soles: Sole[];
  notes: string[];
  links: Link[];
  places: Place[];
  shapes: ShapeAbout[];
  joints: JointAbout[];
  coordinates: Coordinate[];
  tables: CoupledLimits[];
  chains: Chain[];
  postures: Posture[];
  mirror: Mirrored[];
  naoqi: string[];
  neutral: number[];
  frames: Frame[];
  effectors: string[];
  ends: End[];
  bodies: Body[];
  cameras: Camera[];
  eyes: Eye[];
};
export type Sole = { link: number; corners: number[] };
export type Link = { name: string; title: string; path: string[] };
export type Place = { path: string[]; matrix: number[] };
export type ShapeAbout = {
  link: number;
  geometry: string;
  matrix: number[];
  colour: number;
  opacity: number;
  light: string;
};
export type Driven = { name: string; column: number; multiplier: number; offset: number; follows: string };
export type JointAbout = { link: number; slides: boolean; axis: Vector; pair: string; group: number } & Driven;
export type Coordinate = {
  joint: string;
  column: number;
  lower: number | null;
  upper: number | null;
  velocity: number | null;
  unit: string;
};
export type CoupledLimits = { joint: number; of: number; at: number[]; lower: number[]; upper: number[] };
export type Chain = { title: string; joints: Driven[] };
export type Posture = { name: string; q: number[]; up: Vector | null };
export type Mirrored = { column: number; of: number; multiplier: number; offset: number };
export type Frame = { name: string; link: number };
export type End = { frame: string; point: Vector };
export type Body = { link: number; mass: number; centre: Vector; size: Vector; matrix: number[] };
export type Camera = { name: string; direction: Vector; links: number[] };
export type Eye = { name: string; link: number; horizontal: number | null; vertical: number | null };
