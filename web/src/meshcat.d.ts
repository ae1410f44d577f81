// What meshcat puts into the page: three.js, under its own name in @types/three, and its viewer.

import Three = THREE;

declare namespace MeshCat {
  export import THREE = Three;
  const Viewer: new (
    element: HTMLElement,
    animate: boolean,
    renderer: Three.WebGLRenderer,
  ) => import("./types.ts").MeshcatViewer;
}
