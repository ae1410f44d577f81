import assert from "node:assert/strict";
import { test } from "node:test";
import { Motion } from "../src/timeline/motion.ts";
import { MotionPlayback } from "../src/timeline/playback.ts";

/** A browser's requests for the next picture, which come when they are told to. */
class Pictures {
  constructor() {
    /** @type {Map<number, (now: number) => void>} */
    this.waiting = new Map();
    this.count = 0;
    /** @param {(now: number) => void} step */
    globalThis.requestAnimationFrame = (step) => {
      this.waiting.set(++this.count, step);
      return this.count;
    };
    globalThis.cancelAnimationFrame = (request) => this.waiting.delete(request);
  }

  /** @param {number} now */
  draw(now) {
    const steps = [...this.waiting.values()];
    this.waiting.clear();
    for (const step of steps) step(now);
  }
}

test("what is paused and played again between two pictures goes on at its own speed", () => {
  const pictures = new Pictures();
  const playback = new MotionPlayback(Motion.of([0, 10], [[0], [10]]), () => {});
  playback.play();
  playback.pause();
  playback.play();
  const start = performance.now();
  pictures.draw(start + 1000);
  pictures.draw(start + 2000);
  assert.equal(pictures.waiting.size, 1);
  assert.ok(playback.time > 1.9 && playback.time < 2.1, `${playback.time} s after two seconds`);
});

test("what is paused is drawn no more", () => {
  const pictures = new Pictures();
  const playback = new MotionPlayback(Motion.of([0, 10], [[0], [10]]), () => {});
  playback.play();
  playback.pause();
  assert.equal(pictures.waiting.size, 0);
});
