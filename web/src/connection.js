import { element } from "./panel/element.js";

/** Where the page's messages come from: the page itself, or the program that serves it. */
export class Connection {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
  }

  /**
   * Read a scene that the page carries.
   *
   * @param {string[]} lines messages in base64
   */
  read(lines) {
    for (const line of lines) {
      this.app.viewer.handle_command_bytearray(Uint8Array.from(atob(line), (letter) => letter.charCodeAt(0)));
    }
    this.app.complete();
  }

  /** Take the scene, and all that changes in it, from the server that the page came from. */
  listen() {
    const address = new URL(`live${location.search}`, location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => this.app.viewer.handle_command_bytearray(new Uint8Array(data));
    this.socket.onclose = () => {
      document.body.dataset.live = "ended";
      const again = element("button", { type: "button", onclick: () => location.reload() }, "Reconnect");
      this.app.notice("The program behind this page has ended; the panel still works.", again);
    };
    document.body.dataset.live = "live";
  }

  /** Let the document around the page, a notebook, join it to the program that it shows. */
  admitParent() {
    window.addEventListener("message", ({ source, data, ports: [port] }) => {
      if (source !== window.parent || source === window || data !== "nao_kin" || !port) return;
      this.port?.close();
      this.port = port;
      port.onmessage = ({ data: message }) => {
        if (message === "ended") document.body.dataset.live = "ended";
        else this.app.viewer.handle_command_bytearray(message);
      };
      document.body.dataset.live = "live";
      this.send({ kind: "open" });
    });
  }

  /** @param {object} answer for the program behind the page, if there is one */
  send(answer) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(answer));
    this.port?.postMessage(answer);
  }
}
