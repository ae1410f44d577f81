import type { App } from "./app.ts";
import { resize } from "./scene/studio.ts";
import { THREE } from "./three.ts";

/**
 * Make the renderer that meshcat draws with. Its canvas has no antialiasing, which would slow down every frame of a
 * movement; `Smoothing` is used for the picture at rest only.
 */
function makeRenderer() {
  const renderer = new THREE.WebGLRenderer({ alpha: true, antialias: false, powerPreference: "high-performance" });
  renderer.outputEncoding = THREE.sRGBEncoding;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.PCFSoftShadowMap;
  // Shadows only change with the robot, not with the camera.
  renderer.shadowMap.autoUpdate = false;
  return renderer;
}

/** What stands in for the renderer in a browser without WebGL: it draws nothing, and all else of the page works. */
function withoutPicture() {
  const nothing = () => {};
  return {
    ...{ domElement: document.createElement("canvas"), getContext: () => ({ isContextLost: () => true }) },
    ...{ extensions: { has: () => false }, capabilities: {}, shadowMap: {} },
    ...{ setSize: nothing, setPixelRatio: nothing, getPixelRatio: () => 1 },
  } as unknown as ReturnType<typeof makeRenderer>;
}

/**
 * Make meshcat's viewer and adapt it: our messages go to the page and all others to meshcat; before each picture the scene
 * is brought up to date, and the studio draws it. meshcat's own loop asks for every frame of the browser; here only a change
 * asks for one.
 */
export function makeViewer(page: App) {
  const { pane } = page;
  let renderer = withoutPicture();
  try {
    renderer = makeRenderer();
  } catch {
    page.blank(
      "This browser has no WebGL, and so there is no picture. The panel, its numbers and the handles by keyboard work.",
    );
  }
  pane.append(renderer.domElement);
  const viewer = new MeshCat.Viewer(pane, false, renderer);
  let isAwake = false;
  viewer.animate = () => {
    isAwake = false;
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
  const canvas = viewer.renderer.domElement;
  canvas.addEventListener("webglcontextlost", () =>
    page.blank(
      "The browser has lost the graphics card. The picture returns as soon as it is back; if not, reload the page.",
    ),
  );
  // After three.js's own listener.
  canvas.addEventListener("webglcontextrestored", () => page.studio.restore());
  const handle = viewer.handle_command.bind(viewer);
  viewer.handle_command = (message) => {
    if (message.type === "nao_kin") page.receive(message);
    else handle(message);
  };
  viewer.render = () => {
    page.stance.settle();
    // Reset before drawing: while the camera coasts, drawing sets it again, which asks for the next picture.
    viewer.needs_render = false;
    if (!page.robot || viewer.renderer.getContext().isContextLost()) return;
    page.studio.draw();
    page.blank();
    page.labels?.draw();
    page.drawn += 1;
    page.reports.camera();
  };
  return viewer;
}
