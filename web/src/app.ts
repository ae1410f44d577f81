import type { Box3 } from "three";
import { Connection } from "./connection.ts";
import { Drag } from "./drag/drag.ts";
import { Targets } from "./drag/targets.ts";
import { makeViewer } from "./meshcat_viewer.ts";
import { handleMessage } from "./messages.ts";
import { Controls } from "./panel/controls.ts";
import { write } from "./panel/element.ts";
import { Panel } from "./panel/panel.ts";
import { Pick } from "./pick/pick.ts";
import { Streams } from "./plot/streams.ts";
import type { Received } from "./received.ts";
import { Reports } from "./reports.ts";
import { Parts, ShownRobot, type Robot } from "./robot/robot.ts";
import { Balance } from "./scene/balance.ts";
import { BodyShapes } from "./scene/body_shapes.ts";
import { Projection, cameraPose, placeCamera } from "./scene/camera.ts";
import { Collisions } from "./scene/collisions.ts";
import { Extras } from "./scene/extras.ts";
import { Eyes, makeSight } from "./scene/eyes.ts";
import { Ghosts } from "./scene/ghosts.ts";
import { Labels } from "./scene/labels.ts";
import { Legend } from "./scene/legend.ts";
import { Lights, type LinkColours } from "./scene/link_colours.ts";
import { Frames, JointAxes } from "./scene/marks.ts";
import { OtherRobots } from "./scene/other_robots.ts";
import { Reach } from "./scene/reach.ts";
import { Studio } from "./scene/studio.ts";
import { Stance } from "./stance.ts";
import { Player } from "./timeline/player.ts";
import { Toggles, ViewMenu } from "./view_menu.ts";
import { THREE, cornersOf } from "./three.ts";
import type { About, Camera, Message, Vector } from "./types.ts";

const byId = (id: string) => document.getElementById(id) as HTMLElement;

/**
 * The page: meshcat's viewer with the robot in it, the panel beside it, and the connection that its messages come from.
 *
 * Events: "started" when the robot has been made; "settled" when the scene shows a new configuration, with `detail.own`
 * true if it came from this page; "camera" when a preset is chosen; "shown" when an overlay is switched on or off. Other
 * parts of the page send "gesture" (Drag), "selected" (Selection) and "measured" (Measure).
 */
export class App extends EventTarget {
  // These are made with the robot, in `start`, before anything else uses them.
  shown!: ShownRobot;
  robot!: Robot;
  frames!: Frames;
  axes!: JointAxes;
  targets!: Targets;
  balance!: Balance;
  collisions!: Collisions;
  ghosts!: Ghosts;
  colours!: LinkColours;
  bodyShapes!: BodyShapes;
  lights!: Lights;
  labels!: Labels;
  eyes!: Eyes;
  menu!: ViewMenu;
  reach!: Reach;
  pick!: Pick;
  controls!: Controls;
  panel!: Panel;
  drag!: Drag;

  /** The camera chosen last. */
  view: string | null = null;

  role = new URLSearchParams(location.search).get("role") ?? "";
  received = 0;
  parts = new Parts();
  pane = byId("pane");
  viewer = makeViewer(this);
  projection = new Projection(this.viewer);
  studio = new Studio(this.viewer);
  legend = new Legend(byId("legend"));
  toggles = new Toggles(this);
  stance = new Stance(this);
  streams = new Streams();
  player = new Player(this, byId("player"));
  connection = new Connection(this);
  others = new OtherRobots(this);
  extras = new Extras(this);
  reports = new Reports(this);
  drawn = 0;

  constructor() {
    super();
    document.body.dataset.role = this.role;
  }

  // --- messages ------------------------------------------------------------------------------------------------

  receive(message: Message) {
    this.received += 1;
    handleMessage(this, message);
    this.viewer.set_dirty();
  }

  start(about: About) {
    const root = this.viewer.scene_tree.find(["robot"]).object;
    this.shown = new ShownRobot(root, about, this.parts, this.studio);
    ({ robot: this.robot, colours: this.colours } = this.shown);
    this.robot.apply(this.q);
    this.studio.fit(this.robot);
    this.labels = new Labels(this.viewer, this.pane, byId("top"));
    this.frames = new Frames(this.robot, this.labels, about.effectors, 0.075 * this.studio.markScale);
    this.axes = new JointAxes(this.robot, this.studio, this.labels);
    this.targets = new Targets(this);
    this.bodyShapes = new BodyShapes(this);
    this.balance = new Balance(this);
    this.collisions = new Collisions(this);
    this.lights = new Lights(this.robot, this.colours);
    this.pick = new Pick(this, this.pane);
    this.controls = new Controls(this);
    this.panel = new Panel(this, byId("panel"));
    this.reach = new Reach(this, byId("cut"));
    this.ghosts = new Ghosts(this.robot);
    this.drag = new Drag(this, this.pane, byId("drag"), byId("handles"));
    this.eyes = new Eyes(this.robot, this.studio, makeSight(this));
    this.studio.eyes = this.eyes;
    this.menu = new ViewMenu(this, byId("top"));
    this.viewer.set_3d_pane_size();
    this.toggles.apply();
    this.stance.settle();
    this.camera("three-quarter");
    this.view = null;
    this.dispatchEvent(new Event("started"));
  }

  // The whole scene has arrived.
  complete() {
    this.stance.setDownAnew();
    this.stance.settle();
    this.viewer.set_3d_pane_size();
    if (this.view === null) this.camera("three-quarter");
    this.viewer.set_dirty();
    this.panel.complete();
    document.body.dataset.ready = "true";
    // A program that this page did not have before does not know its camera.
    this.reports.looked = "";
    this.reports.camera();
    this.send({ kind: "ready" });
  }

  send(answer: object) {
    this.connection.send(answer);
  }

  /** @param children the content; without any, the notice is hidden */
  notice(...children: (string | Node)[]) {
    byId("notice").replaceChildren(...children);
    byId("notice").hidden = children.length === 0;
  }

  /** Say in the empty picture why it is empty; without a text there is a picture. */
  blank(text: string = "") {
    write(byId("blank"), text);
  }

  // --- the robot, for scripts in the browser's console: these call `stance` --------------------------------------

  get q() {
    return this.stance.q;
  }

  set: Stance["set"] = (...values) => this.stance.set(...values);
  move: Stance["move"] = (...values) => this.stance.move(...values);
  posture: Stance["posture"] = (name) => this.stance.posture(name);
  settle: Stance["settle"] = () => this.stance.settle();
  pose: Stance["pose"] = (frame) => this.stance.pose(frame);
  com: Stance["com"] = () => this.stance.com();

  // --- overlays and cameras ------------------------------------------------------------------------------------

  show(changes: Record<string, boolean>) {
    this.toggles.set(changes);
  }

  /** Switch overlays as the program or a button of another page asks; a page that only takes a picture has no handles. */
  receiveShown({ shown, source }: Received["shown"]) {
    if (source === this.reports.source) return;
    this.show(this.role === "" ? shown : { ...shown, handles: false });
  }

  chooseFrames({ names, size }: Received["frames"]) {
    Object.assign(this.frames, { names, size: size ?? this.frames.size });
    this.show({ frames: names.length > 0 });
  }

  /** @param to a preset, or a pose like `cameraPose` */
  camera(to: string | number[]) {
    this.stance.settle();
    if (typeof to === "string") {
      this.view = to;
      this.look(this.preset(to), this.others);
      this.dispatchEvent(new Event("camera"));
      return;
    }
    this.view ??= "three-quarter";
    placeCamera(this.viewer, to, this.others.box([]).getCenter(new THREE.Vector3()), this.studio.size);
    this.viewer.set_dirty();
  }

  /** A preset of the camera. In parallel projection the robot is seen exactly along an axis. */
  preset(name: string): Camera | undefined {
    const preset = this.robot.about.cameras.find((candidate) => candidate.name === name);
    if (!preset || !this.projection.isParallel) return preset;
    const [x, y, z] = preset.direction;
    return x * y === 0 ? { ...preset, direction: [x, y, Math.abs(z) < 1 ? 0 : z] } : preset;
  }

  /** Pose of the camera in the world, which has z up, column by column: x along the optical axis, y left, z up. */
  get cameraPose() {
    return cameraPose(this.viewer);
  }

  /** Choose parallel projection or perspective; a camera at a preset takes the preset's place in it. */
  setParallel(on: boolean) {
    if (this.projection.isParallel === on) return;
    const { camera } = this.panel.address;
    this.projection.isParallel = on;
    if (typeof camera === "string") this.camera(camera);
    this.viewer.set_dirty();
  }

  /** The share of the picture's height that the bar at its top covers. */
  get bar() {
    const bar = byId("top");
    return (bar.offsetTop + bar.offsetHeight) / (this.pane.clientHeight || 1);
  }

  /** Whether all robots and ghosts are in the picture, below the bar at its top. */
  get isInSight() {
    const { camera } = this.pick.viewport;
    camera.updateProjectionMatrix();
    return cornersOf(this.others.box([])).every((corner) => {
      const { x, y, z } = corner.project(camera);
      return Math.abs(x) <= 1 && y >= -1 && y <= 1 - 2 * this.bar && z < 1;
    });
  }

  /** Bring all robots into the picture; the camera keeps its direction. */
  frame() {
    const { camera: at } = this.panel.address;
    if (typeof at === "string") return this.camera(at);
    const direction = [0, 1, 2].map((i) => at[i] - at[i + 3]) as Vector;
    this.look({ name: "", direction, links: [] }, this.others);
  }

  /** Fill the view from a preset, below the bar at its top. */
  look(preset: Camera | undefined, robots: { box(links: number[]): Box3 }) {
    this.studio.look(preset, robots, this.bar);
  }
}
