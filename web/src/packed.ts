/**
 * Unpack what an element of the document contains: gzip in base64.
 *
 * @returns null if the element is empty
 */
export async function unpack(id: string): Promise<Response | null> {
  const letters = atob(document.getElementById(id)?.textContent ?? "");
  if (letters === "") return null;
  const bytes = new Uint8Array(letters.length);
  // A loop, because Uint8Array.from with a function takes several times as long.
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
}

/** Say in the empty picture why the page cannot be shown. */
export function refuse(need: string, error: Error) {
  console.error(error);
  const line = document.getElementById("blank") as HTMLElement;
  line.textContent = `This page cannot be shown; it needs ${need} (${error.message}).`;
}
