import { element } from "../panel/element.js";

/**
 * Let the browser save a file.
 *
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/**
 * A file name made of a robot's name, which may be anything.
 *
 * @param {string} robot
 * @param {string} extension
 */
export function fileName(robot, extension) {
  const plain = robot
    .replace(/[^\p{L}\p{N}_.-]+/gu, "_")
    .replace(/^[_.]+/, "")
    .slice(0, 60);
  return `${plain || "robot"}.${extension}`;
}
