// The socket: samples from the server, requests to it. Reconnects by itself.

const listeners = {};
let socket = null;
let wait = 250;

export const wire = {
  open: false,
  /** Calls `then` with every message of a kind: `samples`, `state`, `said`, `open`, `closed` … */
  on(kind, then) { (listeners[kind] ??= []).push(then); },
  /** Sends a request; false when nobody hears it. */
  ask(what) {
    if (!this.open) return false;
    socket.send(JSON.stringify(what));
    return true;
  },
};

function tell(kind, what) { for (const then of listeners[kind] ?? []) then(what); }

/** A batch as crates/lab/src/batch.rs lays it out. */
function batch(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength < 16 || view.getUint8(0) !== 1) return;
  tell("samples", {
    view, epoch: view.getUint8(1), count: view.getUint16(2, true), number: view.getUint32(4, true),
    lost: view.getUint32(8, true), clock: view.getUint32(12, true),
  });
}

export function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { wire.open = true; wait = 250; tell("open"); };
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") return batch(data);
    const message = JSON.parse(data);
    tell(message.is, message);
  };
  socket.onclose = () => {
    if (wire.open) tell("closed");
    wire.open = false;
    setTimeout(connect, wait);
    wait = Math.min(2 * wait, 2000);
  };
}
