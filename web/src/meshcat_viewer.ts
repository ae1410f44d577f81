import type { App } from "./app.ts";
import { resize } from "./scene/studio.ts";
import { THREE, makeScreen } from "./three.ts";

/**
 * Make the renderer that meshcat draws with. Its canvas has no antialiasing, which would slow down every frame of a
 * movement; `Smoothing` is used for the picture at rest only.
 */
function makeRenderer(pane: HTMLElement) {
  const renderer = new THREE.WebGLRenderer({ alpha: true, antialias: false, powerPreference: "high-performance" });
  renderer.outputEncoding = THREE.sRGBEncoding;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.PCFSoftShadowMap;
  // Shadows only change with the robot, not with the camera.
  renderer.shadowMap.autoUpdate = false;
  pane.append(renderer.domElement);
  return renderer;
}

/** Draws pictures with smooth edges: off the canvas with several samples per pixel, then copied onto it. */
export class Smoothing {
  size = new THREE.Vector2();
  // With a stencil the depth has 24 bits; without one it has 16, too few for shells that are a millimetre apart.
  target = new THREE.WebGLMultisampleRenderTarget(1, 1, { format: THREE.RGBAFormat, stencilBuffer: true });
  possible: boolean;
  copy;
  camera = new THREE.Camera();

  constructor(readonly renderer: THREE.WebGLRenderer) {
    this.target.texture.encoding = THREE.sRGBEncoding;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.possible = renderer.capabilities.isWebGL2;
    this.target.samples = this.possible ? Math.min(8, gl.getParameter(gl.MAX_SAMPLES)) : 0;
    this.copy = makeScreen(
      "uniform sampler2D picture; varying vec2 vUv; void main() { gl_FragColor = texture2D(picture, vUv); }",
      { picture: { value: this.target.texture } },
    );
  }

  draw(scene: THREE.Scene, camera: THREE.Camera) {
    const { renderer, size, target } = this;
    if (!this.possible) return renderer.render(scene, camera);
    renderer.getDrawingBufferSize(size);
    if (target.width !== size.x || target.height !== size.y) target.setSize(size.x, size.y);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
    renderer.render(this.copy as any, this.camera);
  }
}

/**
 * Make meshcat's viewer and adapt it: our messages go to the page and all others to meshcat; before each picture the scene
 * is brought up to date, and the studio draws it. meshcat's own loop asks for every frame of the browser; here only a change
 * asks for one.
 */
export function makeViewer(page: App) {
  const { pane } = page;
  const viewer = new MeshCat.Viewer(pane, false, makeRenderer(pane));
  let isAwake = false;
  viewer.animate = () => {
    isAwake = false;
    viewer.animator.update();
    if (viewer.needs_render) viewer.render();
  };
  viewer.set_dirty = () => {
    viewer.needs_render = true;
    if (!isAwake) requestAnimationFrame(viewer.animate);
    isAwake = true;
  };
  const resizeToPane = () => resize(viewer, pane.clientWidth, pane.clientHeight);
  viewer.set_3d_pane_size = resizeToPane;
  // The pane becomes smaller when the legend is below it.
  new ResizeObserver(resizeToPane).observe(pane);
  const handle = viewer.handle_command.bind(viewer);
  viewer.handle_command = (message) => {
    if (message.type === "nao_kin") return page.receive(message);
    handle(message);
    if (message.type === "set_animation") page.player.load(message);
  };
  viewer.render = () => {
    page.stance.settle();
    // Reset before drawing: while the camera coasts, drawing sets it again, which asks for the next picture.
    viewer.needs_render = false;
    page.studio.draw();
    viewer.animator.after_render();
    page.speech?.place();
    page.labels?.draw();
    page.video?.add();
    page.drawn += 1;
  };
  return viewer;
}
