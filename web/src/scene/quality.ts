/**
 * How a frame is drawn: with all that the resting picture has or not, at how many pixels for one of the screen's, and with
 * shadows drawn anew in every frame or in each second one.
 */
interface Level {
  fine: boolean;
  ratio: number;
  shadows: number;
}

/** The levels from the best to the fastest. */
export const LEVELS: Level[] = [
  { fine: true, ratio: 1, shadows: 1 },
  { fine: false, ratio: 1, shadows: 1 },
  { fine: false, ratio: 0.75, shadows: 2 },
  { fine: false, ratio: 0.5, shadows: 2 },
];

// Milliseconds: a frame that takes longer is too slow, one that takes less leaves room; so long after the last change
// the picture is at rest; changes that follow each other within so long are a movement.
const [SLOW, QUICK] = [40, 19];
export const REST = 150;
const CONTINUOUS = 400;
// Frames over which the time is averaged, and after which a better level is tried; each time that fails, twice as many.
const [AVERAGE, PATIENCE, MOST_PATIENCE] = [4, 40, 5000];

/**
 * Chooses how to draw each frame from how long the last ones took: nothing is asked of the graphics card but its speed.
 * All times are in milliseconds.
 */
export class Quality {
  // Where it may be too slow to begin with the best; a fast one is there after a second of movement.
  level = 1;
  patience = PATIENCE;
  changedAt = -Infinity;
  moving = false;
  // While a pointer holds the view, its first change is one of many.
  expected = false;
  frames: number;
  /** The level that was tried last, and has not failed. */
  triedAt: number | null = null;
  time: number;
  quick: number;

  constructor() {
    this.frames = this.time = this.quick = 0;
  }

  /**
   * How to draw the frame of now. One change alone is drawn at its best at once: nothing flickers.
   *
   * @param changed whether robot or camera have moved since the last frame
   */
  next(now: number, changed: boolean): Level {
    if (changed) {
      this.moving = this.expected || now - this.changedAt < CONTINUOUS;
      this.changedAt = now;
    } else if (now - this.changedAt >= REST) {
      this.moving = false;
    }
    return this.moving ? LEVELS[this.level] : LEVELS[0];
  }

  /** A frame with a change has been drawn by now, and took so long until the next one could begin. */
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
        // Far too slow, it is not worth trying the levels between.
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
