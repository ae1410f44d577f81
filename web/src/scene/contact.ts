import { THREE } from "../three.ts";

/** What is drawn for the contact shadow alone is on this layer. */
export const ROBOT_LAYER = 1;
// Pixels of the picture from below, and metres over the floor within which a shape darkens it.
const [SIZE, HEIGHT] = [128, 0.04];
const BLUR = [2.2, 1.1];

const DARKNESS = /* glsl */ `
  varying float vHeight;
  void main() {
    float near = 1.0 - clamp(vHeight, 0.0, 1.0);
    gl_FragColor = vec4(0.0, 0.0, 0.0, 0.72 * near * near);
  }
`;

const BLURRED = /* glsl */ `
  uniform sampler2D picture;
  uniform vec2 step;
  varying vec2 vUv;
  void main() {
    float sum = 0.0;
    float total = 0.0;
    for (int i = -4; i <= 4; i++) {
      float weight = exp(-0.16 * float(i * i));
      sum += weight * texture2D(picture, vUv + float(i) * step).a;
      total += weight;
    }
    gl_FragColor = vec4(0.0, 0.0, 0.0, sum / total);
  }
`;

/** The soft dark patch where the robot touches the floor: a picture of it from below, blurred. */
export class Contact {
  targets;
  /** From the world to the picture. */
  matrix = new THREE.Matrix4();
  camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -0.005, HEIGHT);
  depth = new THREE.ShaderMaterial({
    vertexShader: /* glsl */ `
        varying float vHeight;
        void main() {
          vec4 at = modelViewMatrix * vec4(position, 1.0);
          vHeight = -at.z / ${HEIGHT.toFixed(4)};
          gl_Position = projectionMatrix * at;
        }
      `,
    fragmentShader: DARKNESS,
    blending: THREE.NoBlending,
    side: THREE.DoubleSide,
  });
  step = new THREE.Vector2();
  blur;

  constructor(readonly renderer: THREE.WebGLRenderer) {
    const target = () => new THREE.WebGLRenderTarget(SIZE, SIZE, { depthBuffer: true });
    this.targets = [target(), target()];
    this.camera.layers.set(ROBOT_LAYER);
    this.blur = new THREE.Mesh(
      new THREE.PlaneGeometry(2, 2),
      new THREE.ShaderMaterial({
        uniforms: { picture: { value: null }, step: { value: this.step } },
        vertexShader: "varying vec2 vUv; void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
        fragmentShader: BLURRED,
        blending: THREE.NoBlending,
        depthTest: false,
        depthWrite: false,
      }),
    );
    this.blur.frustumCulled = false;
  }

  get texture() {
    return this.targets[0].texture;
  }

  /**
   * Draw it anew.
   *
   * @param centre of the robot, in the world of three.js, where y is up
   * @param radius of the robot
   */
  draw(scene: THREE.Scene, centre: THREE.Vector3, radius: number) {
    const { camera, renderer } = this;
    Object.assign(camera, { left: -radius, right: radius, top: radius, bottom: -radius });
    camera.position.set(centre.x, 0, centre.z);
    camera.up.set(1, 0, 0);
    camera.lookAt(centre.x, 1, centre.z);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const needsUpdate = renderer.shadowMap.needsUpdate;
    scene.overrideMaterial = this.depth;
    renderer.shadowMap.needsUpdate = false;
    this.pass(this.targets[0], scene, camera);
    scene.overrideMaterial = null;
    const none = this.blur as any;
    const { uniforms } = this.blur.material;
    for (const width of BLUR) {
      for (const [from, to, x, y] of [
        [0, 1, 1, 0],
        [1, 0, 0, 1],
      ]) {
        uniforms.picture.value = this.targets[from].texture;
        this.step.set((x * width) / SIZE, (y * width) / SIZE);
        this.pass(this.targets[to], none, camera);
      }
    }
    renderer.setRenderTarget(null);
    renderer.shadowMap.needsUpdate = needsUpdate;
  }

  pass(target: THREE.WebGLRenderTarget, scene: THREE.Scene, camera: THREE.Camera) {
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(scene, camera);
  }
}
