// @ts-nocheck
import { THREE } from "../three.js";

// Metres between the grid's strong lines, for a small robot; and how far a robot goes before the camera does, as a share
// of its size.
const GRID_STEP = 0.5;
const SLACK = 0.15;

// Light, floor, materials and cameras: how the scene looks.
export class Studio {
  constructor(viewer) {
    this.viewer = viewer;
    viewer.hide_background();
    viewer.renderer.outputEncoding = THREE.sRGBEncoding;
    // Shadows only change with the robot, not with the camera.
    viewer.renderer.shadowMap.autoUpdate = false;
    for (const name of ["Grid", "Axes", "Lights"]) viewer.set_property([name], "visible", false);

    const scene = viewer.scene;
    scene.add(new THREE.HemisphereLight(0xffffff, 0xaab4c6, 0.5));
    this.key = new THREE.DirectionalLight(0xfffaf2, 0.52);
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(2048, 2048);
    this.key.shadow.bias = -0.0004;
    this.key.shadow.normalBias = 0.004;
    const fill = new THREE.DirectionalLight(0xeaf1ff, 0.16);
    fill.position.set(-0.6, -1.6, 0.7);
    const rim = new THREE.DirectionalLight(0xffffff, 0.22);
    rim.position.set(-1.5, 0.5, 1.4);
    scene.add(this.key, this.key.target, fill, rim);
    this.floor = this.makeFloor();
    scene.add(this.floor);
    this.place = [0, 0];
  }

  makeFloor() {
    const floor = new THREE.Group();
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 1024;
    const ink = canvas.getContext("2d");
    const step = canvas.width / 20;
    ink.strokeStyle = "#8d99ad";
    for (let i = 0; i <= 20; i++) {
      ink.globalAlpha = i % 5 === 0 ? 0.75 : 0.4;
      ink.lineWidth = i % 5 === 0 ? 2 : 1.5;
      ink.beginPath();
      ink.moveTo(i * step, 0);
      ink.lineTo(i * step, canvas.height);
      ink.moveTo(0, i * step);
      ink.lineTo(canvas.width, i * step);
      ink.stroke();
    }
    // The grid fades into the distance.
    const fade = ink.createRadialGradient(512, 512, 60, 512, 512, 512);
    fade.addColorStop(0, "rgba(0,0,0,1)");
    fade.addColorStop(1, "rgba(0,0,0,0)");
    ink.globalAlpha = 1;
    ink.globalCompositeOperation = "destination-in";
    ink.fillStyle = fade;
    ink.fillRect(0, 0, 1024, 1024);
    const texture = new THREE.CanvasTexture(canvas);
    texture.anisotropy = 8;
    const lines = new THREE.Mesh(
      new THREE.PlaneGeometry(2, 2),
      new THREE.MeshBasicMaterial({ map: texture, transparent: true, depthWrite: false, toneMapped: false }),
    );
    lines.position.z = -0.0012;
    this.shade = new THREE.Mesh(
      new THREE.PlaneGeometry(6, 6),
      new THREE.ShadowMaterial({ opacity: 0.2, color: 0x1b2a44 }),
    );
    this.shade.position.z = -0.001;
    this.shade.receiveShadow = true;
    this.lines = lines;
    floor.add(lines, this.shade);
    return floor;
  }

  // What is drawn over a robot grows with it, up to that of a human.
  get markScale() {
    return Math.min(this.size, 1.5);
  }

  // Fit the light's shadow and the grid to the robot's size.
  fit(robot) {
    const { Vector3 } = THREE;
    const size = robot.box([]).getSize(new Vector3()).length() || 1;
    this.size = size;
    this.reach(size);
    // A grid of decimetres for a small robot, of metres for a large one.
    const scale = size < 1.2 ? 1 : size < 6 ? 2.5 : 10;
    this.lines.scale.set(scale, scale, 1);
    this.shade.scale.set(scale, scale, 1);
  }

  // Have the light throw the shadows of all that is so large.
  reach(size) {
    this.key.position.set(0.75 * size, 0.85 * size, 2.6 * size);
    Object.assign(this.key.shadow.camera, { left: -size, right: size, top: size, bottom: -size, near: 0.1 * size });
    this.key.shadow.camera.far = 5 * size;
    this.key.shadow.camera.updateProjectionMatrix();
  }

  // A robot that walks stays in the picture and in the light: what looks at it goes along over the floor, on a slack
  // rope, so that one that only sways leaves it where it is.
  goAlong(x, y) {
    const way = [x - this.place[0], y - this.place[1]];
    const length = Math.hypot(...way);
    const share = 1 - (SLACK * this.size) / length;
    if (!(share > 0)) return;
    const [dx, dy] = way.map((step) => share * step);
    this.place = [this.place[0] + dx, this.place[1] + dy];
    const { camera, controls } = this.viewer;
    for (const node of [camera.position, controls.target]) {
      node.x += dx;
      node.z -= dy;
    }
    for (const node of [this.key.position, this.key.target.position]) {
      node.x += dx;
      node.y += dy;
    }
    // The grid goes from one of its strong lines to the next, and seems to have no end.
    const step = GRID_STEP * this.lines.scale.x;
    const [near, aside] = this.place.map((coordinate) => Math.round(coordinate / step) * step);
    this.floor.position.set(near, aside, 0);
  }

  // Colours in a URDF are those of a screen; light is reckoned in linear ones.
  setMaterial(mesh) {
    const { color, opacity } = mesh.material;
    mesh.material.dispose();
    mesh.material = new THREE.MeshPhongMaterial({
      color: color.clone().convertSRGBToLinear(),
      specular: 0x2a2a2a,
      shininess: 48,
      side: THREE.DoubleSide,
      opacity,
      transparent: opacity < 1,
    });
    mesh.userData.own = mesh.material.color.clone();
    mesh.userData.opacity = opacity;
    mesh.castShadow = mesh.receiveShadow = true;
  }

  seeThrough(robot, on) {
    for (const { mesh } of robot.meshes) {
      const opacity = on ? 0.28 * mesh.userData.opacity : mesh.userData.opacity;
      const side = on ? THREE.FrontSide : THREE.DoubleSide;
      Object.assign(mesh.material, { opacity, side, transparent: opacity < 1 });
      mesh.material.needsUpdate = true;
    }
  }

  // Move the camera so that what a preset looks at just fills the view, under a bar that takes a share of its height.
  look(preset, robot, bar = 0) {
    const { Vector3, MathUtils } = THREE;
    const { camera, controls } = this.viewer;
    camera.fov = 28;
    camera.near = 0.02 * this.size;
    camera.far = 60 * this.size;
    const box = robot.box(preset.links);
    const centre = box.getCenter(new Vector3());
    // The world of three.js has y up: z of the robot is its y, and y its −z.
    const [x, y, z] = preset.direction;
    const back = new Vector3(x, z, -y).normalize();
    const right = new Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(right);
    const half = Math.tan(MathUtils.degToRad(camera.fov / 2));
    const hidden = Math.min(Math.max(2 * bar - 0.1, 0), 0.5);
    const tall = half * (0.9 - hidden / 2);
    const wide = 0.9 * half * camera.aspect;
    let distance = preset.links.length ? 0 : this.size;
    for (let i = 0; i < 8; i++) {
      const corner = new Vector3(
        i & 1 ? box.max.x : box.min.x,
        i & 2 ? box.max.y : box.min.y,
        i & 4 ? box.max.z : box.min.z,
      ).sub(centre);
      const reach = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall);
      distance = Math.max(distance, reach + corner.dot(back));
    }
    // The camera sits in meshcat's node that turns z up again; its coordinates are those of the world.
    camera.position.copy(centre).addScaledVector(back, distance);
    // The picture moves down by half of what the bar hides; the camera still turns about the middle of the robot.
    const { aspect } = camera;
    camera.setViewOffset(1, 1, 0, -hidden / 4, 1, 1);
    camera.aspect = aspect;
    camera.updateProjectionMatrix();
    controls.target.copy(centre);
    controls.update();
    this.viewer.set_dirty();
  }
}

export function resize(viewer, width, height) {
  viewer.camera.aspect = width / height;
  viewer.camera.updateProjectionMatrix();
  viewer.renderer.setSize(width, height);
  viewer.set_dirty();
}
