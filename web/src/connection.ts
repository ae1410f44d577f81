import type { PageWith } from "./app.ts";
import { button } from "./panel/element.ts";

type Page = PageWith<"complete" | "notice" | "viewer">;

/** Milliseconds before the first try to connect again, and before all from the sixth on. */
const FIRST = 500;
const LONGEST = 10_000;

/**
 * How long to wait before trying again: twice as long each time, up to ten seconds.
 *
 * @param failures how often it has been tried in vain, from 0
 * @returns milliseconds
 */
export function delayAfter(failures: number): number {
  return Math.min(LONGEST, FIRST * 2 ** failures);
}

// How long [ms] a program may take to say that it is there.
const PATIENCE = 10_000;

/**
 * Where the page's messages come from: the page itself, or the program that serves it.
 *
 * A program that goes away, or a network, is waited for. The page then takes up what is shown, without loading anew
 * unless it or the robot is another one by now.
 */
export class Connection {
  /** What page and robot the program has. */
  version = "";
  failures = 0;
  isAsking = false;
  timer: ReturnType<typeof setTimeout> | undefined = undefined;

  socket: WebSocket | undefined;
  port: MessagePort | undefined;

  constructor(readonly page: Page) {}

  /**
   * Read a scene that the page carries.
   *
   * @param lines messages in base64
   */
  read(lines: string[]) {
    for (const line of lines) {
      this.page.viewer.handle_command_bytearray(Uint8Array.from(atob(line), (letter) => letter.charCodeAt(0)));
    }
    this.page.complete();
  }

  /** Take the scene, and all that changes in it, from the server that the page came from. */
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
      document.body.dataset.live = "live";
      this.page.notice();
    };
    socket.onmessage = ({ data }) => this.page.viewer.handle_command_bytearray(new Uint8Array(data));
    socket.onclose = () => this.wait();
  }

  /** What page and robot the program has; where they are not these, the page is loaded anew. */
  compare(version: string) {
    if (this.version && version !== this.version) this.beginAnew();
    this.version = version;
  }

  /** Load the page anew. What the program says until then may be of another robot. */
  beginAnew() {
    if (this.socket) this.socket.onmessage = null;
    location.reload();
  }

  wait() {
    if (document.body.dataset.live !== "ended") {
      document.body.dataset.live = "ended";
      const now = button("Try now", () => this.tryAgain());
      this.page.notice(
        "No program is behind this page. The panel still works; the page connects when there is one.",
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

  // A socket that is refused does not say why; a request does.
  async ask() {
    // The timer, the button and the network may each ask, and a second socket would take up the scene once more.
    if (this.isAsking || this.socket?.readyState === WebSocket.CONNECTING) return;
    this.isAsking = true;
    const signal = AbortSignal.timeout(PATIENCE);
    const answer = await fetch(location.href, { method: "HEAD", cache: "no-store", signal }).catch(() => null);
    this.isAsking = false;
    if (answer?.status === 403) {
      this.page.notice("The program runs again and lets in only its new address, which it has printed.");
    } else if (answer?.ok) {
      this.open();
    } else {
      this.wait();
    }
  }

  /** Let the document around the page, a notebook, join it to the program that it shows. */
  admitParent() {
    window.addEventListener("message", ({ source, data, ports: [port] }) => {
      if (source !== window.parent || source === window || data !== "nao_kin" || !port) return;
      this.port?.close();
      this.port = port;
      port.onmessage = ({ data: message }) => {
        if (message === "ended") document.body.dataset.live = "ended";
        else this.page.viewer.handle_command_bytearray(message);
      };
      document.body.dataset.live = "live";
      this.send({ kind: "open" });
    });
  }

  send(answer: object) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(answer));
    this.port?.postMessage(answer);
  }
}
