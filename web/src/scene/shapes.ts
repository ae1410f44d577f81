import { THREE } from "../three.ts";

/**
 * A material that light does not change.
 *
 * @param order of drawing; from 1 on, the object is visible through objects in front of it
 */
export const flatMaterial = (colour: string, order: number) =>
  new THREE.MeshBasicMaterial({
    color: new THREE.Color(colour).convertSRGBToLinear(),
    transparent: true,
    depthTest: order === 0,
  });

/** An axis of a frame. */
export interface Axis {
  name: string;
  axis: [number, number, number];
  colour: string;
}

export const AXES: Axis[] = [
  { name: "x", axis: [1, 0, 0], colour: "#e0433a" },
  { name: "y", axis: [0, 1, 0], colour: "#2f9e44" },
  { name: "z", axis: [0, 0, 1], colour: "#2f6fe0" },
];

/** Turn a shape along z so that it lies along an axis. */
export function turnAlong(shape: THREE.Object3D, { axis }: Axis) {
  shape.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...axis));
}

/**
 * A rod along z with a head at its end.
 *
 * @param order of drawing, as in `flatMaterial`
 */
export function makeArrow(length: number, radius: number, colour: string, order: number) {
  const arrow = new THREE.Group();
  const material = flatMaterial(colour, order);
  const rod = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, length, 12), material);
  rod.position.z = length / 2;
  const head = new THREE.Mesh(new THREE.ConeGeometry(2.6 * radius, 7 * radius, 16), material);
  head.position.z = length + 3 * radius;
  for (const part of [rod, head]) {
    part.rotation.x = Math.PI / 2;
    part.renderOrder = order;
    arrow.add(part);
  }
  return arrow;
}

/**
 * The axes of a frame: x red, y green, z blue.
 *
 * @param size length of the arrows [m]
 */
export function makeTriad(size: number) {
  const triad = new THREE.Group();
  for (const axis of AXES) {
    const arrow = makeArrow(size, 0.035 * size, axis.colour, 10);
    turnAlong(arrow, axis);
    triad.add(arrow);
  }
  return triad;
}

/** The axis of a joint, along z: turning about it, or sliding along it. */
export function makeScrew(slides: boolean, colour: string, size: number) {
  const screw = new THREE.Group();
  const radius = 0.028 * size;
  const rod = makeArrow(1.5 * size, radius, colour, 10);
  rod.position.z = -0.75 * size;
  screw.add(rod);
  if (slides) {
    const back = makeArrow(0.75 * size, radius, colour, 10);
    back.rotation.x = Math.PI;
    screw.add(back);
  } else {
    const material = flatMaterial(colour, 10);
    const bow = new THREE.Mesh(new THREE.TorusGeometry(0.27 * size, 0.8 * radius, 10, 40, 1.5 * Math.PI), material);
    const head = new THREE.Mesh(new THREE.ConeGeometry(2.2 * radius, 6 * radius, 16), material);
    head.position.set(0, -0.27 * size, 0);
    head.rotation.z = -Math.PI / 2;
    bow.renderOrder = head.renderOrder = 10;
    const turn = new THREE.Group();
    turn.position.z = 0.45 * size;
    turn.add(bow, head);
    screw.add(turn);
  }
  return screw;
}
