import type { Received } from "../received.ts";
import type { Motion } from "../timeline/motion.ts";

/** Points of some lines: a time for each, and a value of each line, NaN for none. */
interface Chunk {
  times: Float64Array;
  values: Float64Array;
}

/** A plot of the program: its lines, and their points by the index of the first one of each message. */
interface Stream {
  run: number;
  lines: string[];
  chunks: Map<number, Chunk>;
  /** How many points have come. */
  count: number;
}

/** What is drawn of a plot. */
export interface Curves {
  lines: string[];
  times: number[];
  /** of each line */
  values: (number | null)[][];
}

// Points of a plot that are kept.
const MOST = 100_000;

/** Numbers over time that the program plots, and those of a recording in this page. Event: "points". */
export class Streams extends EventTarget {
  live: Map<string, Stream> = new Map();
  recorded = new WeakMap<Motion, Map<string, Curves>>();
  /** What has come since a recording began; `from`: the time of a plot's points at which that was. */
  recording: { time: () => number; from: Map<string, number>; plots: Map<string, Curves> } | null = null;

  add({ name, run, lines, first, times, values }: Received["plot"]) {
    let stream = this.live.get(name);
    if (stream?.run !== run) this.live.set(name, (stream = { run, lines, chunks: new Map(), count: 0 }));
    stream.chunks.set(first, { times, values });
    const known = Math.max(0, stream.count - first);
    stream.count = Math.max(stream.count, first + times.length);
    for (const other of stream.chunks.keys()) if (other < stream.count - MOST) stream.chunks.delete(other);
    this.record(name, lines, { times: times.subarray(known), values: values.subarray(known * lines.length) });
    this.dispatchEvent(new Event("points"));
  }

  keep(names: string[]) {
    for (const name of [...this.live.keys()]) if (!names.includes(name)) this.live.delete(name);
    this.dispatchEvent(new Event("points"));
  }

  /** What is drawn with a motion, or live: by the title of the plot. */
  curves(motion: Motion | null): Map<string, Curves> {
    const recorded = motion && this.recorded.get(motion);
    if (recorded) return recorded;
    return new Map(
      [...this.live].map(([name, { lines, chunks }]) => {
        const made = empty(lines);
        for (const [, chunk] of [...chunks].sort(([a], [b]) => a - b)) append(made, chunk);
        return [name, made];
      }),
    );
  }

  /** @param time since a recording began, which begins now [s] */
  begin(time: () => number) {
    this.recording = { time, from: new Map(), plots: new Map() };
  }

  end(motion: Motion | null | undefined) {
    if (motion && this.recording?.plots.size) this.recorded.set(motion, this.recording.plots);
    this.recording = null;
  }

  record(name: string, lines: string[], { times, values }: Chunk) {
    const { recording } = this;
    if (!recording || times.length === 0) return;
    const curves = recording.plots.get(name) ?? empty(lines);
    // Points have the program's time: the newest one has come just now.
    const from = recording.from.get(name) ?? times[times.length - 1] - recording.time();
    const shifted = times.map((time) => time - from);
    // What begins anew, or was made before the recording, is no part of it.
    if (curves.times.length >= MOST || shifted[0] < Math.max(0, curves.times.at(-1) ?? 0)) return;
    recording.from.set(name, from);
    recording.plots.set(name, curves);
    append(curves, { times: shifted, values });
  }
}

const empty = (lines: string[]): Curves => ({ lines, times: [], values: lines.map(() => []) });

function append({ lines, times, values }: Curves, chunk: Chunk) {
  chunk.times.forEach((time, i) => {
    times.push(time);
    values.forEach((column, line) => {
      const value = chunk.values[i * lines.length + line];
      column.push(Number.isNaN(value) ? null : value);
    });
  });
}
