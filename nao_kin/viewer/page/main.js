"use strict";

// One page: meshcat's viewer, the robot in it, the panel beside it, and where its messages come from.
NaoKin.App = class {
  constructor() {
    const { element } = NaoKin;
    this.byId = (id) => document.getElementById(id);
    this.role = new URLSearchParams(location.search).get("role") ?? "";
    document.body.dataset.role = this.role;
    this.received = this.drawn = 0;
    const viewer = (this.viewer = new MeshCat.Viewer(this.byId("pane")));
    // The pane is smaller where the legend stands under it.
    new ResizeObserver(() => viewer.set_3d_pane_size()).observe(this.byId("pane"));
    viewer.set_3d_pane_size = () => NaoKin.resize(viewer, this.byId("pane").clientWidth, this.byId("pane").clientHeight);
    const handle = viewer.handle_command.bind(viewer);
    viewer.handle_command = (message) => (message.type === "nao_kin" ? this.receive(message) : this.pass(message, handle));
    const render = viewer.render.bind(viewer);
    viewer.render = () => {
      this.settle();
      render();
      this.speech?.place();
      this.drawn += 1;
    };
    this.studio = new NaoKin.Studio(viewer);
    this.player = new NaoKin.Player(viewer, this.byId("player"), () => (this.up = null));
    this.source = String(Math.random());
    this.shown = { frames: false, axes: false, com: false, support: false, ghosts: true, handles: this.role === "" };
    for (const [name, text] of Object.entries(NaoKin.SHOWN)) {
      const button = element("button", { type: "button", onclick: () => this.show({ [name]: !this.shown[name] }) }, text);
      button.dataset.shown = name;
      button.hidden = name === "ghosts";
      this.byId("shown").append(button);
    }
    this.legends = { colours: [], pairs: [], reach: [], ghosts: [] };
    this.settled = null;
    this.up = null;
  }

  // --- messages ------------------------------------------------------------------------------------------------

  pass(message, handle) {
    handle(message);
    if (message.type === "set_animation") this.player.load(message.options);
  }

  receive(message) {
    const { kind } = message;
    this.received += 1;
    if (kind === "joints") message.source !== this.source && this.set([...message.q], message.up, false);
    else if (kind === "robot") this.start(message.about);
    else if (kind === "frames") this.chooseFrames(message);
    else if (kind === "shown") this.show(message.shown);
    else if (kind === "ghost") this.marks.showGhost(message.q);
    else if (kind === "ghosts") this.showGhosts(message);
    else if (kind === "targets") this.marks.showTargets(message.targets);
    else if (kind === "colours") this.colour(message);
    else if (kind === "lights") this.lights.show(message.lights);
    else if (kind === "speech") this.speech.say(message.text);
    else if (kind === "reach") this.reach.show(message);
    else if (kind === "camera") this.camera(message.name);
    else if (kind === "still") this.still();
    else if (kind === "capture") this.capture(message);
    else if (kind === "complete") this.complete();
    this.viewer.set_dirty();
  }

  start(about) {
    const root = this.viewer.scene_tree.find(["robot"]).object;
    this.robot = new NaoKin.Robot(root, about);
    for (const { mesh } of this.robot.meshes) this.studio.setMaterial(mesh);
    this.robot.apply(this.q);
    this.studio.fit(this.robot);
    this.marks = new NaoKin.Marks(this.viewer, this.studio, this.robot);
    this.lights = new NaoKin.Lights(this.robot, this.marks);
    this.speech = new NaoKin.Speech(this.viewer, this.robot, this.byId("speech"), this.byId("top"));
    this.frames = { names: about.effectors, size: 0.075 * Math.min(this.studio.size, 1.5) };
    this.panel = new NaoKin.Panel(this, this.byId("panel"));
    this.reach = new NaoKin.Reach(this, this.byId("cut"));
    this.ghosts = new NaoKin.Ghosts(this.robot);
    this.drag = new NaoKin.Drag(this, this.byId("pane"), this.byId("drag"));
    this.byId("shown").querySelector("[data-shown=handles]").hidden = !this.drag.possible;
    this.byId("cameras").replaceChildren(
      ...about.cameras.map(({ name }) =>
        NaoKin.element("button", { type: "button", onclick: () => this.camera(name) }, name),
      ),
    );
    this.viewer.set_3d_pane_size();
    this.show({});
    this.settle();
    this.camera("three-quarter");
    this.view = null;
  }

  // The scene is all here.
  complete() {
    this.settle();
    this.viewer.set_3d_pane_size();
    if (this.view === null) this.camera("three-quarter");
    this.viewer.set_dirty();
    document.body.dataset.ready = "true";
    this.send({ kind: "ready" });
  }

  // --- the configuration ---------------------------------------------------------------------------------------

  get q() {
    return this.robot.root.joint_values;
  }

  // Show a configuration; `report` it to whoever serves the page, when it comes from here.
  set(q, up = this.up, report = true) {
    if (this.player.loaded) this.player.pause();
    this.robot.root.joint_values.splice(0, q.length, ...q);
    this.up = up;
    this.unreported = report;
    this.viewer.set_dirty();
  }

  // No clip any more. meshcat's animator then puts back what it found before the clip, which is out of date.
  still() {
    const q = [...this.q];
    this.player.unload();
    this.set(q, this.up, false);
  }

  move(column, value) {
    const q = [...this.q];
    q[column] = value;
    this.set(q);
  }

  posture(name) {
    const posture = this.robot.about.postures.find((candidate) => candidate.name === name);
    this.set(this.robot.about.floating ? [...this.q.slice(0, 7), ...posture.q.slice(7)] : posture.q, posture.up);
  }

  // Bring the scene up to date with the joint values, whoever wrote them; on every frame that is drawn.
  settle() {
    if (!this.robot) return;
    this.player.refresh();
    const now = [...this.q, ...(this.up ?? [])];
    if (this.settled?.length === now.length && now.every((value, i) => value === this.settled[i])) return;
    this.settled = now;
    const { robot } = this;
    robot.apply(this.q);
    if (!robot.about.floating && !this.drag.held) robot.stand(this.up);
    if (robot.about.floating) this.studio.goAlong(this.q[0], this.q[1]);
    this.ghosts.refresh();
    if (this.marks.ghost) {
      this.marks.ghost.root.position.copy(robot.root.position);
      this.marks.ghost.root.quaternion.copy(robot.root.quaternion);
    }
    this.viewer.renderer.shadowMap.needsUpdate = true;
    this.marks.drawBalance();
    const outside = robot.outside(this.q);
    this.marks.tint({ red: new Set(robot.joints.filter(({ column }) => outside.has(column)).map(({ link }) => link)) });
    this.panel.refresh();
    if (this.unreported) this.send({ kind: "joints", q: [...this.q], up: this.up, source: this.source });
    this.unreported = false;
  }

  // Put the robot on the floor again, which it keeps off while it is dragged.
  restand() {
    this.settled = null;
    this.viewer.set_dirty();
  }

  // Pose of a frame in the robot's root, row by row.
  pose(frame) {
    this.settle();
    return this.robot.pose(this.robot.frames.get(frame)).transpose().toArray();
  }

  com() {
    this.settle();
    return this.robot.com()?.toArray() ?? null;
  }

  // --- what is shown -------------------------------------------------------------------------------------------

  show(changes) {
    Object.assign(this.shown, changes);
    const { frames, axes, com, support, ghosts, handles } = this.shown;
    if ("frames" in changes) this.marks.showFrames(frames ? this.frames.names : [], this.frames.size);
    if ("axes" in changes) this.legendOfPairs(this.marks.showAxes(axes));
    if ("ghosts" in changes) {
      this.ghosts.group.visible = ghosts;
      this.legendOfGhosts();
    }
    this.drag.show(handles);
    this.marks.balanceShown = { com, support };
    this.marks.drawBalance();
    for (const button of this.byId("shown").children) {
      button.setAttribute("aria-pressed", String(Boolean(this.shown[button.dataset.shown])));
    }
    this.viewer.set_dirty();
  }

  chooseFrames({ names, size }) {
    this.frames = { names, size: size ?? this.frames.size };
    this.show({ frames: names.length > 0 });
  }

  camera(name) {
    this.view = name;
    const preset = this.robot.about.cameras.find((candidate) => candidate.name === name);
    this.settle();
    const bar = this.byId("top");
    this.studio.look(preset, this.robot, (bar.offsetTop + bar.offsetHeight) / this.byId("pane").clientHeight);
  }

  colour({ links, label, low, high, stops }) {
    this.marks.tint({ scale: new Map(links.map(({ link, rgb }) => [link, rgb])) });
    this.legend("colours", stops ? [`${label} ${low}`.trim(), NaoKin.scaleBar(stops), `${high}`] : []);
  }

  // Configurations one after another, each in a colour of its own; the legend numbers them from the first on.
  showGhosts({ qs, count, opacity, first }) {
    const width = qs.length / count;
    const ghosts = Array.from({ length: count }, (_, i) => {
      const colour = NaoKin.GHOST_COLOURS[i % NaoKin.GHOST_COLOURS.length];
      return { q: [...qs.subarray(i * width, (i + 1) * width)], colour, opacity };
    });
    this.settle();
    this.ghosts.show(ghosts);
    this.ghosts.entries = ghosts.map(({ colour }, i) => this.legendEntry(`${first + i}`, colour));
    this.byId("shown").querySelector("[data-shown=ghosts]").hidden = count === 0;
    this.show({ ghosts: true });
  }

  // They were other answers to what is asked no more.
  clearGhosts() {
    if (this.ghosts.entries.length > 0) this.showGhosts({ qs: new Float64Array(0), count: 0 });
  }

  legendOfGhosts() {
    const { entries, group } = this.ghosts;
    this.legend("ghosts", entries.length > 0 && group.visible ? ["ghosts", ...entries] : []);
  }

  legendOfPairs(kinds) {
    this.legend("pairs", [...kinds].map(([kind, colour]) => this.legendEntry(kind, colour)));
  }

  legendEntry(text, colour) {
    const dot = NaoKin.element("span", { className: "dot" });
    dot.style.background = colour;
    return NaoKin.element("span", { className: "entry" }, dot, text);
  }

  // Colours of links, kinds of joints, what is reached and ghosts each have their own part of the legend.
  legend(part, children) {
    this.legends[part] = children;
    const parts = Object.values(this.legends).filter(({ length }) => length > 0);
    const legend = this.byId("legend");
    legend.replaceChildren(...parts.map((entries) => NaoKin.element("span", { className: "part" }, ...entries)));
    legend.hidden = parts.length === 0;
  }

  notice(...children) {
    this.byId("notice").replaceChildren(...children);
    this.byId("notice").hidden = false;
  }

  // --- where the messages come from ----------------------------------------------------------------------------

  read(lines) {
    for (const line of lines) {
      this.viewer.handle_command_bytearray(Uint8Array.from(atob(line), (letter) => letter.charCodeAt(0)));
    }
    this.complete();
  }

  listen() {
    const address = new URL(`live${location.search}`, location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => this.viewer.handle_command_bytearray(new Uint8Array(data));
    this.socket.onclose = () => {
      document.body.dataset.live = "ended";
      const again = NaoKin.element("button", { type: "button", onclick: () => location.reload() }, "Reconnect");
      this.notice("The program behind this page has ended; the panel still works.", again);
    };
    document.body.dataset.live = "live";
  }

  send(answer) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(answer));
  }

  capture({ id, width, height, camera }) {
    const preset = this.robot.about.cameras.find(({ name }) => name === camera);
    const over = (ink) => this.speech.paint(ink, width, height);
    this.send({ kind: "picture", id, data: this.studio.picture(width, height, preset, this.robot, over) });
  }
};

// What may be drawn over the robot, and the buttons for it.
NaoKin.SHOWN = {
  frames: "Frames",
  axes: "Joint axes",
  com: "Centre of mass",
  support: "Support",
  ghosts: "Ghosts",
  handles: "Handles",
};

try {
  window.naoKin = new NaoKin.App();
  const lines = document.getElementById("scene").textContent.trim();
  if (lines) window.naoKin.read(lines.split("\n"));
  else window.naoKin.listen();
} catch (error) {
  console.error(error);
  const notice = document.getElementById("notice");
  notice.textContent = `This page cannot be shown; it needs WebGL (${error.message}).`;
  notice.hidden = false;
}
