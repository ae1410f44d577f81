import { makeRenderer } from "./scene/renderer.ts";
import { resize } from "./scene/studio.ts";
import type { App } from "./app.ts";

/**
 * meshcat's viewer, adapted: our messages go to the page, all else to meshcat; before each picture the scene is brought up
 * to date, and the studio draws it.
 */
export function makeViewer(app: App) {
  const { pane } = app;
  const viewer = new MeshCat.Viewer(pane, true, makeRenderer(pane));
  const resizeToPane = () => resize(viewer, pane.clientWidth, pane.clientHeight);
  viewer.set_3d_pane_size = resizeToPane;
  // The pane is smaller where the legend stands under it.
  new ResizeObserver(resizeToPane).observe(pane);
  const handle = viewer.handle_command.bind(viewer);
  viewer.handle_command = (message) => {
    if (message.type === "nao_kin") return app.receive(message);
    handle(message);
    if (message.type === "set_animation") app.player.load(message);
  };
  viewer.render = () => {
    app.stance.settle();
    app.studio.draw();
    viewer.animator.after_render();
    viewer.needs_render = false;
    app.speech?.place();
    app.labels?.draw();
    app.video?.add();
    app.drawn += 1;
  };
  return viewer;
}
