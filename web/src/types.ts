// Types of the data from Python and of the parts of meshcat.
import type * as Three from "three";
import type { Vector } from "./math/rotations.ts";

/** The robot as nao_kin.viewer.description describes it. A link is an index into `links`, a column an index into q. */
export interface About {
  name: string;
  floating: boolean;
  root: string;
  /** The soles, with x, y, z of their corners in the link, one after another. */
  soles: { link: number; corners: number[] }[];
  notes: string[];
  links: { name: string; path: string[] }[];
  /** The constant pose of each node in its parent, column by column. */
  places: { path: string[]; matrix: number[] }[];
  shapes: ShapeAbout[];
  joints: JointAbout[];
  coordinates: Coordinate[];
  tables: { joint: number; of: number; at: number[]; lower: number[]; upper: number[] }[];
  chains: { title: string; joints: Driven[] }[];
  postures: Posture[];
  /** The mirror image of q: q[column] becomes multiplier · q[of] + offset. Empty for a robot without two sides. */
  mirror: { column: number; of: number; multiplier: number; offset: number }[];
  /** The joints in the order of NAOqi's Body; empty for a robot that is no NAO. */
  naoqi: string[];
  neutral: number[];
  frames: { name: string; link: number }[];
  effectors: string[];
  /** The links that move as one; `size` and `matrix` are the edges and the pose in the link of a box of the same inertia. */
  bodies: { link: number; mass: number; centre: Vector; size: Vector; matrix: number[] }[];
  cameras: Camera[];
  eyes: Eye[];
}

/** The geometry, pose and colour of one shape of a link. */
interface ShapeAbout {
  link: number;
  /** Name of the geometry. */
  geometry: string;
  /** The pose in the link, column by column. */
  matrix: number[];
  /** 0xRRGGBB, in sRGB. */
  colour: number;
  opacity: number;
  /** The name of the light if the shape is one, else empty. */
  light: string;
}

/** A camera of the robot, which looks along x of its link, and its field of view [rad], null if unknown. */
export interface Eye {
  name: string;
  link: number;
  horizontal: number | null;
  vertical: number | null;
}

export type { Vector };

/** Value of a joint = multiplier · q[column] + offset; `follows` names the joint that it mimics, or is empty. */
export interface Driven {
  name: string;
  column: number;
  multiplier: number;
  offset: number;
  follows: string;
}

export interface JointAbout extends Driven {
  link: number;
  slides: boolean;
  axis: Vector;
  pair: string;
  group: number;
}

/** One number of q; a limit that does not exist is null, also that of its speed [1/s]. */
export interface Coordinate {
  joint: string;
  column: number;
  lower: number | null;
  upper: number | null;
  velocity: number | null;
  unit: string;
}

interface Posture {
  name: string;
  q: number[];
  up: Vector | null;
}

/** A control of the program in the panel; `source` names the last change of its value. */
export type Control = { name: string; source: string } & (
  | { kind: "button"; value: number }
  | { kind: "slider"; value: number; low: number; high: number; unit: string }
  | { kind: "select"; value: string; options: string[] }
  | { kind: "text"; value: string; edited: boolean }
);

/** A camera preset: the direction to look from, and the links to look at with all that they carry. */
export interface Camera {
  name: string;
  direction: Vector;
  links: number[];
}

/** A shape of the robot and the link that it belongs to. */
export interface Shape {
  mesh: RobotMesh;
  link: number;
  light: string;
}

export type RobotMesh = Three.Mesh<Three.BufferGeometry, Three.MeshStandardMaterial>;

/** A message from Python: its kind and its content. */
export interface Message {
  type: "nao_kin";
  kind: string;
  [content: string]: any;
}

/** The parts of meshcat's viewer that the page uses. */
export interface MeshcatViewer {
  scene: Three.Scene;
  camera: Three.PerspectiveCamera;
  renderer: Three.WebGLRenderer;
  controls: {
    enabled: boolean;
    maxDistance: number;
    target: Three.Vector3;
    update(): void;
    addEventListener(type: string, listener: () => void): void;
  };
  animator: Animator;
  scene_tree: {
    children: Record<string, { object: Three.Object3D } | undefined>;
    find(path: string[]): { object: Three.Object3D };
    delete(path: string[]): void;
  };
  needs_render: boolean;
  animate(): void;
  handle_command(message: any): void;
  handle_command_bytearray(message: Uint8Array): void;
  hide_background(): void;
  render(): void;
  set_3d_pane_size(): void;
  set_dirty(): void;
  set_property(path: string[], property: string, value: unknown): void;
}

/** The part of meshcat that plays clips. */
interface Animator {
  actions: Three.AnimationAction[];
  mixer: Three.AnimationMixer;
  duration: number;
  playing: boolean;
  time: number;
  after_render(): void;
  update(): void;
  clear(): void;
  display_progress(time: number): void;
  pause(): void;
  play(): void;
  seek(time: number): void;
}
