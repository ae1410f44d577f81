import type { App } from "./app.ts";

/** A configuration, and the vertical in the root's frame where it is given. */
export interface Snapshot {
  q: number[];
  up: ArrayLike<number> | null;
}

/** How the page's own robot is: its configuration, which direction is up and who says so; and all that follows from it. */
export class Stance {
  /** The vertical in the root's frame, where it is given. */
  up: ArrayLike<number> | null = null;
  /** The numbers that the scene was last brought up to date with. */
  settled: number[] | null = null;
  /** Whether the configuration comes from this page, and nobody has been told. */
  unreported = false;
  /** Whether the robot was moved last by somebody in a page. */
  movedByHand = false;
  /** Whether the clip says which direction is up, as long as nothing else moves the robot. */
  followsClip = false;

  constructor(readonly page: App) {}

  get q() {
    return this.page.robot.q;
  }

  /** @returns what no later change reaches */
  snapshot(): Snapshot {
    return { q: [...this.q], up: this.up };
  }

  // --- who moves the robot -------------------------------------------------------------------------------------

  /**
   * Show a configuration.
   *
   * @param up the vertical in the root's frame; null for what the robot stands on by itself
   * @param report it to whoever serves the page: it comes from here
   */
  set(q: number[], up: ArrayLike<number> | null = this.up, report: boolean = true) {
    const { player } = this.page;
    if (player.loaded) player.pause();
    this.put(q, up, report);
  }

  /** The same, for what is played: it goes on. */
  put(q: number[], up: ArrayLike<number> | null, report: boolean) {
    this.q.splice(0, q.length, ...q);
    this.followsClip = false;
    this.up = up;
    this.unreported = report;
    this.movedByHand ||= report;
    this.page.viewer.set_dirty();
  }

  /** Show a configuration that is no small step from the one before: it is set down as if it were the first. */
  jump(q: number[], up: ArrayLike<number> | null = null) {
    this.setDownAnew();
    this.set(q, up);
  }

  /**
   * Show a configuration that comes from elsewhere.
   *
   * @param byHand whether somebody moved the robot in a page
   */
  display(q: number[], up: ArrayLike<number> | null, byHand: boolean) {
    // What was done by hand says nothing about what the program shows next.
    if (this.movedByHand && !byHand) this.setDownAnew();
    this.set(q, up, false);
    this.movedByHand = byHand;
  }

  followClip() {
    this.up = null;
    this.followsClip = true;
  }

  // No clip any more. meshcat's animator then puts back what it found before the clip, which is out of date.
  still() {
    const { q, up } = this.snapshot();
    this.page.player.unload();
    this.set(q, up, false);
  }

  /** @param column of q */
  move(column: number, value: number) {
    this.set(this.q.with(column, value));
  }

  posture(name: string) {
    const { postures, floating } = this.page.robot.about;
    const posture = postures.find((candidate) => candidate.name === name);
    if (!posture) return;
    this.jump(floating ? [...this.q.slice(0, 7), ...posture.q.slice(7)] : posture.q);
  }

  // --- what follows from it ------------------------------------------------------------------------------------

  /** Bring the scene up to date with the joint values, whoever wrote them; on every frame that is drawn. */
  settle() {
    const { robot, player, shown, drag, studio, ghosts, balance, eyes, panel, reports } = this.page;
    if (!robot) return;
    player.refresh();
    if (this.followsClip) this.up = Math.hypot(...robot.clipUp) > 1e-6 ? [...robot.clipUp] : null;
    const now = [...this.q, ...Array.from(this.up ?? [])];
    if (this.settled?.length === now.length && now.every((value, i) => value === this.settled?.[i])) return;
    this.settled = now;
    shown.settle(this.up, drag.held !== null);
    if (robot.about.floating) studio.goAlong(this.q[0], this.q[1]);
    ghosts.refresh();
    studio.moved();
    balance.draw();
    eyes.drawGround();
    panel.refresh();
    if (this.followsClip) reports.playing("clip", this.q);
    const own = this.unreported;
    if (own) reports.joints();
    this.unreported = false;
    this.page.dispatchEvent(new CustomEvent("settled", { detail: { own } }));
  }

  // Put the robot on the floor again, which it keeps off while it is dragged.
  restand() {
    this.settled = null;
    this.page.viewer.set_dirty();
  }

  // As if nothing had been shown before.
  setDownAnew() {
    this.page.shown.standing.forget();
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
