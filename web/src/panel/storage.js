const PREFIX = "nao-kin.";

/**
 * What the browser remembers under a name; null where it has nothing or is forbidden to.
 *
 * @param {string} name
 */
export function remembered(name) {
  try {
    return localStorage.getItem(PREFIX + name);
  } catch {
    return null;
  }
}

/**
 * Have the browser remember a text, where it may.
 *
 * @param {string} name
 * @param {string} text
 */
export function remember(name, text) {
  try {
    localStorage.setItem(PREFIX + name, text);
  } catch {
    // Forbidden or full: then it holds for this page only.
  }
}
