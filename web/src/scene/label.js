// @ts-nocheck
import { THREE } from "../three.js";

// A name that keeps its size on the screen; the names of neighbours go to different corners.
export function makeLabel(text, lift, index = 0) {
  const canvas = document.createElement("canvas");
  let ink = canvas.getContext("2d");
  const font = "600 40px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  ink.font = font;
  canvas.width = Math.min(2000, Math.ceil(ink.measureText(text).width) + 28);
  canvas.height = 60;
  ink = canvas.getContext("2d");
  ink.font = font;
  ink.textBaseline = "middle";
  ink.lineJoin = "round";
  ink.lineWidth = 9;
  ink.strokeStyle = "rgba(255,255,255,0.92)";
  ink.strokeText(text, 14, 32);
  ink.fillStyle = "#1d2433";
  ink.fillText(text, 14, 32);
  const map = new THREE.CanvasTexture(canvas);
  map.encoding = THREE.sRGBEncoding;
  map.minFilter = THREE.LinearFilter;
  const material = new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, toneMapped: false });
  const sprite = new THREE.Sprite(material);
  sprite.scale.set((0.0135 * canvas.width) / canvas.height, 0.0135, 1);
  sprite.center.set(
    ...[
      [0, 0],
      [1, 1],
      [0, 1],
      [1, 0],
    ][index % 4],
  );
  sprite.position.z = 0.25 * lift;
  sprite.renderOrder = 30;
  return sprite;
}
