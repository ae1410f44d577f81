import { App } from "./app.ts";
import "./style.css";

try {
  const app = new App();
  Object.assign(window, { naoKin: app });
  const lines = document.getElementById("scene")?.textContent?.trim();
  if (lines) {
    app.connection.read(lines.split("\n"));
    app.connection.acceptParent();
  } else app.connection.listen();
} catch (error) {
  console.error(error);
  const line = document.getElementById("blank") as HTMLElement;
  line.textContent = `This page cannot be shown; it needs WebGL (${(error as Error).message}).`;
}
