const PREFIX = "nao-kin.";

/** What the browser remembers under a name; null where it has nothing or is forbidden to. */
export function remembered(name: string) {
  try {
    return localStorage.getItem(PREFIX + name);
  } catch {
    return null;
  }
}

/** Have the browser remember a text, where it may. */
export function remember(name: string, text: string) {
  try {
    localStorage.setItem(PREFIX + name, text);
  } catch {
    // Forbidden or full: then it holds for this page only.
  }
}
