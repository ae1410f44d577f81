import { App } from "./app.js";
import "./style.css";

try {
  const app = new App();
  Object.assign(window, { naoKin: app });
  const lines = document.getElementById("scene")?.textContent?.trim();
  if (lines) {
    app.connection.read(lines.split("\n"));
    app.connection.admitParent();
  } else app.connection.listen();
} catch (error) {
  console.error(error);
  const notice = /** @type {HTMLElement} */ (document.getElementById("notice"));
  notice.textContent = `This page cannot be shown; it needs WebGL (${/** @type {Error} */ (error).message}).`;
  notice.hidden = false;
}
