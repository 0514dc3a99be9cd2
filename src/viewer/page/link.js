// The connection to the renderer. What the page wants goes out as state: of cameras that wait, only the newest is sent.

const byId = (id) => document.getElementById(id);

const link = {
  socket: null,
  client: 0,
  seq: 0,
  /** When each message that changes the view was asked for, and by which field; those that no picture has answered yet. */
  waiting: new Map(),
  /** Milliseconds from an input to the first picture that shows it. */
  latencies: [],
  delay: 250,
  on: {},
};

function connect() {
  const socket = new WebSocket(`ws://${location.host}/live${location.search}`);
  socket.binaryType = "arraybuffer";
  link.socket = socket;
  socket.onopen = () => {
    link.delay = 250;
    link.waiting.clear();
    link.on.state(true);
  };
  socket.onclose = (event) => {
    link.socket = null;
    link.on.state(false, event.reason);
    setTimeout(connect, link.delay);
    link.delay = Math.min(2 * link.delay, 4000);
  };
  socket.onmessage = async (event) => {
    if (typeof event.data !== "string") {
      await receivePicture(event.data, socket);
      return;
    }
    const message = JSON.parse(event.data);
    if (message.t === "hello") link.client = message.client;
    link.on[message.t]?.(message);
  };
}

async function receivePicture(data, socket) {
  const size = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, size)));
  const blob = new Blob([new Uint8Array(data, 4 + size)], { type: header.mime });
  // A browser without memory has no picture, and gets the next one.
  const image = await createImageBitmap(blob).catch(() => null);
  if (header.kind === "job") {
    if (image) link.on.jobPicture(header, image);
    return;
  }
  if (image) link.on.picture(header, image);
  if (header.client === link.client) {
    const now = performance.now();
    for (const [seq, { asked }] of link.waiting) {
      if (seq > header.seq) break;
      link.waiting.delete(seq);
      link.latencies.push(now - asked);
    }
  }
  if (socket.readyState === WebSocket.OPEN) socket.send('{"t":"ack"}');
}

/** The newest message that waits for the next picture of the screen, and whether one was sent since the last. */
const outbox = { message: null, isBusy: false };

function send(message) {
  flushOutbox();
  if (link.socket?.readyState === WebSocket.OPEN) link.socket.send(JSON.stringify(message));
}

function flushOutbox() {
  const { message } = outbox;
  outbox.message = null;
  if (message) send(message);
}

function startNextTurn() {
  outbox.isBusy = outbox.message !== null;
  flushOutbox();
  if (outbox.isBusy) requestAnimationFrame(startNextTurn);
}

/**
 * Sends a message that changes the view. `asked` is the time of the input, `field` the one that was changed. Of several messages of one kind between two pictures
 * of the screen, the first goes out at once and the last with the next picture.
 */
function sendView(message, asked = performance.now(), field = null) {
  link.seq += 1;
  link.waiting.set(link.seq, { asked, field });
  const numbered = { ...message, seq: link.seq };
  if (outbox.message && outbox.message.t !== message.t) flushOutbox();
  if (outbox.isBusy) {
    outbox.message = numbered;
    return;
  }
  send(numbered);
  outbox.isBusy = true;
  requestAnimationFrame(startNextTurn);
}
