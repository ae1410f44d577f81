"use strict";

// The robot's tree of nodes: joint values in, poses out.
NaoKin.Skeleton = class {
  constructor(root, about) {
    const { Vector3 } = MeshCat.THREE;
    this.about = about;
    this.root = root;
    this.nodes = about.links.map(({ path }) => path.slice(1).reduce(NaoKin.child, root));
    this.joints = about.joints.map((joint) => ({
      ...joint,
      node: this.nodes[joint.link],
      axis: new Vector3(...joint.axis),
    }));
  }

  apply(q) {
    if (this.about.floating) {
      this.nodes[0].position.set(q[0], q[1], q[2]);
      this.nodes[0].quaternion.set(q[3], q[4], q[5], q[6]).normalize();
    }
    for (const { node, axis, slides, column, multiplier, offset } of this.joints) {
      const value = multiplier * q[column] + offset;
      if (slides) node.position.copy(axis).multiplyScalar(value);
      else node.quaternion.setFromAxisAngle(axis, value);
    }
    this.root.updateWorldMatrix(true, true);
  }

  // Pose of a link in the frame of the robot's root, or of the world when the base floats.
  pose(link) {
    const { Matrix4 } = MeshCat.THREE;
    return new Matrix4().copy(this.root.matrixWorld).invert().multiply(this.nodes[link].matrixWorld);
  }
};

NaoKin.child = (node, name) => {
  const found = node.children.find((child) => child.name === name);
  if (found) return found;
  const made = new MeshCat.THREE.Group();
  made.name = name;
  node.add(made);
  return made;
};

// Whether a node is another one, or carried by it.
NaoKin.isInside = (node, holder) => node === holder || (node.parent !== null && NaoKin.isInside(node.parent, holder));

// Pose of one node in another's frame.
NaoKin.between = (node, other) => {
  node.updateWorldMatrix(true, false);
  other.updateWorldMatrix(true, false);
  return new MeshCat.THREE.Matrix4().copy(other.matrixWorld).invert().multiply(node.matrixWorld);
};

// The robot on show: its skeleton, its shapes, its limits and its masses.
NaoKin.Robot = class extends NaoKin.Skeleton {
  constructor(root, about) {
    super(root, about);
    this.frames = new Map(about.frames.map(({ name, link }) => [name, link]));
    this.meshes = [];
    this.nodes.forEach((node, link) => {
      for (const child of node.children.filter(({ name }) => name.startsWith("visual:"))) {
        child.traverse((mesh) => mesh.isMesh && this.meshes.push({ mesh, link }));
      }
    });
    // meshcat's clips write into this array; everything else does too, so that there is one truth.
    root.joint_values = [...about.neutral];
  }

  range({ column, lower, upper }, q) {
    let [low, high] = [lower ?? -Infinity, upper ?? Infinity];
    for (const table of this.about.tables.filter(({ joint }) => joint === column)) {
      low = Math.max(low, NaoKin.interpolate(table.at, table.lower, q[table.of]));
      high = Math.min(high, NaoKin.interpolate(table.at, table.upper, q[table.of]));
    }
    return [low, high];
  }

  outside(q) {
    const outside = this.about.coordinates.filter((coordinate) => {
      const [low, high] = this.range(coordinate, q);
      return q[coordinate.column] < low - 1e-9 || q[coordinate.column] > high + 1e-9;
    });
    return new Set(outside.map(({ column }) => column));
  }

  // Centre of mass in the same frame as `pose`; null for a robot without mass.
  com() {
    const { Vector3 } = MeshCat.THREE;
    const sum = new Vector3();
    let total = 0;
    for (const { link, mass, centre } of this.about.bodies) {
      sum.addScaledVector(new Vector3(...centre).applyMatrix4(this.pose(link)), mass);
      total += mass;
    }
    return total > 0 ? sum.divideScalar(total) : null;
  }

  // Lift the robot onto the floor: with the given direction up, or on both soles, or on the one under everything else.
  stand(given) {
    const { Quaternion, Vector3 } = MeshCat.THREE;
    const vertical = new Vector3(0, 0, 1);
    const soles = (given ? [] : this.about.soles).map((link) => {
      const pose = this.pose(link);
      return { at: new Vector3().setFromMatrixPosition(pose), up: new Vector3().setFromMatrixColumn(pose, 2) };
    });
    const stands = (feet, slack) => {
      const up = feet.reduce((sum, foot) => sum.add(foot.up), new Vector3()).normalize();
      const turn = new Quaternion().setFromUnitVectors(up, vertical);
      const lowest = this.turned(turn);
      return feet.every(({ at }) => at.clone().applyQuaternion(turn).z < lowest + slack) ? turn : null;
    };
    const turn =
      (soles.length > 1 && stands(soles, 0.008)) ||
      soles
        .map((sole) => stands([sole], 0.003))
        .filter(Boolean)
        .sort((a, b) => Math.abs(b.w) - Math.abs(a.w))[0] ||
      new Quaternion().setFromUnitVectors(new Vector3(...(given ?? [0, 0, 1])), vertical);
    this.root.position.z = -this.turned(turn);
    this.root.updateWorldMatrix(true, true);
  }

  // Height of the lowest vertex with the root turned so, at the origin.
  turned(turn) {
    this.root.quaternion.copy(turn);
    this.root.position.set(0, 0, 0);
    this.root.updateWorldMatrix(true, true);
    return this.lowest();
  }

  // Height of the lowest vertex over the plane z = 0 of the scene.
  lowest() {
    let lowest = Infinity;
    this.eachVertex((vertex) => (lowest = Math.min(lowest, vertex.z)), () => lowest);
    return Number.isFinite(lowest) ? lowest : 0;
  }

  // Vertices in the scene's frame, of the meshes that may reach under `height()`.
  eachVertex(visit, height) {
    const { Matrix4, Vector3 } = MeshCat.THREE;
    const toScene = new Matrix4().copy(this.root.parent.matrixWorld).invert();
    const matrix = new Matrix4();
    const vertex = new Vector3();
    for (const { mesh } of this.meshes) {
      matrix.multiplyMatrices(toScene, mesh.matrixWorld);
      if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
      const { center, radius } = mesh.geometry.boundingSphere;
      if (vertex.copy(center).applyMatrix4(matrix).z - radius > height()) continue;
      const position = mesh.geometry.attributes.position;
      for (let i = 0; i < position.count; i++) visit(vertex.fromBufferAttribute(position, i).applyMatrix4(matrix));
    }
  }

  // The box around some shapes in the frame of a link.
  boxIn(link, shapes) {
    const { Box3, Vector3 } = MeshCat.THREE;
    const box = new Box3();
    for (const { mesh } of shapes) {
      if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
      box.union(new Box3().copy(mesh.geometry.boundingBox).applyMatrix4(NaoKin.between(mesh, this.nodes[link])));
    }
    return box.isEmpty() ? box.expandByPoint(new Vector3()) : box;
  }

  // The box around all shapes, or around those that the given links carry, in the world of three.js.
  box(links) {
    const { Box3 } = MeshCat.THREE;
    const box = new Box3();
    const wanted = new Set(links.map((link) => this.nodes[link]));
    for (const { mesh } of this.meshes) {
      let node = mesh;
      while (wanted.size && node && !wanted.has(node)) node = node.parent;
      if (node) box.expandByObject(mesh);
    }
    if (box.isEmpty()) this.nodes.forEach((node) => box.expandByPoint(node.getWorldPosition(new MeshCat.THREE.Vector3())));
    return box;
  }
};

// R = Rz(yaw) Ry(pitch) Rx(roll): the yaw first, turned back out, and the other two from what is left, so that nothing
// is lost where the pitch is a right angle.
NaoKin.rollPitchYaw = (matrix) => {
  const m = matrix.elements;
  const yaw = Math.atan2(m[1], m[0]);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const pitch = Math.atan2(-m[2], c * m[0] + s * m[1]);
  const roll = Math.atan2(s * m[8] - c * m[9], c * m[5] - s * m[4]);
  return [roll, pitch, yaw];
};
