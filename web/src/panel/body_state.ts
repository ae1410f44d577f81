import { THREE } from "../three.ts";
import { differences } from "../values/configurations.ts";
import { spoken, unitOf } from "../values/units.ts";
import { div, element, write } from "./element.ts";
import type { Panel } from "./panel.ts";

/** The directions over an edge, by quarters of a turn to the left from the front. */
const WAYS = ["forwards", "to the left", "backwards", "to the right"];
// A root whose x axis is steeper than this has no front: its horizontal part is shorter.
const LEVEL = 0.5;

/** In words, over which edge the robot would tip; empty where it has no front, as a robot that lies. */
function wayOver(over: { x: number; y: number }, front: { x: number; y: number }) {
  if (Math.hypot(front.x, front.y) < LEVEL) return "";
  const turn = Math.atan2(front.x * over.y - front.y * over.x, front.x * over.x + front.y * over.y);
  return WAYS[(Math.round((2 * turn) / Math.PI) + 4) % 4];
}

/** The line of the read-out that says whether the robot stands, and which of its links overlap. */
export class BodyState {
  // Screen readers read it on demand, not at every step of a motion.
  balance = element("output", { ariaLive: "off", ariaLabel: "Balance" });
  overlap = element("output", { ariaLive: "off", ariaLabel: "Overlaps" });
  element = div("body-state", this.balance, this.overlap);
  /** Whether the robot stands on feet: an arm that is bolted to the floor does not tip. */
  hasFeet = this.panel.page.robot.about.soles.length > 0;

  constructor(readonly panel: Panel) {}

  /** In words, over which edge the robot tips first. */
  get way() {
    const { balance, robot } = this.panel.page;
    const front = new THREE.Vector3().setFromMatrixColumn(robot.placement(), 0);
    return wayOver(balance.stand.over, front);
  }

  refresh() {
    const { balance, collisions, robot } = this.panel.page;
    const { centre, margin } = balance.stand;
    const text = (value: number) => spoken(value, unitOf("m", this.panel.settings.units));
    const stands = margin >= 0;
    say(
      this.balance,
      centre === null || !this.hasFeet
        ? ""
        : Number.isNaN(margin)
          ? "no support"
          : stands
            ? `margin ${text(margin)}`
            : `tips ${this.way}`,
      stands ? "good" : "bad",
      stands
        ? "Distance of the centre of mass, seen from above, from the edge of the support polygon"
        : `The centre of mass is ${Number.isNaN(margin) ? "above no support" : `${text(-margin)} outside the support polygon`}`,
    );
    const { pairs } = collisions;
    const names = (pairs ?? []).map((pair) => pair.map((link) => robot.about.links[link].title).join(", "));
    const overlap = names.length > 1 ? `${names.length} pairs overlap` : `overlap: ${names[0]}`;
    const none = "no links overlap";
    // The robot takes its own postures: meshes that overlap there are no alarm.
    const { postures } = robot.about;
    const own = names.length > 0 ? postures.find(({ q }) => differences(robot.about, q, robot.q).length === 0) : null;
    const known = own ? `\n${own.name} is a posture of the robot` : "";
    say(
      this.overlap,
      pairs === null ? "" : names.length > 0 ? overlap : none,
      known ? "known" : names.length > 0 ? "warn" : "good",
      `${names.join("\n") || none}${known}`,
    );
  }
}

function say(output: HTMLElement, text: string, state: "good" | "known" | "warn" | "bad", title: string) {
  write(output, text);
  output.dataset.state = state;
  output.title = title;
}
