import { THREE } from "../three.ts";
import type { App } from "../app.ts";
import type { Camera } from "../types.ts";

// How far [rad] an arrow key goes round the robot, how much nearer a step is, and how near the camera may come to straight
// above and below.
const TURN = Math.PI / 36;
const NEARER = 1 / 1.15;
const POLE = 0.02;

/** Let the camera be moved by keys while the picture has the focus. */
export function bindViewKeys(app: App) {
  const canvas = app.viewer.renderer.domElement;
  const { name, cameras } = app.robot.about;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", `${name}, seen by a camera that arrow keys, plus, minus and numbers move`);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const does = actionOf(event, app, cameras);
    if (!does) return;
    event.preventDefault();
    does();
  });
}

function actionOf({ key, shiftKey }: KeyboardEvent, app: App, cameras: Camera[]): (() => void) | null {
  const turn = shiftKey ? 3 * TURN : TURN;
  switch (key) {
    case "ArrowLeft":
      return () => orbit(app, -turn, 0, 1);
    case "ArrowRight":
      return () => orbit(app, turn, 0, 1);
    case "ArrowUp":
      return () => orbit(app, 0, -turn, 1);
    case "ArrowDown":
      return () => orbit(app, 0, turn, 1);
    case "+":
    case "=":
      return () => orbit(app, 0, 0, NEARER);
    case "-":
    case "_":
      return () => orbit(app, 0, 0, 1 / NEARER);
    case "0":
    case "Home":
      return () => app.camera(whole(app));
    default: {
      const camera = /^[1-9]$/.test(key) ? cameras[Number(key) - 1] : undefined;
      return camera ? () => app.camera(camera.name) : null;
    }
  }
}

/** The whole-body camera chosen last, or the usual one. */
function whole({ view, robot }: App) {
  const chosen = robot.about.cameras.find(({ name }) => name === view);
  return chosen && chosen.links.length === 0 ? chosen.name : "three-quarter";
}

/** Move the camera about what it looks at. */
function orbit(app: App, around: number, down: number, further: number) {
  const { camera, controls } = app.viewer;
  const place = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
  place.theta += around;
  place.phi = THREE.MathUtils.clamp(place.phi + down, POLE, Math.PI - POLE);
  place.radius = THREE.MathUtils.clamp(place.radius * further, 3 * camera.near, 0.5 * camera.far);
  camera.position.setFromSpherical(place).add(controls.target);
  controls.update();
  app.viewer.set_dirty();
}
