import { THREE, makeScreen } from "../three.ts";

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
