// The timeline: frames from left to right, a mark for each key, and the frame that is shown.

const timeline = {
  from: 1, to: 100, frame: 1, isFitted: false, playing: null, fps: 24, moves: false, on: {},
  /** The keys in the order of their frames, and the mark of each. */
  keys: [], marks: [],
  /** The range for which the marks are placed, and the mark of the frame that is shown. */
  range: "", here: null,
};

/** Replaces the `remove` keys from the index `at` on by those of `insert`. */
function changeKeys({ at, remove, insert }) {
  const { keys, marks } = timeline;
  // A mark that stays keeps the focus.
  const kept = Math.min(remove, insert.length);
  for (let i = 0; i < kept; i += 1) keys[at + i] = insert[i];
  if (remove !== insert.length) {
    const added = document.createDocumentFragment();
    const fresh = insert.slice(kept).map(() => added.appendChild(keyButton()));
    byId("keys").insertBefore(added, marks[at + remove] ?? null);
    for (const mark of marks.slice(at + kept, at + remove)) mark.remove();
    timeline.marks = [...marks.slice(0, at + kept), ...fresh, ...marks.slice(at + remove)];
    timeline.keys = [...keys.slice(0, at + kept), ...insert.slice(kept), ...keys.slice(at + remove)];
  }
  insert.forEach((key, i) => drawKey(timeline.marks[at + i], key));
  if (timeline.keys.length > 0) {
    const [first, last] = [timeline.keys[0].frame, timeline.keys.at(-1).frame];
    if (!timeline.isFitted && last > first) [timeline.from, timeline.to] = [Math.floor(first), Math.ceil(last)];
    timeline.from = Math.min(timeline.from, Math.floor(first));
    timeline.to = Math.max(timeline.to, Math.ceil(last));
    timeline.isFitted = true;
  }
  drawTimeline();
}

function setFrame(frame) {
  timeline.frame = frame;
  timeline.from = Math.min(timeline.from, Math.floor(frame));
  timeline.to = Math.max(timeline.to, Math.ceil(frame));
  drawTimeline();
}

function place(frame) {
  return `${(100 * (frame - timeline.from)) / Math.max(1, timeline.to - timeline.from)}%`;
}

function frameAt(x) {
  const box = byId("track").getBoundingClientRect();
  const along = Math.max(0, Math.min(1, (x - box.left) / box.width));
  return Math.round(timeline.from + along * (timeline.to - timeline.from));
}

/** The index of the first key at or after a frame. */
function keyIndex(frame) {
  let [low, high] = [0, timeline.keys.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeline.keys[middle].frame < frame) low = middle + 1;
    else high = middle;
  }
  return low;
}

function keyHere() {
  const key = timeline.keys[keyIndex(timeline.frame)];
  return key?.frame === timeline.frame ? key : undefined;
}

/** Draws what has changed: marks are placed anew only for another range. */
function drawTimeline() {
  for (const [id, value] of [["from", timeline.from], ["to", timeline.to], ["frame", rounded(timeline.frame)]]) {
    setField(byId(id), value);
  }
  byId("head").style.left = place(timeline.frame);
  const isKey = keyHere() !== undefined;
  byId("set-key").textContent = isKey ? "Replace key" : "Set key";
  byId("delete-key").disabled = !isKey;
  const range = `${timeline.from} ${timeline.to}`;
  if (timeline.range !== range) timeline.marks.forEach((mark, i) => (mark.style.left = place(timeline.keys[i].frame)));
  timeline.range = range;
  const here = isKey ? timeline.marks[keyIndex(timeline.frame)] : null;
  if (here === timeline.here) return;
  timeline.here?.classList.remove("here");
  here?.classList.add("here");
  timeline.here = here;
}

function drawKey(mark, key) {
  mark.dataset.frame = key.frame;
  mark.style.left = place(key.frame);
  const name = key.name ? `, ${key.name}` : "";
  mark.title = `frame ${rounded(key.frame)}${name}, ${key.interp}; drag, or use the arrow keys, to move it`;
  mark.setAttribute("aria-label", `Key at frame ${rounded(key.frame)}${name}`);
}

function keyButton() {
  const button = document.createElement("button");
  button.type = "button";
  let dragged = null;
  const frame = () => Number(button.dataset.frame);
  button.onclick = (event) => {
    event.stopPropagation();
    if (dragged === null) timeline.on.frame(frame());
    dragged = null;
  };
  button.onpointerdown = (event) => {
    event.stopPropagation();
    dragged = null;
    button.setPointerCapture(event.pointerId);
    const start = event.clientX;
    button.onpointermove = (move) => {
      if (dragged === null && Math.abs(move.clientX - start) < 4) return;
      dragged = frameAt(move.clientX);
      button.style.left = place(dragged);
    };
    button.onpointerup = button.onpointercancel = (up) => {
      button.onpointermove = button.onpointerup = button.onpointercancel = null;
      if (dragged !== null && up.type === "pointerup" && dragged !== frame()) timeline.on.move(frame(), dragged);
      button.style.left = place(frame());
    };
  };
  button.onkeydown = (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step) timeline.on.move(frame(), frame() + step * (event.shiftKey ? 10 : 1));
    else if (event.key === "Delete") timeline.on.remove(frame());
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return button;
}

function nextKey(direction) {
  const index = keyIndex(timeline.frame);
  return timeline.keys[direction < 0 ? index - 1 : index + (keyHere() ? 1 : 0)]?.frame;
}

/**
 * Plays the path, or without one the timeline of a scene that moves, from the frame that is shown; at the end it begins anew.
 * Frames that come too late are left out.
 */
function play() {
  if (timeline.playing !== null) {
    cancelAnimationFrame(timeline.playing);
    timeline.playing = null;
    byId("play").textContent = "Play";
    return;
  }
  const isOfScene = timeline.moves && timeline.keys.length < 2;
  const first = isOfScene ? timeline.from : Math.ceil(timeline.keys[0]?.frame);
  const last = isOfScene ? timeline.to : Math.floor(timeline.keys.at(-1)?.frame);
  if (!(first < last)) {
    timeline.on.note("there is nothing to play: set keys at two frames or more", true);
    return;
  }
  byId("play").textContent = "Stop";
  let begun = performance.now();
  let start = timeline.frame >= first && timeline.frame < last ? Math.floor(timeline.frame) : first;
  let shown = null;
  const step = (now) => {
    let frame = start + Math.floor(((now - begun) * timeline.fps) / 1000);
    if (frame > last) [begun, start, frame] = [now, first, first];
    if (frame !== shown) timeline.on.frame(frame, true);
    shown = frame;
    timeline.playing = requestAnimationFrame(step);
  };
  timeline.playing = requestAnimationFrame(step);
}

function startTimeline() {
  const track = byId("track");
  track.onpointerdown = (event) => {
    track.setPointerCapture(event.pointerId);
    timeline.on.frame(frameAt(event.clientX));
    track.onpointermove = (move) => {
      const frame = frameAt(move.clientX);
      if (frame !== timeline.frame) timeline.on.frame(frame);
    };
    track.onpointerup = track.onpointercancel = () => {
      track.onpointermove = track.onpointerup = track.onpointercancel = null;
    };
  };
  for (const id of ["from", "to"]) {
    byId(id).onchange = (event) => {
      const frame = numberOf(event.target);
      if (frame === null) return;
      timeline[id] = Math.round(frame);
      if (timeline.to <= timeline.from) timeline.to = timeline.from + 1;
      drawTimeline();
    };
  }
  byId("frame").onchange = (event) => {
    const frame = numberOf(event.target);
    if (frame !== null) timeline.on.frame(typedFrame(frame));
  };
  byId("frame-before").onclick = () => goByFrames(-1);
  byId("frame-after").onclick = () => goByFrames(1);
  byId("key-before").onclick = () => goToKey(-1);
  byId("key-after").onclick = () => goToKey(1);
  byId("play").onclick = play;
}

function goToKey(direction) {
  const frame = nextKey(direction);
  if (frame !== undefined) timeline.on.frame(frame);
}

/** Goes to the whole frame before or after. */
function goByFrames(direction) {
  const { frame } = timeline;
  timeline.on.frame(direction < 0 ? Math.ceil(frame) - 1 : Math.floor(frame) + 1);
}

/** The frame of the key at a number, as fields show it, or else the nearest whole frame. */
function typedFrame(number) {
  // Fields show millionths.
  const key = timeline.keys[keyIndex(number - 1e-6)];
  return key && rounded(key.frame) === number ? key.frame : Math.round(number);
}
