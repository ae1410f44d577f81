import { THREE } from "../three.ts";

/** A ring that keeps its size on the screen. */
export function makeKnob() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 96;
  const ink = canvas.getContext("2d") as CanvasRenderingContext2D;
  ink.beginPath();
  ink.arc(48, 48, 34, 0, 2 * Math.PI);
  ink.fillStyle = "rgba(255, 255, 255, 0.78)";
  ink.fill();
  ink.lineWidth = 11;
  ink.strokeStyle = "#1d2433";
  ink.stroke();
  const map = new THREE.CanvasTexture(canvas);
  map.encoding = THREE.sRGBEncoding;
  const material = new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, toneMapped: false });
  const knob = new THREE.Sprite(material);
  knob.renderOrder = 25;
  highlight(knob, false);
  return knob;
}

/** A handle under the pointer is larger and brighter. */
export function highlight(knob: THREE.Sprite, on: boolean) {
  const [size, opacity] = on ? [0.018, 1] : [0.013, 0.75];
  knob.scale.set(size, size, 1);
  knob.material.opacity = opacity;
}

/** A faint line along x, from the camera to its handle. */
export function makeSight(length: number) {
  const ends = [new THREE.Vector3(), new THREE.Vector3(length, 0, 0)];
  const line = new THREE.Line(
    new THREE.BufferGeometry().setFromPoints(ends),
    new THREE.LineDashedMaterial({
      color: 0x1d2433,
      dashSize: 0.008,
      gapSize: 0.006,
      transparent: true,
      opacity: 0.45,
    }),
  );
  line.computeLineDistances();
  return line;
}
