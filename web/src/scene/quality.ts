/**
 * How a frame is drawn, from the best level to the fastest: `fine` in the quality of the picture at rest, `ratio` pixels per
 * pixel of the screen, and shadows drawn again in every frame or in every second one.
 */
export const LEVELS = [
  { fine: true, ratio: 1, shadows: 1 },
  { fine: false, ratio: 1, shadows: 1 },
  { fine: false, ratio: 0.75, shadows: 2 },
  { fine: false, ratio: 0.5, shadows: 2 },
];

// Times in milliseconds: a frame above SLOW is too slow, one below QUICK leaves time for better quality; REST after the
// last change the picture is at rest; changes within CONTINUOUS of each other are a movement.
const [SLOW, QUICK] = [40, 19];
export const REST = 150;
const CONTINUOUS = 400;
// The number of frames over which the time is averaged, and after which a better level is tried; this number doubles
// each time the better level fails, up to MOST_PATIENCE.
const [AVERAGE, PATIENCE, MOST_PATIENCE] = [4, 40, 5000];

/**
 * Chooses how to draw each frame from the time that the last frames took, without any other knowledge of the graphics card.
 * All times are in milliseconds.
 */
export class Quality {
  // Not the best level at first, which may be too slow; a fast graphics card reaches it after a second of movement.
  level = 1;
  patience = PATIENCE;
  changedAt = -Infinity;
  moving = false;
  // Whether a pointer holds the view, so that the first change counts as part of a movement.
  expected = false;
  frames = 0;
  /** The better level that was tried last; null if a level has been too slow since. */
  triedAt: number | null = null;
  time = 0;
  quick = 0;

  /**
   * Choose how to draw the current frame. A single change is drawn in the best quality immediately, so nothing flickers.
   *
   * @param changed whether robot or camera have moved since the last frame
   */
  next(now: number, changed: boolean) {
    if (changed) {
      this.moving = this.expected || now - this.changedAt < CONTINUOUS;
      this.changedAt = now;
    } else if (now - this.changedAt >= REST) {
      this.moving = false;
    }
    return this.moving ? LEVELS[this.level] : LEVELS[0];
  }

  /** Take the time that a frame with a change took until the next frame could begin. */
  took(now: number, time: number) {
    this.changedAt = now;
    if (!this.moving) return;
    this.frames += 1;
    this.time += time;
    this.quick = time < QUICK ? this.quick + 1 : 0;
    if (this.frames >= AVERAGE || time > AVERAGE * SLOW) {
      const isSlow = this.time > this.frames * SLOW;
      [this.frames, this.time] = [0, 0];
      if (isSlow && this.level < LEVELS.length - 1) {
        if (this.triedAt === this.level) this.patience = Math.min(2 * this.patience, MOST_PATIENCE);
        this.triedAt = null;
        // If it is far too slow, the levels between are skipped.
        this.level = time > 3 * AVERAGE * SLOW ? LEVELS.length - 1 : this.level + 1;
        this.quick = 0;
      }
    }
    if (this.quick > this.patience && this.level > 0) {
      this.level -= 1;
      this.triedAt = this.level;
      this.frames = this.time = this.quick = 0;
    }
  }
}
