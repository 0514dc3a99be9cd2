// The timeline: frames from left to right, a mark for each key, and the frame that is shown.

const timeline = { from: 1, to: 100, frame: 1, keys: [], isFitted: false, playing: null, fps: 24, on: {} };

function setKeys(keys) {
  timeline.keys = keys;
  if (keys.length > 0) {
    const [first, last] = [keys[0].frame, keys[keys.length - 1].frame];
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

function keyHere() {
  return timeline.keys.find((key) => key.frame === timeline.frame);
}

function drawTimeline() {
  for (const [id, value] of [["from", timeline.from], ["to", timeline.to], ["frame", rounded(timeline.frame)]]) {
    setField(byId(id), value);
  }
  byId("head").style.left = place(timeline.frame);
  byId("set-key").textContent = keyHere() ? "Replace key" : "Set key";
  byId("delete-key").disabled = !keyHere();
  const holder = byId("keys");
  while (holder.children.length > timeline.keys.length) holder.lastChild.remove();
  while (holder.children.length < timeline.keys.length) holder.append(keyButton());
  timeline.keys.forEach((key, i) => {
    const button = holder.children[i];
    button.dataset.frame = key.frame;
    button.style.left = place(key.frame);
    button.className = key.frame === timeline.frame ? "here" : "";
    const name = key.name ? `, ${key.name}` : "";
    button.title = `frame ${rounded(key.frame)}${name}, ${key.interp}; drag, or use the arrow keys, to move it`;
    button.setAttribute("aria-label", `Key at frame ${rounded(key.frame)}${name}`);
  });
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
      drawTimeline();
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
  const keys = direction > 0 ? timeline.keys : [...timeline.keys].reverse();
  return keys.find((key) => direction * (key.frame - timeline.frame) > 0)?.frame;
}

/** Plays the path from the frame that is shown; at its end it begins anew. Frames that come too late are left out. */
function play() {
  if (timeline.playing !== null) {
    cancelAnimationFrame(timeline.playing);
    timeline.playing = null;
    byId("play").textContent = "Play";
    return;
  }
  const first = Math.ceil(timeline.keys[0]?.frame);
  const last = Math.floor(timeline.keys.at(-1)?.frame);
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
  return timeline.keys.find((key) => rounded(key.frame) === number)?.frame ?? Math.round(number);
}
