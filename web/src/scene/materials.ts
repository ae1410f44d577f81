import { isClosed } from "../math/surfaces.ts";
import { THREE } from "../three.ts";
import type { RobotMesh } from "../types.ts";

// Radiance from every direction in a white room: a wide soft box above, a tall one on each side of the camera's default
// place, and a bright strip behind. y is up; the robot looks along x. The edges are already soft, so the map is not blurred.
const ROOM = /* glsl */ `
  varying vec3 vDirection;
  float box(vec3 d, vec3 axis, vec3 across, vec2 size, float edge) {
    float ahead = dot(d, axis);
    vec3 up = cross(axis, across);
    vec2 at = abs(vec2(dot(d, across), dot(d, up)) / max(ahead, 1e-3));
    vec2 soft = 1.0 - smoothstep(size - edge, size + edge, at);
    return ahead > 0.0 ? soft.x * soft.y : 0.0;
  }
  void main() {
    vec3 d = normalize(vDirection);
    float up = 0.5 + 0.5 * d.y;
    vec3 light = mix(vec3(0.16, 0.17, 0.19), vec3(0.34, 0.35, 0.37), smoothstep(0.1, 0.95, up));
    light += 1.05 * vec3(1.0, 0.985, 0.96) * box(d, vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec2(0.62, 0.85), 0.22);
    vec3 left = normalize(vec3(0.55, 0.28, -0.85));
    light += 1.2 * vec3(1.0, 0.98, 0.95) * box(d, left, normalize(vec3(0.85, 0.0, 0.55)), vec2(0.30, 0.62), 0.16);
    vec3 right = normalize(vec3(0.75, 0.18, 0.85));
    light += 0.5 * vec3(0.94, 0.97, 1.0) * box(d, right, normalize(vec3(0.85, 0.0, -0.75)), vec2(0.24, 0.7), 0.16);
    vec3 back = normalize(vec3(-0.95, 0.42, 0.25));
    light += 1.5 * box(d, back, normalize(vec3(0.25, 0.0, 0.95)), vec2(0.75, 0.16), 0.12);
    gl_FragColor = vec4(light, 1.0);
    #include <encodings_fragment>
  }
`;

/** Make the environment map that surfaces reflect and that lights them from all sides: a room computed in a shader. */
export function makeEnvironment(renderer: THREE.WebGLRenderer): THREE.Texture {
  const room = new THREE.Mesh(
    new THREE.SphereGeometry(10, 48, 32),
    new THREE.ShaderMaterial({
      side: THREE.BackSide,
      vertexShader: /* glsl */ `
        varying vec3 vDirection;
        void main() {
          vDirection = position;
          gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        }
      `,
      fragmentShader: ROOM,
    }),
  );
  const scene = new THREE.Scene();
  scene.add(room);
  const generator = new THREE.PMREMGenerator(renderer);
  const { texture } = generator.fromScene(scene);
  generator.dispose();
  room.geometry.dispose();
  room.material.dispose();
  return texture;
}

/**
 * The end of a fragment shader that keeps bright surfaces shaded: above KNEE, radiance approaches 1 instead of being cut
 * off there, in the same proportion for all three colours.
 */
export const SHOULDER = /* glsl */ `
  {
    const float KNEE = 0.6;
    vec3 light = 1.05 * gl_FragColor.rgb;
    float peak = max(light.r, max(light.g, light.b));
    float bent = KNEE + (1.0 - KNEE) * (1.0 - exp((KNEE - peak) / (1.0 - KNEE)));
    gl_FragColor.rgb = peak > KNEE ? light * (bent / peak) : light;
  }
`;

/** The finishes: painted shells; unpainted grey; rubber and other dark surfaces. */
export const FINISHES = {
  gloss: { roughness: 0.3, metalness: 0 },
  satin: { roughness: 0.48, metalness: 0 },
  rubber: { roughness: 0.72, metalness: 0 },
};
// The luminance below which a colour counts as dark, and the chroma from which a colour counts as paint.
const [DARK, PAINT, PALE] = [0.12, 0.25, 0.75];

/**
 * Guess the finish from a colour of a URDF, which does not describe a surface further.
 *
 * @param colour in sRGB
 */
function finishOf({ r, g, b }: { r: number; g: number; b: number }): keyof typeof FINISHES {
  const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const chroma = Math.max(r, g, b) - Math.min(r, g, b);
  if (chroma > PAINT || luminance > PALE) return "gloss";
  return luminance < 2.5 * DARK ? "rubber" : "satin";
}

// The same function for all materials, so that materials of one kind share a compiled shader.
function keepShading(shader: THREE.Shader) {
  shader.fragmentShader = shader.fragmentShader.replace("#include <tonemapping_fragment>", SHOULDER);
}

/**
 * Make a shape of the robot, with the finish that its colour suggests. Colours in a URDF are sRGB; the renderer computes
 * with linear ones.
 *
 * @param geometry that other shapes may share
 * @param colour 0xRRGGBB, in sRGB
 */
export function makeMesh(geometry: THREE.BufferGeometry, colour: number, opacity: number): RobotMesh {
  const color = new THREE.Color(colour);
  const finish = finishOf(color);
  const { attributes, index, userData } = geometry;
  // Back faces are drawn only if the mesh is open or inside out: they double the cost, and their own shadow makes specks.
  userData.isClosed ??= isClosed(attributes.position.array, index?.array ?? null);
  const side = userData.isClosed ? THREE.FrontSide : THREE.DoubleSide;
  color.convertSRGBToLinear();
  const look = { ...FINISHES[finish], color, side, opacity, transparent: opacity < 1 };
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial(look));
  mesh.material.onBeforeCompile = keepShading;
  Object.assign(mesh.userData, { own: color.clone(), opacity, side, finish });
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}
