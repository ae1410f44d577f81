import type { Received } from "../received.ts";

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

/** Numbers over time that the program plots. Event: "points". */
export class Streams extends EventTarget {
  live: Map<string, Stream> = new Map();

  add({ name, run, lines, first, margins, times, values }: Received["plot"]) {
    let stream = this.live.get(name);
    if (stream?.run !== run) this.live.set(name, (stream = { run, lines, chunks: new Map(), count: 0, margins }));
    stream.chunks.set(first, { times, values });
    stream.count = Math.max(stream.count, first + times.length);
    for (const other of stream.chunks.keys()) if (other < stream.count - MOST) stream.chunks.delete(other);
    this.dispatchEvent(new Event("points"));
  }

  keep(names: string[]) {
    for (const name of [...this.live.keys()]) if (!names.includes(name)) this.live.delete(name);
    this.dispatchEvent(new Event("points"));
  }

  /** The curves by the title of their plot. */
  curves(): Map<string, Curves> {
    return new Map(
      [...this.live].map(([name, { lines, chunks, margins }]) => {
        const made: Curves = { lines, times: [], values: lines.map(() => []), margins };
        for (const [, chunk] of [...chunks].sort(([a], [b]) => a - b)) append(made, chunk);
        return [name, made];
      }),
    );
  }
}

function append({ lines, times, values }: Curves, chunk: Chunk) {
  chunk.times.forEach((time, i) => {
    times.push(time);
    values.forEach((column, line) => {
      const value = chunk.values[i * lines.length + line];
      column.push(Number.isNaN(value) ? null : value);
    });
  });
}
