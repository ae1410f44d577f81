import { Connection } from "./connection.js";
import { Drag } from "./drag/drag.js";
import { Legend, entry } from "./legend.js";
import { HANDLERS } from "./messages.js";
import { makeViewer } from "./meshcat_viewer.js";
import { Panel } from "./panel/panel.js";
import { button } from "./panel/element.js";
import { Pick } from "./pick/pick.js";
import { Video } from "./record/video.js";
import { Reports } from "./reports.js";
import { ShownRobot } from "./robot/shown_robot.js";
import { Balance } from "./scene/balance.js";
import { Extras } from "./scene/extras.js";
import { Eyes, makeSight } from "./scene/eyes.js";
import { Frames } from "./scene/frames.js";
import { COMPARED, GHOST_COLOURS, Ghosts } from "./scene/ghosts.js";
import { JointAxes } from "./scene/joint_axes.js";
import { Labels } from "./scene/labels.js";
import { Lights } from "./scene/lights.js";
import { OtherRobots } from "./scene/other_robots.js";
import { Reach } from "./scene/reach.js";
import { Speech } from "./scene/speech.js";
import { Studio } from "./scene/studio.js";
import { Targets } from "./scene/targets.js";
import { Player } from "./timeline/player.js";
import { Toggles } from "./toggles.js";
import { ViewMenu } from "./view_menu.js";

/** @typedef {import("./types.js").About} About */
/** @typedef {import("./types.js").Message} Message */

/** @param {string} id */
const byId = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/**
 * One page: meshcat's viewer, the robot in it, the panel beside it, and where its messages come from.
 *
 * Events: "started" when the robot is there, "settled" when the scene has been brought up to date with a new
 * configuration, its `detail.own` whether that came from this page, "camera" when a preset was chosen, "shown" when
 * something else is drawn over the robot; "gesture" of the drag, "selected" of the selection, "measured" of the
 * measurement.
 */
export class App extends EventTarget {
  // What comes with the robot, in `start`.
  /** @type {ShownRobot} */ shown;
  /** @type {import("./robot/robot.js").Robot} */ robot;
  /** @type {import("./robot/standing.js").Standing} */ standing;
  /** @type {Frames} */ frames;
  /** @type {JointAxes} */ axes;
  /** @type {Targets} */ targets;
  /** @type {Balance} */ balance;
  /** @type {Ghosts} */ ghosts;
  /** @type {import("./scene/link_colours.js").LinkColours} */ colours;
  /** @type {Lights} */ lights;
  /** @type {Labels} */ labels;
  /** @type {Eyes} */ eyes;
  /** @type {Video} */ video;
  /** @type {ViewMenu} */ menu;
  /** @type {Speech} */ speech;
  /** @type {Reach} */ reach;
  /** @type {Pick} */ pick;
  /** @type {Panel} */ panel;
  /** @type {Drag} */ drag;

  /** The configuration that the scene was last brought up to date with. @type {number[] | null} */
  settled = null;
  /** The vertical in the root's frame, where it is given. @type {ArrayLike<number> | null} */
  up = null;
  /** The camera chosen last. @type {string | null} */
  view = null;
  /** Whether the configuration comes from this page, and nobody has been told. */
  unreported = false;
  /** Whether the robot was moved last by somebody in a page. */
  movedByHand = false;
  /** Whether the clip says which direction is up, as long as nothing else moves the robot. */
  followsClip = false;

  constructor() {
    super();
    this.role = new URLSearchParams(location.search).get("role") ?? "";
    document.body.dataset.role = this.role;
    this.received = this.drawn = 0;
    this.pane = byId("pane");
    this.viewer = makeViewer(this);
    this.studio = new Studio(this.viewer);
    this.legend = new Legend(byId("legend"));
    this.toggles = new Toggles(this, byId("shown"));
    this.player = new Player(this, byId("player"), () => this.followClip());
    this.connection = new Connection(this);
    this.others = new OtherRobots(this);
    this.extras = new Extras(this);
    this.reports = new Reports(this);
  }

  // --- messages ------------------------------------------------------------------------------------------------

  /** @param {Message} message */
  receive(message) {
    this.received += 1;
    if (Object.hasOwn(HANDLERS, message.kind)) HANDLERS[message.kind](this, message);
    this.viewer.set_dirty();
  }

  /** @param {About} about */
  start(about) {
    const root = this.viewer.scene_tree.find(["robot"]).object;
    if (this.robot) this.studio.release(this.robot);
    this.shown = new ShownRobot(root, about, this.studio);
    ({ robot: this.robot, standing: this.standing, colours: this.colours } = this.shown);
    this.robot.apply(this.q);
    this.studio.fit(this.robot);
    this.labels = new Labels(this.viewer, this.pane, byId("top"));
    this.frames = new Frames(this.robot, this.labels, about.effectors, 0.075 * this.studio.markScale);
    this.axes = new JointAxes(this.robot, this.studio, this.labels);
    this.targets = new Targets(this.robot, this.studio, this.labels);
    this.balance = new Balance(this.robot, this.viewer.scene, this.studio);
    this.lights = new Lights(this.robot, this.colours);
    this.speech = new Speech(this.viewer, this.robot, byId("speech"), byId("top"));
    this.pick = new Pick(this, this.pane);
    this.panel?.close();
    this.panel = new Panel(this, byId("panel"));
    this.reach = new Reach(this, byId("cut"));
    this.ghosts = new Ghosts(this.robot);
    this.drag = new Drag(this, this.pane, byId("drag"), byId("handles"));
    this.toggles.offer("handles", this.drag.possible);
    this.toggles.offer("joints", about.joints.length > 0);
    this.eyes = new Eyes(this.robot, this.studio, makeSight(this));
    this.studio.eyes = this.eyes;
    this.toggles.offer("eye", about.eyes.length > 0);
    this.toggles.offer("chains", about.chains.length > 1);
    this.video = new Video(this);
    this.menu = new ViewMenu(this, byId("top"));
    byId("cameras").replaceChildren(...about.cameras.map(({ name }) => button(name, () => this.camera(name))));
    this.viewer.set_3d_pane_size();
    this.toggles.apply();
    this.settle();
    this.camera("three-quarter");
    this.view = null;
    this.dispatchEvent(new Event("started"));
  }

  // The scene is all here.
  complete() {
    this.setDownAnew();
    this.settle();
    this.viewer.set_3d_pane_size();
    if (this.view === null) this.camera("three-quarter");
    this.viewer.set_dirty();
    this.panel?.complete();
    document.body.dataset.ready = "true";
    this.send({ kind: "ready" });
  }

  /** @param {object} answer */
  send(answer) {
    this.connection.send(answer);
  }

  /** @param {...(string | Node)} children none for no notice */
  notice(...children) {
    byId("notice").replaceChildren(...children);
    byId("notice").hidden = children.length === 0;
  }

  // --- the configuration ---------------------------------------------------------------------------------------

  get q() {
    return this.robot.q;
  }

  /**
   * Show a configuration.
   *
   * @param {number[]} q
   * @param {ArrayLike<number> | null} up the vertical in the root's frame; null for what the robot stands on by itself
   * @param {boolean} report it to whoever serves the page: it comes from here
   */
  set(q, up = this.up, report = true) {
    if (this.player.loaded) this.player.pause();
    this.put(q, up, report);
  }

  /**
   * The same, for what is played: it goes on.
   *
   * @param {number[]} q
   * @param {ArrayLike<number> | null} up
   * @param {boolean} report
   */
  put(q, up, report) {
    this.robot.q.splice(0, q.length, ...q);
    this.followsClip = false;
    this.up = up;
    this.unreported = report;
    this.movedByHand ||= report;
    this.viewer.set_dirty();
  }

  /**
   * Show a configuration that is no small step from the one before: it is set down as if it were the first.
   *
   * @param {number[]} q
   * @param {ArrayLike<number> | null} up
   */
  jump(q, up = null) {
    this.setDownAnew();
    this.set(q, up);
  }

  /**
   * Show a configuration that comes from elsewhere.
   *
   * @param {number[]} q
   * @param {ArrayLike<number> | null} up
   * @param {boolean} byHand whether somebody moved the robot in a page
   */
  display(q, up, byHand) {
    // What was done by hand says nothing about what the program shows next.
    if (this.movedByHand && !byHand) this.setDownAnew();
    this.set(q, up, false);
    this.movedByHand = byHand;
  }

  followClip() {
    this.up = null;
    this.followsClip = true;
  }

  // No clip any more. meshcat's animator then puts back what it found before the clip, which is out of date.
  still() {
    const q = [...this.q];
    this.player.unload();
    this.set(q, this.up, false);
  }

  /**
   * @param {number} column of q
   * @param {number} value
   */
  move(column, value) {
    const q = [...this.q];
    q[column] = value;
    this.set(q);
  }

  /** @param {string} name */
  posture(name) {
    const posture = this.robot.about.postures.find((candidate) => candidate.name === name);
    if (!posture) return;
    this.jump(this.robot.about.floating ? [...this.q.slice(0, 7), ...posture.q.slice(7)] : posture.q);
  }

  // Bring the scene up to date with the joint values, whoever wrote them; on every frame that is drawn.
  settle() {
    if (!this.robot) return;
    this.player.refresh();
    if (this.followsClip) this.up = Math.hypot(...this.robot.clipUp) > 1e-6 ? [...this.robot.clipUp] : null;
    const now = [...this.q, ...Array.from(this.up ?? [])];
    if (this.settled?.length === now.length && now.every((value, i) => value === this.settled?.[i])) return;
    this.settled = now;
    const { robot } = this;
    this.shown.settle(this.up, this.drag.held !== null);
    if (robot.about.floating) this.studio.goAlong(this.q[0], this.q[1]);
    this.ghosts.refresh();
    this.studio.moved();
    this.balance.draw();
    this.panel.refresh();
    if (this.followsClip) this.reports.playing("clip", this.q);
    const own = this.unreported;
    if (own) this.reports.joints();
    this.unreported = false;
    this.dispatchEvent(new CustomEvent("settled", { detail: { own } }));
  }

  // Put the robot on the floor again, which it keeps off while it is dragged.
  restand() {
    this.settled = null;
    this.viewer.set_dirty();
  }

  // As if nothing had been shown before.
  setDownAnew() {
    this.standing.forget();
    this.restand();
  }

  /**
   * Pose of a frame in the robot's root, row by row.
   *
   * @param {string} frame
   */
  pose(frame) {
    this.settle();
    return this.robot.pose(this.robot.linkOf(frame)).transpose().toArray();
  }

  com() {
    this.settle();
    return this.robot.com()?.toArray() ?? null;
  }

  // --- what is shown -------------------------------------------------------------------------------------------

  /** @param {Record<string, boolean>} changes */
  show(changes) {
    this.toggles.set(changes);
  }

  /**
   * Show what a button of another page does, or the program; a picture has no handles.
   *
   * @param {{ shown: Record<string, boolean>, source?: string }} message
   */
  receiveShown({ shown, source }) {
    if (source === this.reports.source) return;
    this.show(this.role === "" ? shown : { ...shown, handles: false });
  }

  /** @param {{ names: string[], size: number | null }} chosen */
  chooseFrames({ names, size }) {
    Object.assign(this.frames, { names, size: size ?? this.frames.size });
    this.show({ frames: names.length > 0 });
  }

  // The configuration of now stays as a pale copy.
  keepGhost() {
    this.showGhosts({ qs: Float64Array.from(this.q), count: 1, opacity: 0.3, first: null });
  }

  /** @param {string} name one of the editions, or "" for the robot's own colours */
  setEdition(name) {
    this.colours.setEdition(name);
    this.menu.refresh();
    this.viewer.set_dirty();
  }

  /** @param {string} name */
  camera(name) {
    this.view = name;
    const preset = this.robot.about.cameras.find((candidate) => candidate.name === name);
    this.settle();
    this.look(preset, this.others);
    this.dispatchEvent(new Event("camera"));
  }

  /**
   * Fill the view, under the bar over it.
   *
   * @param {import("./types.js").Camera | undefined} preset
   * @param {{ box(links: number[]): import("three").Box3 }} robots
   */
  look(preset, robots) {
    const bar = byId("top");
    this.studio.look(preset, robots, (bar.offsetTop + bar.offsetHeight) / this.pane.clientHeight);
  }

  /**
   * Configurations, each in a colour of its own; the legend numbers them. Without numbers they are to compare with.
   *
   * @param {{ qs: Float64Array, count: number, opacity: number, first: number | null }} message one after another; number of the first
   */
  showGhosts({ qs, count, opacity, first }) {
    const width = qs.length / count;
    const ghosts = Array.from({ length: count }, (_, i) => {
      const colour = first === null ? COMPARED : GHOST_COLOURS[i % GHOST_COLOURS.length];
      return { q: [...qs.subarray(i * width, (i + 1) * width)], colour, opacity };
    });
    this.settle();
    this.ghosts.show(ghosts);
    this.ghosts.entries = first === null ? [] : ghosts.map(({ colour }, i) => entry(`${first + i}`, colour));
    this.toggles.offer("ghosts", count > 0);
    this.show({ ghosts: true });
  }

  clearGhosts() {
    this.showGhosts({ qs: new Float64Array(0), count: 0, opacity: 1, first: null });
  }
}
