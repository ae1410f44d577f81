"use strict";

// What is drawn over the robot: frames, joint axes, centre of mass and support, a second pose, targets, colours.
NaoKin.Marks = class {
  constructor(viewer, studio, robot) {
    this.viewer = viewer;
    this.studio = studio;
    this.robot = robot;
    this.frames = [];
    this.axes = [];
    this.targets = new MeshCat.THREE.Group();
    robot.root.add(NaoKin.mark(this.targets));
    this.balance = new MeshCat.THREE.Group();
    viewer.scene.add(this.balance);
    [this.scale, this.red] = [new Map(), new Set()];
    this.balanceShown = { com: false, support: false };
  }

  showFrames(names, size) {
    this.clear(this.frames);
    for (const [index, name] of names.entries()) {
      const triad = NaoKin.triad(size);
      triad.add(NaoKin.label(name, size, index));
      this.robot.nodes[this.robot.frames.get(name)].add(NaoKin.mark(triad));
      this.frames.push(triad);
    }
    this.viewer.set_dirty();
  }

  showAxes(on) {
    this.clear(this.axes);
    const kinds = new Map();
    for (const joint of on ? this.robot.joints : []) {
      const kind = joint.pair;
      if (!kind) continue;
      const colour = NaoKin.PAIR_COLOURS[kind] ?? NaoKin.PAIR_COLOURS.other;
      kinds.set(kind, colour);
      const screw = NaoKin.screw(joint.slides, colour, 0.07 * Math.min(this.studio.size, 1.5));
      screw.quaternion.setFromUnitVectors(new MeshCat.THREE.Vector3(0, 0, 1), joint.axis);
      joint.node.parent.add(NaoKin.mark(screw));
      this.axes.push(screw);
    }
    this.studio.seeThrough(this.robot, on);
    this.viewer.set_dirty();
    return kinds;
  }

  showTargets(targets) {
    NaoKin.empty(this.targets);
    const size = 0.09 * Math.min(this.studio.size, 1.5);
    for (const { name, matrix, point } of targets) {
      const mark = NaoKin.target(size, !point);
      mark.matrixAutoUpdate = false;
      mark.matrix.fromArray(matrix);
      mark.add(NaoKin.label(name, size));
      this.targets.add(mark);
    }
    this.viewer.set_dirty();
  }

  // A pale copy of the robot in another configuration.
  showGhost(q) {
    const T = MeshCat.THREE;
    if (this.ghost) {
      this.ghost.root.removeFromParent();
      this.ghost = null;
    }
    if (q) {
      const root = this.robot.root.clone(true);
      const marks = [];
      root.traverse((node) => node.userData.mark && marks.push(node));
      marks.forEach((mark) => mark.removeFromParent());
      const veil = new T.MeshPhongMaterial({ color: 0x3f7fd9, transparent: true, opacity: 0.22, depthWrite: false });
      root.traverse((mesh) => {
        if (mesh.isMesh) Object.assign(mesh, { material: veil, castShadow: false, receiveShadow: false });
      });
      this.viewer.scene.add(root);
      this.ghost = new NaoKin.Skeleton(root, this.robot.about);
      this.ghost.apply(q);
    }
    this.viewer.set_dirty();
  }

  // Links coloured by a number, and in red those whose joint is outside its limits; the others keep their own colours.
  tint({ scale = this.scale, red = this.red }) {
    if (scale === this.scale && red.size === 0 && this.red.size === 0) return;
    [this.scale, this.red] = [scale, red];
    for (const shape of this.robot.meshes) this.paint(shape);
    this.viewer.set_dirty();
  }

  // A light that is lit shines in its own colour, whatever its link's.
  paint({ mesh, link }) {
    const { color } = mesh.material;
    const rgb = this.scale.get(link);
    if (mesh.userData.lit) color.copy(NaoKin.GLASS);
    else if (rgb) color.setRGB(...rgb).convertSRGBToLinear();
    else color.copy(mesh.userData.own);
    if (this.red.has(link) && !mesh.userData.lit) color.lerp(NaoKin.RED, 0.8);
  }

  // Centre of mass over its projection, and the hull of what touches the floor: green while the one is in the other.
  drawBalance() {
    NaoKin.empty(this.balance);
    const { com, support } = this.balanceShown;
    if (!com && !support) return;
    const T = MeshCat.THREE;
    const { robot } = this;
    const centre = robot.com();
    if (centre) {
      const toScene = new T.Matrix4().copy(robot.root.parent.matrixWorld).invert().multiply(robot.root.matrixWorld);
      centre.applyMatrix4(toScene);
    }
    const hull = support ? this.hull() : [];
    const size = Math.min(this.studio.size, 1.5);
    if (support && hull.length > 2) {
      const stands = centre && NaoKin.inside(hull, centre);
      const colour = stands ? 0x2f9e64 : 0xd6453d;
      const area = new T.Mesh(
        new T.ShapeGeometry(new T.Shape(hull)),
        new T.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.22, depthWrite: false }),
      );
      area.position.z = 0.0006;
      area.renderOrder = 15;
      const rim = new T.LineLoop(
        new T.BufferGeometry().setFromPoints(hull.map(({ x, y }) => new T.Vector3(x, y, 0.001))),
        new T.LineBasicMaterial({ color: colour, depthTest: false, transparent: true }),
      );
      rim.renderOrder = 16;
      this.balance.add(area, rim);
    }
    if (com && centre) {
      const ball = new T.Mesh(new T.SphereGeometry(0.018 * size, 32, 24), NaoKin.quarters());
      ball.position.copy(centre);
      ball.renderOrder = 20;
      const down = new T.Line(
        new T.BufferGeometry().setFromPoints([centre, new T.Vector3(centre.x, centre.y, 0)]),
        new T.LineDashedMaterial({ color: 0x20242c, dashSize: 0.012, gapSize: 0.008, depthTest: false, transparent: true }),
      );
      down.computeLineDistances();
      down.renderOrder = 19;
      const foot = new T.Mesh(
        new T.RingGeometry(0.011 * size, 0.016 * size, 40),
        new T.MeshBasicMaterial({ color: 0x20242c, side: T.DoubleSide, depthTest: false, transparent: true }),
      );
      foot.renderOrder = 18;
      foot.position.set(centre.x, centre.y, 0.0015);
      this.balance.add(ball, down, foot);
    }
  }

  // The convex hull, on the floor, of all vertices within 5 mm of it; counterclockwise.
  hull() {
    const points = [];
    const { Vector2 } = MeshCat.THREE;
    this.robot.eachVertex(
      (vertex) => vertex.z < 0.005 && points.push(new Vector2(vertex.x, vertex.y)),
      () => 0.005,
    );
    return NaoKin.convexHull(points);
  }

  clear(marks) {
    for (const mark of marks) {
      mark.removeFromParent();
      NaoKin.empty(mark);
    }
    marks.length = 0;
  }
};

NaoKin.PAIR_COLOURS = {
  revolute: "#e8590c",
  prismatic: "#1c7ed6",
  helical: "#c2255c",
  cylindrical: "#5f3dc4",
  universal: "#7c4ddb",
  condyloid: "#9c36b5",
  spherical: "#099268",
  planar: "#846358",
  other: "#5c6678",
};

NaoKin.RED = new MeshCat.THREE.Color(0xd92d20).convertSRGBToLinear();

NaoKin.mark = (node) => {
  node.userData.mark = true;
  return node;
};

NaoKin.empty = (group) => {
  for (const child of [...group.children]) {
    NaoKin.empty(child);
    child.geometry?.dispose();
    child.material?.map?.dispose();
    child.material?.dispose();
    child.removeFromParent();
  }
};

NaoKin.paint = (colour, order) =>
  new MeshCat.THREE.MeshBasicMaterial({
    color: new MeshCat.THREE.Color(colour).convertSRGBToLinear(),
    transparent: true,
    depthTest: order === 0,
  });

// A rod along z with a head at its end, in one geometry's worth of meshes.
NaoKin.arrow = (length, radius, colour, order) => {
  const T = MeshCat.THREE;
  const arrow = new T.Group();
  const material = NaoKin.paint(colour, order);
  const rod = new T.Mesh(new T.CylinderGeometry(radius, radius, length, 12), material);
  rod.position.z = length / 2;
  const head = new T.Mesh(new T.ConeGeometry(2.6 * radius, 7 * radius, 16), material);
  head.position.z = length + 3 * radius;
  for (const part of [rod, head]) {
    part.rotation.x = Math.PI / 2;
    part.renderOrder = order;
    arrow.add(part);
  }
  return arrow;
};

NaoKin.triad = (size) => {
  const T = MeshCat.THREE;
  const triad = new T.Group();
  const axes = [
    ["#e0433a", [0, Math.PI / 2, 0]],
    ["#2f9e44", [-Math.PI / 2, 0, 0]],
    ["#2f6fe0", [0, 0, 0]],
  ];
  for (const [colour, [x, y, z]] of axes) {
    const arrow = NaoKin.arrow(size, 0.035 * size, colour, 10);
    arrow.rotation.set(x, y, z);
    triad.add(arrow);
  }
  return triad;
};

// The axis of a joint: turning about it, or sliding along it.
NaoKin.screw = (slides, colour, size) => {
  const T = MeshCat.THREE;
  const screw = new T.Group();
  const radius = 0.028 * size;
  const rod = NaoKin.arrow(1.5 * size, radius, colour, 10);
  rod.position.z = -0.75 * size;
  screw.add(rod);
  if (slides) {
    const back = NaoKin.arrow(0.75 * size, radius, colour, 10);
    back.rotation.x = Math.PI;
    screw.add(back);
  } else {
    const material = NaoKin.paint(colour, 10);
    const bow = new T.Mesh(new T.TorusGeometry(0.27 * size, 0.8 * radius, 10, 40, 1.5 * Math.PI), material);
    const head = new T.Mesh(new T.ConeGeometry(2.2 * radius, 6 * radius, 16), material);
    head.position.set(0, -0.27 * size, 0);
    head.rotation.z = -Math.PI / 2;
    bow.renderOrder = head.renderOrder = 10;
    const turn = new T.Group();
    turn.position.z = 0.45 * size;
    turn.add(bow, head);
    screw.add(turn);
  }
  return screw;
};

NaoKin.target = (size, oriented) => {
  const T = MeshCat.THREE;
  const mark = new T.Group();
  const veil = new T.MeshBasicMaterial({ color: 0xc2255c, transparent: true, opacity: 0.3, depthWrite: false });
  mark.add(new T.Mesh(new T.SphereGeometry(0.16 * size, 28, 20), veil));
  if (oriented) mark.add(NaoKin.triad(0.6 * size));
  return mark;
};

// A name that keeps its size on the screen; the names of neighbours go to different corners.
NaoKin.label = (text, lift, index = 0) => {
  const T = MeshCat.THREE;
  const canvas = document.createElement("canvas");
  let ink = canvas.getContext("2d");
  const font = "600 40px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  ink.font = font;
  canvas.width = Math.min(2000, Math.ceil(ink.measureText(text).width) + 28);
  canvas.height = 60;
  ink = canvas.getContext("2d");
  ink.font = font;
  ink.textBaseline = "middle";
  ink.lineJoin = "round";
  ink.lineWidth = 9;
  ink.strokeStyle = "rgba(255,255,255,0.92)";
  ink.strokeText(text, 14, 32);
  ink.fillStyle = "#1d2433";
  ink.fillText(text, 14, 32);
  const map = new T.CanvasTexture(canvas);
  map.encoding = T.sRGBEncoding;
  map.minFilter = T.LinearFilter;
  const material = new T.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, toneMapped: false });
  const sprite = new T.Sprite(material);
  sprite.scale.set((0.0135 * canvas.width) / canvas.height, 0.0135, 1);
  sprite.center.set(...[[0, 0], [1, 1], [0, 1], [1, 0]][index % 4]);
  sprite.position.z = 0.25 * lift;
  sprite.renderOrder = 30;
  return sprite;
};

// The engineer's sign of a centre of mass: a ball in four black and white quarters.
NaoKin.quarters = () => {
  const T = MeshCat.THREE;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [128, 64];
  const ink = canvas.getContext("2d");
  ink.fillStyle = "#ffffff";
  ink.fillRect(0, 0, 128, 64);
  ink.fillStyle = "#14181f";
  for (const [x, y] of [[0, 0], [64, 0], [32, 32], [96, 32]]) ink.fillRect(x, y, 32, 32);
  return new T.MeshBasicMaterial({ map: new T.CanvasTexture(canvas), depthTest: false, transparent: true });
};

NaoKin.convexHull = (points) => {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && NaoKin.turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 1e-9) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return sorted.length < 3 ? [] : [...half(sorted), ...half(sorted.reverse())];
};

NaoKin.turn = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);

NaoKin.inside = (hull, p) => hull.every((corner, i) => NaoKin.turn(corner, hull[(i + 1) % hull.length], p) >= 0);
