import { matches } from "../values/names.ts";
import { element } from "./element.ts";
import { JointRow } from "./joint_row.ts";
import type { Panel } from "./panel.ts";

/** The joints in their chains, one slider each, and a field that looks for some of them. */
export class Joints {
  rows: JointRow[] = [];
  chains;
  search = element("input", { type: "search", placeholder: "Filter joints", ariaLabel: "Filter joints" });
  count = element("output", { className: "count" });
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    const { chains } = panel.app.robot.about;
    const shown = chains.flatMap(({ joints }) => joints).filter(({ follows }) => follows);
    const followers = new Map(shown.map(({ name, follows }) => [follows, name]));
    this.chains = chains.map(({ title, joints }) => {
      const rows = joints.map((joint) => {
        const row = new JointRow(panel, joint, joint.follows || followers.get(joint.name) || "", this.rows.length);
        this.rows.push(row);
        return row;
      });
      const summary = element("summary", {}, title);
      return { rows, details: element("details", { open: true }, summary, ...rows.map((row) => row.element)) };
    });
    this.search.oninput = () => this.filter();
    this.search.onkeydown = (event) => {
      if (event.key !== "Escape" || !this.search.value) return;
      event.preventDefault();
      this.search.value = "";
      this.filter();
    };
    this.element = element(
      "section",
      { className: "joints", id: "joints", tabIndex: -1, ariaLabel: "Joints" },
      element("div", { className: "search" }, this.search, this.count),
      ...this.chains.map(({ details }) => details),
    );
    this.element.hidden = this.rows.length === 0;
    this.filter();
  }

  filter() {
    const sought = this.search.value.trim();
    let found = 0;
    for (const { rows, details } of this.chains) {
      const here = rows.filter((row) => (row.element.hidden = !matches(row.joint.name, sought)) === false);
      details.hidden = here.length === 0;
      if (sought && here.length > 0) details.open = true;
      found += here.length;
    }
    const all = this.rows.length;
    this.count.textContent = sought ? `${found} of ${all}` : `${all} joint${all === 1 ? "" : "s"}`;
  }

  refresh() {
    const { robot, shown } = this.panel.app;
    for (const row of this.rows) row.refresh(robot.q, shown.outside.has(row.joint.column));
  }

  relabel() {
    for (const row of this.rows) row.relabel();
    this.refresh();
  }
}
