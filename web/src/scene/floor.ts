import { THREE, makeScreen } from "../three.ts";
import type { Studio } from "./studio.ts";

// The colours of the floor and of saved pictures; registered, so that the page can read them as colours.
for (const name of ["--floor-lines", "--floor-shade", "--sky", "--haze", "--ground", "--ink", "--panel"]) {
  CSS.registerProperty({ name, syntax: "<color>", inherits: true, initialValue: "white" });
}

/** Give the floor the colours of the styles, for the light or dark theme and for high contrast. */
export function paintFloor({ floor, viewer }: Studio) {
  const styles = getComputedStyle(document.documentElement);
  const { ink, shade, strength } = floor.uniforms;
  ink.value.copy(colourOf(styles, "--floor-lines").colour);
  const { colour, alpha } = colourOf(styles, "--floor-shade");
  shade.value.copy(colour);
  strength.value = alpha;
  for (const name of ["ground", "haze"]) floor.uniforms[name].value.copy(colourOf(styles, `--${name}`).colour);
  viewer.set_dirty();
}

/** Read a registered property of the styles, which browsers give as rgb(…) or rgba(…). */
function colourOf(styles: CSSStyleDeclaration, property: string) {
  const [red, green, blue, alpha = 1] = (styles.getPropertyValue(property).match(/[\d.]+/g) ?? []).map(Number);
  return { colour: new THREE.Color(red / 255, green / 255, blue / 255).convertSRGBToLinear(), alpha };
}

/** The layer of the shapes that are drawn for the contact shadow. */
export const ROBOT_LAYER = 1;
// The size in pixels of the picture from below, and the height above the floor up to which a shape darkens it [m].
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

/** The soft shadow where the robot touches the floor: a blurred picture of the robot from below. */
export class Contact {
  targets;
  /** The transform from the world to the picture. */
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
    this.blur = makeScreen(BLURRED, { picture: { value: null }, step: { value: this.step } });
  }

  get texture() {
    return this.targets[0].texture;
  }

  /** Draw the shadow again. */
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
      // Along x into the second picture, then along y back into the first.
      for (const to of [1, 0]) {
        uniforms.picture.value = this.targets[1 - to].texture;
        this.step.set((to * width) / SIZE, ((1 - to) * width) / SIZE);
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

// The distance between the lines, and between the strong lines, for a small robot [m].
const [STEP, STRONG] = [0.1, 0.5];
// The size of the floor for a small robot [m]: lines end after a metre, shadows here.
const FAR = 1.5;
// The size of the ground for a camera of the robot [m].
const HORIZON = 40;

const VERTEX = /* glsl */ `
  #include <common>
  #include <shadowmap_pars_vertex>
  varying vec2 vAt;
  uniform mat4 toContact;
  varying vec2 vContact;
  void main() {
    vec3 transformedNormal = normalMatrix * normal;
    vec3 transformed = position;
    #include <project_vertex>
    #include <worldpos_vertex>
    #include <shadowmap_vertex>
    vAt = position.xy;
    vContact = (toContact * worldPosition).xy * 0.5 + 0.5;
  }
`;

const LINES = /* glsl */ `
  uniform float scale;
  uniform vec3 ink;
  varying vec2 vAt;

  float lines(float step, float width) {
    vec2 at = vAt / step;
    vec2 pixel = max(fwidth(at), vec2(1e-5));
    vec2 away = abs(fract(at - 0.5) - 0.5);
    vec2 line = smoothstep(0.5 * width * pixel + pixel * 0.5, max(0.5 * width * pixel - pixel * 0.5, 0.0), away);
    // Lines closer together than pixels become their average grey.
    line = mix(line, vec2(0.02), smoothstep(0.25, 0.6, pixel));
    return max(line.x, line.y);
  }
`;

// The lines, the shadow of the key light, and the contact shadow; each covers a share of what is behind.
const FRAGMENT = /* glsl */ `
  #include <common>
  #include <packing>
  #include <lights_pars_begin>
  #include <shadowmap_pars_fragment>
  ${LINES}
  uniform vec2 middle;
  uniform float spread;
  uniform vec3 shade;
  uniform float strength;
  uniform sampler2D contact;
  varying vec2 vContact;

  float shadowed() {
    #if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
      vec3 at = vDirectionalShadowCoord[0].xyz / vDirectionalShadowCoord[0].w;
      if (any(greaterThan(abs(at.xy - 0.5), vec2(0.5)))) return 0.0;
      at.z -= 0.0015;
      vec2 texel = 1.0 / directionalLightShadows[0].shadowMapSize;
      float sum = 0.0;
      #if TAPS > 4
        // Samples on a disc, turned by a different angle in each pixel.
        float turn = 6.2832 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
        for (int i = 0; i < TAPS; i++) {
          float r = 5.0 * sqrt((float(i) + 0.5) / float(TAPS));
          float a = 2.399963 * float(i) + turn;
          sum += step(unpackRGBAToDepth(texture2D(directionalShadowMap[0], at.xy + r * texel * vec2(cos(a), sin(a)))), at.z);
        }
      #else
        for (int i = 0; i < TAPS; i++) {
          vec2 by = 2.5 * texel * vec2(i < 2 ? -1.0 : 1.0, i == 0 || i == 3 ? -1.0 : 1.0);
          sum += step(unpackRGBAToDepth(texture2D(directionalShadowMap[0], at.xy + by)), at.z);
        }
      #endif
      return sum / float(TAPS);
    #else
      return 0.0;
    #endif
  }

  void main() {
    float away = max(0.0, length(vAt - middle) - spread) / scale;
    float fade = 1.0 - smoothstep(0.1, 1.0, away);
    float line = fade * max(0.4 * lines(${STEP} * scale, 1.1), 0.75 * lines(${STRONG} * scale, 1.5));
    float dark = strength * shadowed() * (1.0 - smoothstep(1.2, 1.5, away));
    float touch = 0.0;
    if (all(lessThan(abs(vContact - 0.5), vec2(0.5)))) touch = texture2D(contact, vContact).a;
    float cover = 1.0 - (1.0 - dark) * (1.0 - touch);
    float alpha = 1.0 - (1.0 - line) * (1.0 - cover);
    gl_FragColor = vec4(mix(shade, ink, line / max(line + cover, 1e-4)), alpha);
    #include <encodings_fragment>
  }
`;

// The floor for a camera of the robot: opaque, up to the horizon.
const GROUND = /* glsl */ `
  ${LINES}
  uniform vec3 ground;
  uniform vec3 haze;
  void main() {
    float away = length(vAt) / scale;
    float line = 0.6 * lines(${STRONG} * scale, 2.0) * (1.0 - smoothstep(2.0, 10.0, away));
    gl_FragColor = vec4(mix(mix(ground, ink, line), haze, 0.7 * smoothstep(1.0, 30.0, away)), 1.0);
    #include <encodings_fragment>
  }
`;

/** The floor: a grid that fades with the distance, and the shadows on it. */
export class Floor {
  node = new THREE.Group();
  uniforms;
  fine;
  fast;
  scale = 1;
  plane;
  /** The ground, which is drawn only for the cameras of the robot. */
  ground;

  constructor(contact: { matrix: THREE.Matrix4; texture: THREE.Texture }) {
    const uniforms: Record<string, THREE.IUniform> = {
      ...THREE.UniformsUtils.clone(THREE.UniformsLib.lights),
      scale: { value: 1 },
      ...{
        ink: { value: new THREE.Color() },
        ground: { value: new THREE.Color() },
        haze: { value: new THREE.Color() },
      },
      middle: { value: new THREE.Vector2() },
      spread: { value: 0 },
      shade: { value: new THREE.Color() },
      strength: { value: 0 },
      toContact: { value: contact.matrix },
      contact: { value: contact.texture },
    };
    const material = (taps: number) =>
      new THREE.ShaderMaterial({
        lights: true,
        uniforms,
        defines: { TAPS: taps },
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        transparent: true,
        depthWrite: false,
      });
    this.uniforms = uniforms;
    this.fine = material(20);
    this.fast = material(4);
    this.plane = new THREE.Mesh(new THREE.CircleGeometry(FAR, 48), this.fine);
    this.plane.position.z = -0.001;
    this.plane.receiveShadow = true;
    this.plane.renderOrder = -1;
    this.ground = new THREE.Mesh(
      new THREE.CircleGeometry(HORIZON, 48),
      new THREE.ShaderMaterial({
        uniforms,
        vertexShader:
          "varying vec2 vAt; uniform float scale; void main() { vAt = position.xy * scale; gl_Position = projectionMatrix * modelViewMatrix * vec4(vAt, 0.0, 1.0); }",
        fragmentShader: GROUND,
        depthWrite: false,
      }),
    );
    this.ground.renderOrder = -2;
    this.ground.visible = false;
    this.ground.frustumCulled = false;
    this.node.add(this.plane, this.ground);
  }

  /**
   * Fit the grid to the robot: lines every decimetre for a small robot, every metre for a large one.
   *
   * @param size of the robot [m]
   */
  fit(size: number) {
    this.scale = size < 1.2 ? 1 : size < 6 ? 2.5 : 10;
    this.uniforms.scale.value = this.scale;
    this.cover(new THREE.Box2(new THREE.Vector2(), new THREE.Vector2()));
  }

  /**
   * Reach as far around several robots as around one.
   *
   * @param places the box of the places where they stand, from the place of the page's own robot [m]
   */
  cover(places: THREE.Box2) {
    const { middle, spread } = this.uniforms;
    places.getCenter(middle.value);
    spread.value = places.getSize(new THREE.Vector2()).length() / 2;
    const { x, y } = middle.value;
    this.plane.geometry.dispose();
    this.plane.geometry = new THREE.CircleGeometry(FAR * this.scale + spread.value, 48);
    this.plane.geometry.translate(x, y, 0);
  }

  /** @param way in the world, whose y is up */
  goWith(way: THREE.Matrix4, turn: number) {
    const { position, rotation } = this.node;
    const { x, z } = new THREE.Vector3(position.x, 0, -position.y).applyMatrix4(way);
    position.set(x, -z, 0);
    rotation.z += turn;
  }

  /** Move the grid back to where it was at first. */
  goBack() {
    this.node.position.set(0, 0, 0);
    this.node.rotation.set(0, 0, 0);
  }

  /** Move the grid along with the robot in whole steps of its strong lines, so that it seems endless. */
  goAlong(place: number[]) {
    const step = STRONG * this.scale;
    const [near, aside] = place.map((coordinate) => Math.round(coordinate / step) * step);
    this.node.position.set(near, aside, 0);
  }
}
