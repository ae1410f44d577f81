import type { App } from "./app.ts";
import { resize } from "./scene/studio.ts";
import { THREE, makeScreen } from "./three.ts";

/**
 * The renderer that meshcat draws with. Its canvas has no smoothing of its own, which would cost as much in each frame of a
 * movement: `Smoothing` is for the picture at rest.
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

/** Pictures with smooth edges: drawn with several samples per pixel beside the canvas, and copied onto it. */
export class Smoothing {
  size = new THREE.Vector2();
  // With a stencil the depth has 24 bits; without one 16, which shells a millimetre apart show through.
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
 * meshcat's viewer, adapted: our messages go to the page, all else to meshcat; before each picture the scene is brought up
 * to date, and the studio draws it. meshcat's own loop asks for every frame of the browser; here a change asks for one, and
 * a page in which nothing changes asks for none.
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
  // The pane is smaller where the legend stands under it.
  new ResizeObserver(resizeToPane).observe(pane);
  const handle = viewer.handle_command.bind(viewer);
  viewer.handle_command = (message) => {
    if (message.type === "nao_kin") return page.receive(message);
    handle(message);
    if (message.type === "set_animation") page.player.load(message);
  };
  viewer.render = () => {
    page.stance.settle();
    // What the camera's control does while it is asked, as it coasts, is for the next picture.
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
