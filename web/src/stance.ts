import type { App } from "./app.ts";

/** A configuration, and the vertical in the root's frame if it is given. */
export interface Snapshot {
  q: number[];
  up: ArrayLike<number> | null;
}

/** The configuration of the page's own robot and its vertical, where these come from, and the update of the scene. */
export class Stance {
  /** The vertical in the root's frame; null if it is not given. */
  up: ArrayLike<number> | null = null;
  /** The configuration and the vertical that the scene last showed. */
  settled: number[] | null = null;
  /** Whether the configuration comes from this page and has not been reported yet. */
  unreported = false;
  /** Whether the robot was last moved by a user, in this page or another. */
  movedByHand = false;
  /** The posture that was chosen last in this page. */
  chosen: { name: string; q: number[] } | null = null;

  constructor(readonly page: App) {}

  get q() {
    return this.page.robot.q;
  }

  /** @returns copies, which later changes do not affect */
  snapshot(): Snapshot {
    return { q: [...this.q], up: this.up };
  }

  // --- changes of the configuration ----------------------------------------------------------------------------

  /**
   * Show a configuration.
   *
   * @param up the vertical in the root's frame; null to let the page place the robot on the floor
   * @param report whether to report it to the program, because it comes from this page
   */
  set(q: number[], up: ArrayLike<number> | null = this.up, report: boolean = true) {
    const { player, reports } = this.page;
    if (player.loaded) player.pause();
    reports.waiting = null;
    this.put(q, up, report);
  }

  /** The same during playback, which continues. */
  put(q: number[], up: ArrayLike<number> | null, report: boolean) {
    this.q.splice(0, q.length, ...q);
    this.up = up;
    this.unreported = report;
    this.movedByHand ||= report;
    this.page.viewer.set_dirty();
  }

  /** Show a configuration that may be far from the one before: the robot is placed as if it were shown first. */
  jump(q: number[], up: ArrayLike<number> | null = null) {
    this.setDownAnew();
    this.set(q, up);
  }

  /**
   * Show a configuration from the program or another page.
   *
   * @param byHand whether a user moved the robot in a page
   */
  display(q: number[], up: ArrayLike<number> | null, byHand: boolean) {
    // How the robot stood after a user moved it must not affect how it stands in the program's next configuration.
    if (this.movedByHand && !byHand) this.setDownAnew();
    this.set(q, up, false);
    this.movedByHand = byHand;
  }

  /** @param column of q */
  move(column: number, value: number) {
    this.set(this.q.with(column, value));
  }

  posture(name: string) {
    const { postures } = this.page.robot.about;
    const posture = postures.find((candidate) => candidate.name === name);
    if (!posture) return;
    this.choose(name, { q: posture.q, up: null });
  }

  /** Show a named configuration; a floating base stays where it is. */
  choose(name: string, { q, up }: Snapshot) {
    const { floating } = this.page.robot.about;
    this.chosen = { name, q: floating ? [...this.q.slice(0, 7), ...q.slice(7)] : q };
    const { page } = this;
    const wasInSight = page.isInSight;
    this.jump(this.chosen.q, up);
    this.settle();
    if (wasInSight && !page.isInSight) page.frame();
  }

  // --- the scene -----------------------------------------------------------------------------------------------

  /** Bring the scene up to date with the configuration, wherever it comes from; called for every frame. */
  settle() {
    const { robot, player, shown, drag, studio, ghosts, others, balance, collisions, eyes, panel, reports } = this.page;
    if (!robot) return;
    player.refresh();
    const now = [...this.q, ...Array.from(this.up ?? [])];
    if (this.settled?.length === now.length && now.every((value, i) => value === this.settled?.[i])) return;
    this.settled = now;
    shown.settle(this.up, drag.held !== null);
    if (robot.about.floating) studio.goAlong(this.q[0], this.q[1]);
    ghosts.refresh();
    others.follow();
    studio.moved();
    balance.draw();
    collisions.refresh();
    eyes.drawGround();
    panel.refresh();
    const own = this.unreported;
    if (own) reports.joints();
    this.unreported = false;
    this.page.dispatchEvent(new CustomEvent("settled", { detail: { own } }));
  }

  // Place the robot on the floor again; while it is dragged, the trunk stays where it is.
  restand() {
    this.settled = null;
    this.page.viewer.set_dirty();
  }

  // Place the robot on the floor as if it had not been shown before.
  setDownAnew() {
    this.page.shown.standing.forget();
    if (!this.page.robot.about.floating) this.page.studio.floor.goBack();
    this.restand();
  }

  /** Pose of a frame in the robot's root, row by row. */
  pose(frame: string) {
    this.settle();
    const { robot } = this.page;
    return robot.pose(robot.linkOf(frame)).transpose().toArray();
  }

  com() {
    this.settle();
    return this.page.robot.com()?.toArray() ?? null;
  }
}
