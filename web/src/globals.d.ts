// Types of what meshcat puts into the page: three.js, which @types/three calls THREE, and its viewer; and of the styles
// that esbuild imports.

import Three = THREE;

declare namespace MeshCat {
  export import THREE = Three;
  const Viewer: new (
    element: HTMLElement,
    animate: boolean,
    renderer: Three.WebGLRenderer,
  ) => import("./types.ts").MeshcatViewer;
}

declare module "*.css";
