// The widget beside a page in a notebook: it connects the page's frame to the kernel. See nao_kin/viewer/notebook.py.

// How often [ms] the widget looks for the frame, or offers a port again to a page that has not answered.
const AGAIN = 200;

/** The model of anywidget. */
interface Model {
  get: (name: string) => any;
  send: (content: object) => void;
  on: (event: string, listener: (...values: any[]) => void) => void;
  off: (event: string, listener: (...values: any[]) => void) => void;
}

/** The connection between a frame and the kernel; it is renewed when the frame is reloaded. */
class Bridge {
  frame: HTMLIFrameElement | null = null;
  port: MessagePort | null = null;
  offer = () => this.connect();
  reload = () => (this.port = null);
  timer = setInterval(this.offer, AGAIN);

  constructor(
    readonly model: Model,
    readonly page: Document,
  ) {
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
      // The page uses the port that it was offered last, so the port of its last message is the one to use.
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
