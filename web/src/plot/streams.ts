import type { Received } from "../received.ts";
import type { Motion } from "../timeline/motion.ts";

/** Points of some lines: the time of each point, and one value per line, NaN for no value. */
type Chunk = Pick<Received["plot"], "times" | "values">;

/** A plot of the program: its lines and their points, in chunks by the index of the chunk's first point. */
interface Stream {
  run: number;
  lines: string[];
  chunks: Map<number, Chunk>;
  /** Number of points received. */
  count: number;
  /** Whether the lines are margins of the program's clip, shown with it. */
  margins: boolean;
}

/** The curves of a plot, as they are drawn. */
export interface Curves {
  lines: string[];
  times: number[];
  /** The values of each line. */
  values: (number | null)[][];
  margins: boolean;
}

// The largest number of points kept for a plot.
const MOST = 100_000;

/** Numbers over time that the program plots, and those of a recording in this page. Event: "points". */
export class Streams extends EventTarget {
  live: Map<string, Stream> = new Map();
  recorded = new WeakMap<Motion, Map<string, Curves>>();
  /** The points since a recording began; `from` is the time of that beginning on the clock of each plot. */
  recording: { time: () => number; from: Map<string, number>; plots: Map<string, Curves> } | null = null;

  add({ name, run, lines, first, margins, times, values }: Received["plot"]) {
    let stream = this.live.get(name);
    if (stream?.run !== run) this.live.set(name, (stream = { run, lines, chunks: new Map(), count: 0, margins }));
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

  /** The curves by the title of their plot: those recorded with a motion, else the live ones. */
  curves(motion: Motion | null): Map<string, Curves> {
    const recorded = motion && this.recorded.get(motion);
    if (recorded) return recorded;
    return new Map(
      [...this.live].map(([name, { lines, chunks, margins }]) => {
        const made = { ...empty(lines), margins };
        for (const [, chunk] of [...chunks].sort(([a], [b]) => a - b)) append(made, chunk);
        return [name, made];
      }),
    );
  }

  /** @param time gives the time since the recording began [s]; it begins now */
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
    // Points carry the program's time; the newest one has just arrived.
    const from = recording.from.get(name) ?? times[times.length - 1] - recording.time();
    const shifted = times.map((time) => time - from);
    // Points from before the recording, or whose time went back, are not recorded.
    if (curves.times.length >= MOST || shifted[0] < Math.max(0, curves.times.at(-1) ?? 0)) return;
    recording.from.set(name, from);
    recording.plots.set(name, curves);
    append(curves, { times: shifted, values });
  }
}

const empty = (lines: string[]): Curves => ({ lines, times: [], values: lines.map(() => []), margins: false });

function append({ lines, times, values }: Curves, chunk: Chunk) {
  chunk.times.forEach((time, i) => {
    times.push(time);
    values.forEach((column, line) => {
      const value = chunk.values[i * lines.length + line];
      column.push(Number.isNaN(value) ? null : value);
    });
  });
}
