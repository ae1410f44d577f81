import { element } from "../panel/element.ts";

/** Let the browser save a file. */
export function download(blob: Blob, name: string) {
  const address = URL.createObjectURL(blob);
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** A file name made of a robot's name, which may be anything. */
export function fileName(robot: string, extension: string) {
  const plain = robot
    .replace(/[^\p{L}\p{N}_.-]+/gu, "_")
    .replace(/^[_.]+/, "")
    .slice(0, 60);
  return `${plain || "robot"}.${extension}`;
}
