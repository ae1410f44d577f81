import { App } from "./app.ts";
import { refuse, unpack } from "./packed.ts";
import "./style.css";

async function open() {
  const scene = unpack("scene");
  const app = new App();
  Object.assign(window, { naoKin: app });
  const saved = await scene;
  if (saved) {
    app.connection.read(await saved.arrayBuffer());
    app.connection.acceptParent();
  } else app.connection.listen();
}

open().catch((error) => refuse("a browser of 2023 or later", error));
