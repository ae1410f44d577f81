import type { PageWith } from "../app.ts";
import type { Received } from "../received.ts";
import { SelfCollision } from "../robot/self_collision.ts";
import { entry } from "./legend.ts";
import { OVERLAP } from "./link_colours.ts";

type Page = PageWith<"colours" | "legend" | "panel" | "robot" | "toggles">;

/** Finds the links that overlap whenever the robot moves, and can show them in a colour of their own. */
export class Collisions {
  on = false;
  /** The pairs of links that overlap; null while Python has sent no hulls. */
  pairs: [number, number][] | null = null;
  private search: SelfCollision | null = null;

  constructor(readonly page: Page) {}

  receive(hulls: Received["hulls"]) {
    this.search = new SelfCollision(hulls);
    this.refresh();
    this.page.toggles.refresh();
    this.page.panel.readout.refresh();
  }

  show(on: boolean) {
    this.on = on;
    this.paint();
  }

  refresh() {
    const { nodes } = this.page.robot;
    this.pairs = this.search?.overlapping((link) => nodes[link].matrixWorld.elements) ?? null;
    this.paint();
  }

  private paint() {
    const { colours, legend } = this.page;
    const links = new Set(this.on ? this.pairs?.flat() : []);
    // The legend is built anew only when it changes: it may move the picture.
    if (colours.setOverlapping(links)) {
      legend.set("overlap", links.size > 0 ? [entry("links that overlap", OVERLAP)] : []);
    }
  }
}
