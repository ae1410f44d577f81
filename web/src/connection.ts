import type { App } from "./app.ts";
import { button } from "./panel/element.ts";

/** The wait before the first attempt to reconnect, and the longest wait, from the sixth attempt on [ms]. */
const FIRST = 500;
const LONGEST = 10_000;

/**
 * How long to wait before the next attempt to reconnect: twice as long each time, up to ten seconds.
 *
 * @param failures number of failed attempts, from 0
 * @returns milliseconds
 */
export function delayAfter(failures: number): number {
  return Math.min(LONGEST, FIRST * 2 ** failures);
}

// How long [ms] a program may take to answer.
const PATIENCE = 10_000;

/**
 * Where the page's messages come from: the page itself, or the program that serves it.
 *
 * When the program or the network is lost, the page waits for it. It then continues with the current scene, and reloads
 * only if the page or the robot of the program has changed.
 */
export class Connection {
  /** The version of the program's page and robot. */
  version = "";
  failures = 0;
  isAsking = false;
  timer: ReturnType<typeof setTimeout> | undefined = undefined;

  socket: WebSocket | undefined;
  port: MessagePort | undefined;

  constructor(readonly page: App) {}

  /** Read the scene that a saved page contains: messages, each after its number of bytes in 32 bits. */
  read(scene: ArrayBuffer) {
    const lengths = new DataView(scene);
    for (let at = 0, length; at < scene.byteLength; at += 4 + length) {
      length = lengths.getUint32(at);
      this.page.viewer.handle_command_bytearray(new Uint8Array(scene, at + 4, length));
    }
    this.page.complete();
  }

  /** Receive the scene and its changes from the server that the page came from. */
  listen() {
    addEventListener("online", () => this.tryAgain());
    this.open();
  }

  open() {
    // With the token of the page, if it has one.
    const address = new URL(`live${location.search}`, location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    if (this.version) address.searchParams.set("have", this.version);
    const socket = (this.socket = new WebSocket(address));
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.failures = 0;
      this.begin();
      this.page.notice();
    };
    socket.onmessage = ({ data }) => this.page.viewer.handle_command_bytearray(new Uint8Array(data));
    socket.onclose = () => this.wait();
  }

  /** Expect the whole scene of a program; what an earlier connection sent no longer counts. */
  begin() {
    document.body.dataset.live = "live";
    this.page.reports.heard.clear();
  }

  /** Reload the page if the program has another page or robot than before. */
  compare(version: string) {
    if (this.version && version !== this.version) this.reload();
    this.version = version;
  }

  /** Reload the page. Until then the program's messages are ignored, because they may be about another robot. */
  reload() {
    if (this.socket) this.socket.onmessage = null;
    location.reload();
  }

  wait() {
    if (document.body.dataset.live !== "ended") {
      document.body.dataset.live = "ended";
      const now = button("Try now", () => this.tryAgain());
      this.page.notice(
        "No program is connected to this page. The panel still works; the page connects when a program runs.",
        now,
      );
    }
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), delayAfter(this.failures));
    this.failures += 1;
  }

  tryAgain() {
    if (document.body.dataset.live !== "ended") return;
    clearTimeout(this.timer);
    this.failures = 0;
    this.ask();
  }

  // A refused socket gives no reason; the status of an HTTP request does.
  async ask() {
    // The timer, the button and the network may each call this, and a second socket would receive the scene twice.
    if (this.isAsking || this.socket?.readyState === WebSocket.CONNECTING) return;
    this.isAsking = true;
    const signal = AbortSignal.timeout(PATIENCE);
    const answer = await fetch(location.href, { method: "HEAD", cache: "no-store", signal }).catch(() => null);
    this.isAsking = false;
    if (answer?.status === 403) {
      this.page.notice("The program runs again, but accepts only the new address that it has printed.");
    } else if (answer?.ok) {
      this.open();
    } else {
      this.wait();
    }
  }

  /** Let the document around the page, a notebook, connect the page to its program. */
  acceptParent() {
    window.addEventListener("message", ({ source, data, ports: [port] }) => {
      if (source !== window.parent || source === window || data !== "nao_kin" || !port) return;
      this.port?.close();
      this.port = port;
      port.onmessage = ({ data: message }) => {
        if (message === "ended") document.body.dataset.live = "ended";
        else this.page.viewer.handle_command_bytearray(message);
      };
      this.begin();
      this.send({ kind: "open" });
    });
  }

  send(answer: object) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(answer));
    this.port?.postMessage(answer);
  }
}
