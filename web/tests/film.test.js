import assert from "node:assert/strict";
import { test } from "node:test";
import { toPlanes } from "../src/record/planes.ts";
import { webm } from "../src/record/webm.ts";

/**
 * The elements of EBML in some bytes, by identifier, with the places of their contents.
 *
 * @param {Buffer} bytes
 */
function elements(bytes, from = 0, to = bytes.length) {
  /** @type {{ id: string; start: number; place: number; content: Buffer }[]} */
  const found = [];
  for (let at = from; at < to;) {
    const start = at;
    const length = Math.clz32(bytes[at]) - 23;
    const id = bytes.subarray(at, at + length).toString("hex");
    assert.equal(bytes[at + length], 1);
    const size = bytes.readUIntBE(at + length + 2, 6);
    at += length + 8;
    found.push({ id, start, place: at, content: bytes.subarray(at, at + size) });
    at += size;
    assert.ok(at <= to);
  }
  return found;
}

test("a WebM file has every picture at its time, and an index of those that can be decoded alone", () => {
  const pictures = Array.from({ length: 100 }, (_, i) => ({ data: Uint8Array.of(i, 7), isKey: i % 60 === 0 }));
  const file = Buffer.concat(webm({ codec: "vp09", width: 640, height: 401, fps: 30 }, pictures));
  const [head, segment] = elements(file);
  assert.equal(head.id, "1a45dfa3");
  assert.ok(head.content.includes("webm"));
  const [about, tracks, index, ...clusters] = elements(segment.content);
  const duration = elements(about.content).find(({ id }) => id === "4489");
  assert.ok(Math.abs((duration?.content.readDoubleBE() ?? 0) - 100_000 / 30) < 1e-9);
  const [track] = elements(tracks.content);
  const fields = new Map(elements(track.content).map(({ id, content }) => [id, content]));
  assert.equal(fields.get("86")?.toString(), "V_VP9");
  const video = elements(fields.get("e0") ?? Buffer.alloc(0)).map(({ id, content }) => [id, content.toString("hex")]);
  assert.deepEqual(video.slice(0, 2), [["b0", "0280"], ["ba", "0191"]]); // prettier-ignore
  const times = clusters.flatMap(({ id, content }) => {
    assert.equal(id, "1f43b675");
    const [time, ...blocks] = elements(content);
    const first = time.content.readUIntBE(0, time.content.length);
    return blocks.map(({ content: block }) => [first + block.readInt16BE(1), block[3], block[4]]);
  });
  assert.deepEqual(
    times,
    pictures.map(({ isKey }, i) => [Math.round((1000 * i) / 30), isKey ? 0x80 : 0, i]),
  );
  const places = elements(index.content).map(({ content }) => {
    const [, place] = elements(content);
    return elements(place.content)[1].content.readUIntBE(1, 6);
  });
  assert.deepEqual(
    places,
    clusters.map(({ start }) => start),
  );
});

test("white, grey and black have no colour, and a lone red pixel at an odd corner keeps its own", () => {
  const pixels = [255, 255, 255, 255, 128, 128, 128, 255, 255, 0, 0, 255];
  assert.deepEqual([...toPlanes(pixels, 3, 1)], [235, 126, 63, 128, 102, 128, 240]);
  assert.deepEqual([...toPlanes([0, 0, 0, 255, 0, 0, 255, 255], 1, 2)], [16, 32, 184, 123]);
});
