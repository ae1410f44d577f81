import { refuse, unpack } from "./packed.ts";

/** Run the page's scripts, which the policy of the page names by their hash. */
async function load() {
  const script = document.createElement("script");
  script.textContent = (await (await unpack("scripts"))?.text()) ?? "";
  document.body.append(script);
  // A copy of the document that the browser saves must not run them twice.
  script.remove();
}

load().catch((error) => refuse("a browser of 2023 or later", error));
