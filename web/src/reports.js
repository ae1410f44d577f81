// Time between two reports of where a clip is [ms].
const BETWEEN_CLIPS = 50;

/** What the program behind the page is told of where the robot is. */
export class Reports {
  /** Who this page is. */
  source = String(Math.random());
  /** How many configurations it has told. */
  count = 0;
  /** The report of where the clip is that is to be sent. @type {ReturnType<typeof setTimeout> | undefined} */
  waiting;

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /** A configuration that comes from this page. */
  joints() {
    this.count += 1;
    const { q, up } = this.app;
    this.app.send({ kind: "joints", q: [...q], up, source: `${this.source} ${this.count}` });
  }

  /** Where the clip is, not at every picture. */
  clip() {
    if (this.app.role !== "") return;
    this.waiting ??= setTimeout(() => {
      this.waiting = undefined;
      if (this.app.followsClip) this.app.send({ kind: "clip", q: [...this.app.q] });
    }, BETWEEN_CLIPS);
  }
}
