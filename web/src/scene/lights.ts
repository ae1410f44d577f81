import { clamp } from "../math/numbers.ts";
import { between, type Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { RobotMesh, Shape, Vector } from "../types.ts";
import type { LinkColours } from "./link_colours.ts";
import { asMark } from "./marks.ts";

// Sizes in radii of the light.
const GLOW = { size: 5.5, lift: 4, opacity: 0.3 };

type Light = Shape & { glow: THREE.Sprite };

/** Lights of the robot, each dark glass that shines in a colour, with a glow around it. */
export class Lights {
  shapes: Map<string, Light> = new Map();

  constructor(
    robot: Robot,
    readonly colours: LinkColours,
  ) {
    for (const shape of robot.meshes.filter(({ light }) => light)) {
      const { link, light } = shape;
      const box = robot.boxIn(
        link,
        robot.meshes.filter((other) => other.link === link),
      );
      // Set into a shell, it throws no shadow beyond it.
      shape.mesh.castShadow = false;
      this.shapes.set(light, { ...shape, glow: makeGlow(shape.mesh, box, robot.nodes[link]) });
    }
  }

  /**
   * Light these, and no others.
   *
   * @param lights red, green and blue from 0 to 1
   */
  show(lights: { name: string; rgb: Vector }[]) {
    const colours = new Map(lights.map(({ name, rgb }) => [name, rgb]));
    for (const [name, shape] of this.shapes) {
      const { mesh, glow } = shape;
      const rgb = colours.get(name);
      mesh.userData.lit = Boolean(rgb);
      const [red, green, blue] = rgb ?? [0, 0, 0];
      mesh.material.emissive.setRGB(red, green, blue).convertSRGBToLinear();
      this.colours.paint(shape);
      const brightest = Math.max(...(rgb ?? [0]));
      glow.visible = brightest > 0;
      glow.userData.strength = brightest;
      if (!rgb || !glow.visible) continue;
      const [r, g, b] = rgb;
      glow.material.color.setRGB(r / brightest, g / brightest, b / brightest).convertSRGBToLinear();
    }
  }
}

/**
 * A soft disc around a light, that faces the camera and fades where the light looks away from it. The light looks away from
 * the middle of its link.
 *
 * @param box around its link
 * @param node of its link
 */
function makeGlow(mesh: RobotMesh, box: THREE.Box3, node: THREE.Object3D) {
  const { Sprite, SpriteMaterial, Vector3 } = THREE;
  const glow = new Sprite(new SpriteMaterial({ map: softDisc(), depthWrite: false, toneMapped: false }));
  if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
  const { center, radius } = mesh.geometry.boundingSphere as THREE.Sphere;
  const toNode = between(mesh, node);
  glow.position.copy(center).applyMatrix4(toNode);
  glow.scale.setScalar(GLOW.size * radius);
  glow.visible = false;
  const outwards = glow.position.clone().sub(box.getCenter(new Vector3())).normalize();
  const [towards, facing] = [new Vector3(), new Vector3()];
  glow.onBeforeRender = (_renderer, _scene, camera) => {
    const { elements } = glow.matrixWorld;
    const place = new Vector3().setFromMatrixPosition(glow.matrixWorld);
    towards.setFromMatrixPosition(camera.matrixWorld).sub(place).normalize();
    facing.copy(outwards).transformDirection(node.matrixWorld);
    glow.material.opacity = GLOW.opacity * glow.userData.strength * clamp(2 * facing.dot(towards), 0, 1);
    // Before the shape that the light is in, and behind what stands before that.
    place.addScaledVector(towards, GLOW.lift * radius);
    [elements[12], elements[13], elements[14]] = place.toArray();
  };
  node.add(asMark(glow));
  return glow;
}

let disc: THREE.Texture | null = null;

/** One texture for all of them. */
function softDisc() {
  if (!disc) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 128;
    const ink = canvas.getContext("2d") as CanvasRenderingContext2D;
    const fade = ink.createRadialGradient(64, 64, 0, 64, 64, 64);
    for (const [at, alpha] of [
      [0, 1],
      [0.25, 0.62],
      [0.5, 0.24],
      [0.75, 0.06],
      [1, 0],
    ]) {
      fade.addColorStop(at, `rgba(255,255,255,${alpha})`);
    }
    ink.fillStyle = fade;
    ink.fillRect(0, 0, 128, 128);
    disc = new THREE.CanvasTexture(canvas);
  }
  return disc;
}
