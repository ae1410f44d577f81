import type { PageWith } from "../app.ts";
import { makeTriad } from "../scene/extras.ts";
import { asMark, dispose } from "../scene/marks.ts";
import { THREE } from "../three.ts";
import { frameOf } from "./facts.ts";
import { Hover } from "./hover.ts";
import { Measure } from "./measure.ts";
import { Picker, Viewport } from "./picker.ts";

type Page = PageWith<"labels" | "panel" | "robot" | "studio" | "viewer">;

const SIZE = 0.062;

/** The frame that is looked at: drawn as a triad with its name. Event of the page: "selected", of any click. */
class Selection {
  /** The one that the panel reads: selected last. It begins with a hand: the poses of a head and of a torso change little. */
  read: string;
  frame: string | null = null;
  triad: THREE.Group | null = null;

  constructor(readonly page: Page) {
    const { limbs, effectors, frames } = page.robot.about;
    this.read = limbs.find(({ kind }) => kind === "arm")?.frame ?? effectors[0] ?? frames[0].name;
  }

  /** Number of the link that the frame belongs to. */
  get link() {
    return this.frame === null ? null : this.page.robot.linkOf(this.frame);
  }

  selectLink(link: number) {
    this.select(frameOf(this.page.robot.about, link));
  }

  /** @param frame that the panel reads from now on, drawn or not */
  follow(frame: string) {
    this.read = frame;
    this.page.dispatchEvent(new Event("selected"));
  }

  /** @param frame null for none */
  select(frame: string | null) {
    if (frame !== this.frame) this.draw(frame);
    this.follow(frame ?? this.read);
  }

  draw(frame: string | null) {
    this.frame = frame;
    if (this.triad) dispose(this.triad);
    this.triad = null;
    if (frame !== null) {
      this.triad = asMark(makeTriad(SIZE * this.page.studio.markScale));
      this.page.robot.frameNode(frame).add(this.triad);
    }
    this.page.labels.set(this, this.triad && frame !== null ? [{ text: frame, node: this.triad }] : []);
    this.page.viewer.set_dirty();
  }
}

/** What the pointer is over, what is selected, and what is measured. */
export class Pick {
  viewport: Viewport;
  picker: Picker;
  hover: Hover;
  selection: Selection;
  measure: Measure;

  constructor(page: Page, pane: HTMLElement) {
    this.viewport = new Viewport(page.viewer, pane);
    this.picker = new Picker(page.robot, this.viewport);
    this.hover = new Hover(page, this.picker, pane);
    this.selection = new Selection(page);
    this.measure = new Measure(page);
  }
}
