// The widget beside a page in a notebook: joins the page's frame to the kernel. See nao_kin/viewer/notebook.py.

// How often [ms] a frame is looked for, and one that does not answer yet is asked again.
const AGAIN = 200;

/** anywidget's */
interface Model {
  get: (name: string) => any;
  send: (content: object) => void;
  on: (event: string, listener: (...values: any[]) => void) => void;
  off: (event: string, listener: (...values: any[]) => void) => void;
}

/** One connection between a frame and the kernel; it is made again whenever the frame has been loaded again. */
class Bridge {
  frame: HTMLIFrameElement | null = null;
  port: MessagePort | null = null;
  offer: () => void;
  reload: () => null;
  timer: number;

  constructor(
    readonly model: Model,
    readonly page: Document,
  ) {
    this.offer = () => this.connect();
    this.reload = () => (this.port = null);
    this.timer = setInterval(this.offer, AGAIN);
    this.connect();
  }

  connect() {
    if (!this.frame) {
      this.frame = this.page.querySelector(`iframe[data-nao-kin="${CSS.escape(this.model.get("frame"))}"]`);
      this.frame?.addEventListener("load", this.reload);
    }
    if (this.port || !this.frame?.contentWindow) return;
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = ({ data }) => {
      // The page keeps the port that it was offered last, and so what it says last comes through that one.
      this.port = port1;
      this.model.send(data);
    };
    this.frame.contentWindow.postMessage("nao_kin", "*", [port2]);
  }

  pass(messages: DataView[]) {
    for (const { buffer, byteOffset, byteLength } of messages) {
      this.port?.postMessage(new Uint8Array(buffer, byteOffset, byteLength));
    }
  }

  end() {
    clearInterval(this.timer);
    this.frame?.removeEventListener("load", this.reload);
    this.port?.postMessage("ended");
    this.port?.close();
    this.port = null;
  }
}

function render({ model, el }: { model: Model; el: HTMLElement }) {
  el.hidden = true;
  const bridge = new Bridge(model, el.ownerDocument);
  const receive = ({ kind }: { kind: string }, buffers: DataView[]) => kind === "messages" && bridge.pass(buffers);
  const end = () => bridge.end();
  model.on("msg:custom", receive);
  model.on("comm_live_update", end);
  return () => {
    model.off("msg:custom", receive);
    model.off("comm_live_update", end);
    bridge.end();
  };
}

export default { render };
