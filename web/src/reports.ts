import type { App } from "./app.ts";

/**
 * Whether a configuration that the program sends is an old report of this page, which the page has since replaced.
 *
 * The program sends the last report to every page, also to the page that made it. If a page showed its own older reports,
 * the robot would jump back during a drag. If it ignored all its own reports, it would keep a configuration that another
 * page, whose report arrived in between, does not have.
 *
 * @param source the name of the page that reported it, or of the program, a space, and an increasing number
 * @param mine the name of this page
 * @param newest number of its newest report
 * @param plays whether this page plays a motion, which its own reports must not stop
 */
export function isOutdated(source: string, mine: string, newest: number, plays: boolean = false) {
  const [who, number] = source.split(" ");
  return who === mine && (plays || Number(number) < newest);
}

// Time between two reports of the configuration during playback, and of the camera [ms].
const [BETWEEN, BETWEEN_LOOKS] = [1000 / 30, 100];

/**
 * What the user changes of what the program shows, its targets or controls, by name: the program is told within 1/30 s, and
 * undo restores it.
 */
export class Changes<Row, Value> {
  /** The latest values of what was changed in this page. */
  kept = new Map<string, Value>();
  /** The rows that have not been reported to the program yet. */
  waiting = new Set<Row>();

  constructor(
    readonly page: EventTarget,
    readonly send: (row: Row) => void,
  ) {}

  later(row: Row) {
    if (this.waiting.size === 0) setTimeout(() => this.report(), BETWEEN);
    this.waiting.add(row);
  }

  report() {
    this.waiting.forEach(this.send);
    this.waiting.clear();
  }

  /**
   * Remember a value, for undo. Event of the page: "placed".
   *
   * @param own whether the user has just changed it in this page
   */
  note(name: string, value: Value, own: boolean) {
    this.kept = new Map(this.kept).set(name, value);
    this.page.dispatchEvent(new CustomEvent("placed", { detail: { own } }));
  }

  /** Set what differs from earlier values. */
  restore(kept: Map<string, Value>, put: (name: string, value: Value) => void) {
    for (const [name, value] of kept) if (String(value) !== String(this.kept.get(name))) put(name, value);
    this.kept = kept;
  }
}

/** Reports the configuration of the robot to the program. */
export class Reports {
  /** The name of this page. */
  source = String(Math.random());
  /** Number of the newest report; older reports are outdated when they come back. */
  count = 0;
  /** Whether the user started playback or moved to a time, and this has not been reported yet. */
  begins = false;
  /** The next report of playback. */
  waiting: { kind: "clip" | "played"; q: number[] } | null = null;

  /** The next report of the camera, and the last one. */
  looking = 0;
  looked = "";

  /** The targets and controls as the program sent them last on this connection. */
  heard = new Map<string, string>();

  constructor(readonly page: App) {}

  /**
   * Whether a target or control is sent because it has changed, and not with another one that has: the program sends its
   * lists whole, and what it has not changed must not replace what the user has changed in the meantime.
   *
   * @param key of the list and the row
   * @param newest number of the newest change of the row in this page
   */
  isNews(key: string, row: { source?: string; [part: string]: unknown }, newest: number) {
    const text = JSON.stringify(row);
    const isNew = this.heard.get(key) !== text && !isOutdated(row.source ?? "", this.source, newest);
    this.heard.set(key, text);
    return isNew;
  }

  /** Report a configuration that the user made in this page. */
  joints() {
    this.count += 1;
    this.send({ kind: "joints", ...this.page.stance.snapshot() });
  }

  /**
   * Report the configuration that playback shows, but not for every picture.
   *
   * @param kind "clip" for the program's clip, which every page plays itself; "played" for a motion of this page
   */
  playing(kind: "clip" | "played", q: readonly number[]) {
    if (this.page.role !== "") return;
    if (!this.waiting) setTimeout(() => this.sendWaiting(), BETWEEN);
    this.waiting = { kind, q: [...q] };
    this.count += 1;
  }

  /** Report where the camera is, if it has moved; called for every picture. */
  camera() {
    if (this.page.role !== "" || this.looking) return;
    this.looking = setTimeout(() => {
      this.looking = 0;
      const pose = this.page.cameraPose;
      const text = String(pose);
      if (text !== this.looked) this.send({ kind: "camera", pose });
      this.looked = text;
    }, BETWEEN_LOOKS);
  }

  sendWaiting() {
    const { waiting, begins } = this;
    this.waiting = null;
    // The robot may have been moved by something else in the meantime.
    if (!waiting) return;
    this.begins = false;
    this.send({ ...waiting, begins });
  }

  send(report: object) {
    this.page.send({ ...report, source: `${this.source} ${this.count}` });
  }
}
