import { Connection } from "./connection.js";
import { Drag } from "./drag/drag.js";
import { Legend } from "./legend.js";
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
import { Ghosts } from "./scene/ghosts.js";
import { JointAxes } from "./scene/joint_axes.js";
import { Labels } from "./scene/labels.js";
import { Lights } from "./scene/lights.js";
import { OtherRobots } from "./scene/other_robots.js";
import { Reach } from "./scene/reach.js";
import { Speech } from "./scene/speech.js";
import { Studio } from "./scene/studio.js";
import { Stance } from "./stance.js";
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

  /** The camera chosen last. @type {string | null} */
  view = null;

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
    this.stance = new Stance(this);
    this.player = new Player(this, byId("player"), () => this.stance.followClip());
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
    this.shown = new ShownRobot(root, about, this.studio);
    ({ robot: this.robot, colours: this.colours } = this.shown);
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
    this.stance.settle();
    this.camera("three-quarter");
    this.view = null;
    this.dispatchEvent(new Event("started"));
  }

  // The scene is all here.
  complete() {
    this.stance.setDownAnew();
    this.stance.settle();
    this.viewer.set_3d_pane_size();
    if (this.view === null) this.camera("three-quarter");
    this.viewer.set_dirty();
    this.panel.complete();
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

  // --- the robot, for scripts in the console: what `stance` does -------------------------------------------------

  get q() {
    return this.stance.q;
  }

  /** @type {Stance["set"]} */
  set(...values) {
    this.stance.set(...values);
  }

  /** @type {Stance["move"]} */
  move(...values) {
    this.stance.move(...values);
  }

  /** @type {Stance["posture"]} */
  posture(name) {
    this.stance.posture(name);
  }

  settle() {
    this.stance.settle();
  }

  /** @type {Stance["pose"]} */
  pose(frame) {
    return this.stance.pose(frame);
  }

  com() {
    return this.stance.com();
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
    this.stance.settle();
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
    this.studio.look(preset, robots, (bar.offsetTop + bar.offsetHeight) / (this.pane.clientHeight || 1));
  }
}
