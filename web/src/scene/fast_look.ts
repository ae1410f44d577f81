import { makeInk } from "../panel/element.ts";
import { THREE, makeScreen } from "../three.ts";
import type { RobotMesh, Shape } from "../types.ts";
import { FINISHES, SHOULDER } from "./materials.ts";

// The size of one ball in pixels, and the share of its radius that is used.
const [CELL, WITHIN] = [64, 0.94];
const NAMES = Object.keys(FINISHES) as (keyof typeof FINISHES)[];
// The balls of a finish: black and white, each in the light and in its shadow.
const COLUMNS = 4;

const VERTEX = /* glsl */ `
  #include <common>
  #include <shadowmap_pars_vertex>
  varying vec3 vNormalView;
  varying vec3 vToEye;
  void main() {
    #include <beginnormal_vertex>
    #include <defaultnormal_vertex>
    #include <begin_vertex>
    #include <project_vertex>
    #include <worldpos_vertex>
    #include <shadowmap_vertex>
    vNormalView = transformedNormal;
    vToEye = -mvPosition.xyz;
  }
`;

const FRAGMENT = /* glsl */ `
  #include <common>
  #include <packing>
  #include <lights_pars_begin>
  #include <shadowmap_pars_fragment>
  uniform vec3 diffuse;
  uniform vec3 emissive;
  uniform sampler2D balls;
  uniform float row;
  varying vec3 vNormalView;
  varying vec3 vToEye;

  float lit() {
    #if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
      vec3 at = vDirectionalShadowCoord[0].xyz / vDirectionalShadowCoord[0].w;
      at.z += directionalLightShadows[0].shadowBias;
      return step(at.z, unpackRGBAToDepth(texture2D(directionalShadowMap[0], at.xy)));
    #else
      return 1.0;
    #endif
  }

  void main() {
    vec3 normal = normalize(vNormalView);
    #ifdef DOUBLE_SIDED
      normal *= gl_FrontFacing ? 1.0 : -1.0;
    #endif
    // The normal in a frame that looks along the ray to this pixel.
    vec3 eye = normalize(vToEye);
    vec3 x = normalize(vec3(eye.z, 0.0, -eye.x));
    vec2 at = ${(0.5 * WITHIN).toFixed(3)} * vec2(dot(x, normal), dot(cross(eye, x), normal)) + 0.5;
    vec2 cell = vec2(at.x / ${COLUMNS}.0, (row + at.y) / ${NAMES.length}.0);
    float share = lit();
    float column = 1.0 / ${COLUMNS}.0;
    vec3 black = mix(texture2D(balls, cell + vec2(column, 0.0)).rgb, texture2D(balls, cell).rgb, share);
    vec3 white = mix(texture2D(balls, cell + vec2(3.0 * column, 0.0)).rgb, texture2D(balls, cell + vec2(2.0 * column, 0.0)).rgb, share);
    gl_FragColor = vec4(mix(black, white, diffuse) + emissive, 1.0);
    ${SHOULDER}
    #include <encodings_fragment>
  }
`;

/**
 * Draws the robot during a movement almost as it looks at rest, for a tenth of the work.
 *
 * With distant lights, and apart from shadows, the shade of a surface depends only on its finish, its colour and its normal
 * relative to the camera. So for each finish, black and white balls are drawn with the true materials, in the key light and
 * in its shadow, and each pixel of the robot looks up the shade of its normal on the balls. The shade is linear in the
 * colour, so every colour lies between black and white.
 */
export class FastLook {
  target;
  scene = new THREE.Scene();
  key;
  intensity: number;
  camera = new THREE.OrthographicCamera(0, COLUMNS, NAMES.length, 0, -2, 2);
  balls = new THREE.Group();
  lit: THREE.Mesh[] = [];
  shaded: THREE.Mesh[] = [];
  seen = new THREE.Quaternion(0, 0, 0, 0);
  materials: Map<THREE.Mesh, THREE.ShaderMaterial> = new Map();

  constructor(
    readonly renderer: THREE.WebGLRenderer,
    readonly world: THREE.Scene,
    key: THREE.DirectionalLight,
  ) {
    const isFloat = renderer.extensions.has("EXT_color_buffer_float");
    this.target = new THREE.WebGLRenderTarget(COLUMNS * CELL, NAMES.length * CELL, {
      type: isFloat ? THREE.HalfFloatType : THREE.UnsignedByteType,
      depthBuffer: true,
    });
    this.scene.quaternion.copy(world.quaternion);
    for (const light of world.children.filter((child) => child instanceof THREE.Light && child !== key)) {
      this.scene.add(light.clone());
    }
    this.key = key.clone();
    this.key.castShadow = false;
    this.intensity = key.intensity;
    this.scene.add(this.key, this.key.target);
    const ball = new THREE.SphereGeometry(0.5, 48, 32);
    NAMES.forEach((name, row) => {
      for (const [i, color] of [0x000000, 0xffffff].entries()) {
        const material = new THREE.MeshStandardMaterial({ ...FINISHES[name], color });
        [this.lit, this.shaded].forEach((meshes, shade) => {
          const mesh = new THREE.Mesh(ball, material);
          mesh.position.set(2 * i + shade + 0.5, row + 0.5, 0);
          meshes.push(mesh);
          this.balls.add(mesh);
        });
      }
    });
    this.scene.add(this.balls);
  }

  /** Draw the scene, with the shades of these shapes looked up on the balls. */
  draw(shapes: Shape[], camera: THREE.Camera) {
    this.look(camera);
    this.drawWith(shapes, camera, (mesh) => (mesh.material.transparent ? mesh.material : this.materialOf(mesh)));
  }

  /** Draw the scene without light: the shades of these shapes are painted, and need neither balls nor shadows. */
  drawPlain(shapes: Shape[], camera: THREE.Camera) {
    const matcap = paintedBall();
    const made: THREE.Material[] = [];
    this.drawWith(shapes, camera, ({ material: { color, opacity, side, transparent } }) => {
      made.push(new THREE.MeshMatcapMaterial({ matcap, color, opacity, side, transparent }));
      return made[made.length - 1];
    });
    matcap.dispose();
    for (const material of made) material.dispose();
  }

  drawWith(shapes: Shape[], camera: THREE.Camera, materialOf: (mesh: RobotMesh) => THREE.Material) {
    const own = shapes.map(({ mesh }) => mesh.material);
    for (const { mesh } of shapes) mesh.material = materialOf(mesh) as any;
    this.renderer.render(this.world, camera);
    shapes.forEach(({ mesh }, i) => (mesh.material = own[i]));
  }

  // Draw the balls again for the next picture.
  forget() {
    this.seen.set(0, 0, 0, 0);
  }

  /** Draw the balls for a camera, unless its orientation is unchanged. */
  look(camera: THREE.Camera) {
    camera.getWorldQuaternion(this.camera.quaternion);
    if (this.camera.quaternion.angleTo(this.seen) < 1e-4) return;
    this.seen.copy(this.camera.quaternion);
    // The balls face the camera; the lights stay fixed in the world.
    this.balls.quaternion.copy(this.scene.quaternion).invert().multiply(this.camera.quaternion);
    this.scene.environment = this.world.environment;
    const { renderer } = this;
    const [autoClear, needsUpdate] = [renderer.autoClear, renderer.shadowMap.needsUpdate];
    renderer.shadowMap.needsUpdate = false;
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.autoClear = false;
    for (const meshes of [this.lit, this.shaded]) {
      for (const mesh of [...this.lit, ...this.shaded]) mesh.visible = meshes.includes(mesh);
      this.key.intensity = meshes === this.lit ? this.intensity : 0;
      renderer.render(this.scene, this.camera);
    }
    renderer.setRenderTarget(null);
    renderer.autoClear = autoClear;
    renderer.shadowMap.needsUpdate = needsUpdate;
  }

  release(shapes: Shape[]) {
    for (const { mesh } of shapes) {
      this.materials.get(mesh)?.dispose();
      this.materials.delete(mesh);
    }
  }

  materialOf(mesh: RobotMesh) {
    const { color, emissive, side } = mesh.material;
    let material = this.materials.get(mesh);
    if (!material) {
      const row = NAMES.indexOf(mesh.userData.finish);
      material = new THREE.ShaderMaterial({
        lights: true,
        uniforms: {
          ...THREE.UniformsUtils.clone(THREE.UniformsLib.lights),
          diffuse: { value: color },
          emissive: { value: emissive },
          balls: { value: this.target.texture },
          row: { value: row },
        },
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
      });
      this.materials.set(mesh, material);
    }
    material.uniforms.diffuse.value = color;
    material.uniforms.emissive.value = emissive;
    material.side = side;
    return material;
  }
}

/** A ball lit from above, on the left, as a texture. */
function paintedBall() {
  const ink = makeInk(CELL, CELL);
  const light = ink.createRadialGradient(0.42 * CELL, 0.3 * CELL, 0, 0.42 * CELL, 0.3 * CELL, 0.75 * CELL);
  light.addColorStop(0, "#ededed");
  light.addColorStop(0.5, "#c8c8c8");
  light.addColorStop(1, "#5a5a5a");
  ink.fillStyle = light;
  ink.fillRect(0, 0, CELL, CELL);
  return new THREE.CanvasTexture(ink.canvas);
}

/** Draws pictures with smooth edges: off the canvas with several samples per pixel, then copied onto it. */
export class Smoothing {
  size = new THREE.Vector2();
  // With a stencil the depth has 24 bits; without one it has 16, too few for shells that are a millimetre apart.
  target = new THREE.WebGLMultisampleRenderTarget(1, 1, { format: THREE.RGBAFormat, stencilBuffer: true });
  possible = this.renderer.capabilities.isWebGL2;
  copy = makeScreen(
    "uniform sampler2D picture; varying vec2 vUv; void main() { gl_FragColor = texture2D(picture, vUv); }",
    { picture: { value: this.target.texture } },
  );
  camera = new THREE.Camera();

  constructor(readonly renderer: THREE.WebGLRenderer) {
    this.target.texture.encoding = THREE.sRGBEncoding;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.target.samples = this.possible ? Math.min(8, gl.getParameter(gl.MAX_SAMPLES)) : 0;
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
