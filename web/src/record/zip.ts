type Bytes = Uint8Array<ArrayBuffer>;

// The remainders of all bytes: CRC-32 of ISO 3309, the lowest bit first.
const REMAINDERS = Uint32Array.from({ length: 256 }, (_, byte) => {
  let remainder = byte;
  for (let bit = 0; bit < 8; bit++) remainder = remainder & 1 ? (remainder >>> 1) ^ 0xedb88320 : remainder >>> 1;
  return remainder;
});

function checksum(data: Bytes) {
  let sum = 0xffffffff;
  for (let i = 0; i < data.length; i++) sum = (sum >>> 8) ^ REMAINDERS[(sum ^ data[i]) & 0xff];
  return ~sum >>> 0;
}

/** The little-endian bytes of numbers, each given with its number of bytes. */
function record(...fields: [bytes: number, value: number][]): Bytes {
  return Uint8Array.from(
    fields.flatMap(([bytes, value]) => Array.from({ length: bytes }, (_, i) => value >>> (8 * i))),
  );
}

// 1 January 1980, the first day that the format knows.
const DAY = 0x21;

/** Return the parts of a ZIP file, in which the files, with names in ASCII, are not compressed. */
export function zip(files: { name: string; data: Bytes }[]): Bytes[] {
  const parts: Bytes[] = [];
  const list: Bytes[] = [];
  const sizeOf = (some: Bytes[]) => some.reduce((sum, { length }) => sum + length, 0);
  let place = 0;
  for (const { name, data } of files) {
    const letters = new TextEncoder().encode(name);
    const size = data.length;
    // Version 2.0, no flags, stored, time and day, checksum, packed and unpacked size, lengths of the name and of extras.
    const about = record([2, 20], [2, 0], [2, 0], [2, 0], [2, DAY], [4, checksum(data)], [4, size], [4, size]);
    const lengths = record([2, letters.length], [2, 0]);
    const entry = [record([4, 0x04034b50]), about, lengths, letters, data];
    list.push(
      record([4, 0x02014b50], [2, 20]),
      about,
      lengths,
      record([2, 0], [2, 0], [2, 0], [4, 0], [4, place]),
      letters,
    );
    parts.push(...entry);
    place += sizeOf(entry);
  }
  const count: [number, number] = [2, files.length];
  const end = record([4, 0x06054b50], [2, 0], [2, 0], count, count, [4, sizeOf(list)], [4, place], [2, 0]);
  return [...parts, ...list, end];
}
