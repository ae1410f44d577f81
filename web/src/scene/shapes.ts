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
  const axes: [string, [number, number, number]][] = [
    ["#e0433a", [0, Math.PI / 2, 0]],
    ["#2f9e44", [-Math.PI / 2, 0, 0]],
    ["#2f6fe0", [0, 0, 0]],
  ];
  for (const [colour, [x, y, z]] of axes) {
    const arrow = makeArrow(size, 0.035 * size, colour, 10);
    arrow.rotation.set(x, y, z);
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
