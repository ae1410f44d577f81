import type { PageWith } from "./app.ts";

type Page = PageWith<"role" | "send" | "stance">;

/**
 * Whether a configuration that the program sends is one that this page reported itself, and has since replaced.
 *
 * The program sends every page what was reported last, its own report included. A page that took the older ones would
 * jerk back under the hand that drags it; one that took none would keep a configuration that another page, whose report
 * arrived in between, knows nothing of.
 *
 * @param source who reported it, a space, and a number that grows
 * @param mine who this page is
 * @param newest number of its newest report
 * @param plays whether a motion goes on here, which its own reports are not to stop
 */
export function isOutdated(source: string, mine: string, newest: number, plays: boolean = false) {
  const [who, number] = source.split(" ");
  return who === mine && (plays || Number(number) < newest);
}

// Time between two reports of where what is played is [ms].
const BETWEEN = 1000 / 30;

/** What the program behind the page is told of where the robot is. */
export class Reports {
  /** Who this page is. */
  source = String(Math.random());
  /** How many configurations it has had to tell; those told before are out of date when they come back. */
  count = 0;
  /** Whether somebody has begun to play, or gone to a time, and the program has not been told. */
  begins = false;
  /** What is played, and is to be told next. */
  waiting: { kind: "clip" | "played"; q: number[] } | null = null;

  constructor(readonly page: Page) {}

  /** A configuration that somebody has made in this page. */
  joints() {
    this.count += 1;
    this.send({ kind: "joints", ...this.page.stance.snapshot() });
  }

  /**
   * Where what is played is, not at every picture.
   *
   * @param kind whether it is the program's clip, which every page plays for itself, or of this page
   */
  playing(kind: "clip" | "played", q: readonly number[]) {
    if (this.page.role !== "") return;
    if (!this.waiting) setTimeout(() => this.sendWaiting(), BETWEEN);
    this.waiting = { kind, q: [...q] };
    this.count += 1;
  }

  sendWaiting() {
    const { waiting, begins } = this;
    this.waiting = null;
    // Somebody else may move the robot by now.
    if (!waiting || (waiting.kind === "clip" && !this.page.stance.followsClip)) return;
    this.begins = false;
    this.send({ ...waiting, begins });
  }

  send(report: object) {
    this.page.send({ ...report, source: `${this.source} ${this.count}` });
  }
}
