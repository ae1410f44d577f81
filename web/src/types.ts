// Types of the data from Python and of the parts of meshcat.
import type * as Three from "three";

// What Python describes is in received.ts, written by scripts/generate_page_messages.py.
export type * from "./received.ts";
export type { Vector } from "./math/rotations.ts";

/** A control of the program in the panel; `source` names the last change of its value. */
export type Control = { name: string; source: string } & (
  | { kind: "button"; value: number }
  | { kind: "slider"; value: number; low: number; high: number; unit: string }
  | { kind: "select"; value: string; options: string[] }
  | { kind: "text"; value: string; edited: boolean }
);

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
  scene_tree: {
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
