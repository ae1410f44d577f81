// WebM files with one video track, written as RFC 8794 (EBML) and RFC 9559 (Matroska) describe them. The numbers are the
// identifiers of the elements.

/** An encoded picture, as WebCodecs gives it. */
export interface EncodedPicture {
  data: Uint8Array<ArrayBuffer>;
  /** Whether it can be decoded without the pictures before it; the first one can. */
  isKey: boolean;
}

export interface Track {
  codec: "vp09" | "vp8";
  width: number;
  height: number;
  /** Pictures per second. */
  fps: number;
}

type Bytes = Uint8Array<ArrayBuffer>;
type Content = number | string | Bytes | Element[];
type Element = [id: number, content: Content];

/** The bytes of a whole number, the largest first; by default as few as it needs. */
function wholeNumber(value: number, length: number = 1): Bytes {
  const bytes: number[] = [];
  for (let rest = value; rest > 0 || bytes.length < length; rest = Math.floor(rest / 256)) bytes.unshift(rest % 256);
  return Uint8Array.from(bytes);
}

function float(value: number): Bytes {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
}

function encodeContent(content: Content): Bytes[] {
  if (typeof content === "number") return [wholeNumber(content)];
  if (typeof content === "string") return [new TextEncoder().encode(content)];
  return Array.isArray(content) ? content.flatMap(encode) : [content];
}

const sizeOf = (parts: Bytes[]) => parts.reduce((sum, { length }) => sum + length, 0);

/** Identifier, size in seven bytes after a marker, and content. */
function encode([id, content]: Element): Bytes[] {
  const parts = encodeContent(content);
  return [wholeNumber(id), wholeNumber(1), wholeNumber(sizeOf(parts), 7), ...parts];
}

const CODECS = { vp09: "V_VP9", vp8: "V_VP8" };

function trackEntry({ codec, width, height, fps }: Track): Element {
  // BT.709 in the limited range, as `toPlanes` makes it.
  const colour = [0x55b1, 0x55b9, 0x55ba, 0x55bb].map((id): Element => [id, 1]);
  const video: Element[] = [
    [0xb0, width],
    [0xba, height],
    [0x55b0, colour],
  ];
  return [
    0xae,
    [
      [0xd7, 1], // number
      [0x73c5, 1], // UID
      [0x83, 1], // video
      [0x9c, 0], // no lacing
      [0x23e383, Math.round(1e9 / fps)], // time of a picture [ns]
      [0x86, CODECS[codec]],
      [0xe0, video],
    ],
  ];
}

/** The pictures from one key picture to the next: at most 32 s, because their times are relative, with 16 bits. */
function cluster(pictures: EncodedPicture[], first: number, time: (number: number) => number): Element {
  const blocks = pictures.map(({ data, isKey }, i): Element => {
    const after = time(first + i) - time(first);
    // Track 1, the time after the cluster's, and a flag.
    const head = [0x81, ...wholeNumber(after, 2), isKey ? 0x80 : 0];
    const block = new Uint8Array(head.length + data.length);
    block.set(head);
    block.set(data, head.length);
    return [0xa3, block];
  });
  return [0x1f43b675, [[0xe7, time(first)], ...blocks]];
}

/**
 * Return the parts of a WebM file with these pictures, one after another at the track's rate.
 *
 * An index of the key pictures stands before them, so that a player can go to any time.
 */
export function webm(track: Track, pictures: EncodedPicture[]): Bytes[] {
  const time = (number: number) => Math.round((1000 * number) / track.fps);
  const firsts = pictures.flatMap(({ isKey }, i) => (isKey ? [i] : []));
  const clusters = firsts.map((first, k) => encode(cluster(pictures.slice(first, firsts[k + 1]), first, time)));
  const about: Element[] = [
    [0x2ad7b1, 1_000_000], // unit of times [ns]
    [0x4489, float((1000 * pictures.length) / track.fps)],
    [0x4d80, "nao_kin"],
    [0x5741, "nao_kin"],
  ];
  const before = [...encode([0x1549a966, about]), ...encode([0x1654ae6b, [trackEntry(track)]])];
  const index = (places: number[]) => {
    const points = firsts.map((first, k): Element => {
      const place: Element[] = [
        [0xf7, 1],
        [0xf1, wholeNumber(places[k], 7)],
      ];
      const point: Element[] = [
        [0xb3, time(first)],
        [0xb7, place],
      ];
      return [0xbb, point];
    });
    return encode([0x1c53bb6b, points]);
  };
  // The size of the index does not depend on the places in it.
  let place = sizeOf(before) + sizeOf(index(firsts));
  const places = clusters.map((parts) => (place += sizeOf(parts)) - sizeOf(parts));
  const format: Element[] = [
    [0x4286, 1],
    [0x42f7, 1],
    [0x42f2, 4],
    [0x42f3, 8],
    [0x4282, "webm"],
    [0x4287, 4],
    [0x4285, 2],
  ];
  const body = [...before, ...index(places), ...clusters.flat()];
  return [
    ...encode([0x1a45dfa3, format]),
    wholeNumber(0x18538067),
    wholeNumber(1),
    wholeNumber(sizeOf(body), 7),
    ...body,
  ];
}
