// The page: pictures, keys, the pointer, fields and buttons.

const view = byId("view");
const pen = view.getContext("2d", { alpha: false });

/** What the page shows; `camera` is the newest that it wants or was told. */
const page = { camera: null, lens: {}, look: null, hello: null, step: 1, speed: 10, isChanged: false, version: 0 };

// Pictures and facts

link.on.state = (isOpen, reason) => {
  // A new connection is told all keys.
  if (isOpen) changeKeys({ at: 0, remove: timeline.keys.length, insert: [] });
  byId("link").textContent = isOpen ? "connected" : reason || "not connected";
  byId("link").className = isOpen ? "" : "bad";
};

link.on.hello = (hello) => {
  if (!page.hello) {
    [page.step, page.speed] = [hello.step, 10 * hello.step];
    showSteps();
    const [first, last] = hello.frames ?? [0, 0];
    if (first < last) [timeline.from, timeline.to] = [first, last];
  }
  page.hello = hello;
  timeline.fps = hello.fps;
  timeline.moves = hello.frames !== null;
  // Versions of the view begin anew with another process.
  page.version = 0;
  // A canvas that gets a size is empty.
  if (`${hello.resolution}` !== `${[view.width, view.height]}`) [view.width, view.height] = hello.resolution;
  byId("scene").textContent = hello.scene;
  document.title = `${hello.scene} - batch-render`;
  fillSelect("integrator", hello.integrators);
  fillSelect("pass", hello.passes);
  fillSelect("display", hello.views);
  byId("home").disabled = !hello.has_home;
  byId("still").href = `/still.png${location.search}`;
  byId("warnings").hidden = hello.warnings.length === 0;
  const item = (textContent) => Object.assign(document.createElement("li"), { textContent });
  byId("warnings").querySelector("ul").replaceChildren(...hello.warnings.map(item));
  fit();
};

link.on.picture = (header, image) => {
  if (header.version < page.version) return;
  page.version = header.version;
  pen.imageSmoothingEnabled = header.stage === "coarse";
  pen.drawImage(image, 0, 0, view.width, view.height);
  image.close();
  // A picture of what was wanted before does not take the camera back.
  if (header.client !== link.client || header.seq >= link.seq) {
    page.camera = header.camera;
    page.lens = header.lens;
    setFrame(header.frame);
    showCamera();
  }
  page.header = header;
  view.dataset.stage = header.stage;
  view.dataset.version = header.version;
  showStatistics(header);
};

link.on.facts = (facts) => {
  page.look = facts.look;
  page.isChanged = facts.is_changed;
  byId("file").textContent = facts.file;
  byId("file").title = facts.file;
  byId("file").className = facts.is_changed ? "changed" : "";
  byId("command").textContent = facts.command;
  showLook();
};

link.on.keys = changeKeys;

link.on.scene = ({ has_changed, is_loading, error, frame_error }) => {
  byId("changed").hidden = !has_changed && !is_loading && error === "" && frame_error === "";
  byId("reload").disabled = is_loading;
  const ofDisk = error === "" ? "The scene has changed on disk." : `The scene on disk cannot be loaded.\n${error}`;
  const text = frame_error === "" ? ofDisk : `The frame cannot be shown.\n${frame_error}`;
  byId("changed").querySelector("p").textContent = is_loading ? "Loading the scene" : text;
};

link.on.job = (job) => {
  const isRunning = job.state === "loading" || job.state === "running";
  byId("render").disabled = isRunning;
  byId("cancel").disabled = !isRunning;
  const done = job.frames ? (job.done + (isRunning ? job.fraction : 0)) / job.frames : 0;
  byId("job-progress").value = job.state === "done" ? 1 : Math.min(1, done);
  const where = job.state === "running" ? `frame ${job.frame}, ${job.done} of ${job.frames} on disk` : job.state;
  byId("job-text").textContent = job.state === "idle" ? "" : job.text ? `${where}: ${job.text}` : where;
};

link.on.jobPicture = (header, image) => {
  const canvas = byId("job-view");
  [canvas.width, canvas.height, canvas.hidden] = [header.width, header.height, false];
  canvas.getContext("2d").drawImage(image, 0, 0);
  canvas.title = `frame ${header.frame}`;
  image.close();
};

link.on.picked = ({ id, found }) => {
  const [object, material, distance] = byId("picked").querySelectorAll("dd");
  object.textContent = found ? found.object || "without a name" : "nothing";
  material.textContent = found ? found.material || "without a name" : "";
  distance.textContent = found ? `${shown(found.distance)} m` : "";
  if (!focusing.delete(id)) return;
  if (!found) note("there is nothing to focus on", true);
  else if (!page.hello.columns.includes("focus_distance")) note("this camera has no focus", true);
  else {
    setLens("focus_distance", rounded(found.depth));
    const { aperture_radius, fstop } = page.lens;
    const isPinhole = fstop === undefined && !aperture_radius;
    note(isPinhole ? "focused; with an aperture of 0 everything is sharp" : `focused at ${shown(found.depth)} m`);
  }
};

link.on.note = ({ is_error, text, seq }) => {
  const field = link.waiting.get(seq)?.field;
  if (!field) note(text, is_error);
  if (!is_error || !page.header) return;
  // What was refused is not waited for.
  link.waiting.clear();
  page.camera = page.header.camera;
  showCamera();
  setFrame(page.header.frame);
  showLook();
  if (field) refuseField(field, text);
};

link.on.foreign = () => {
  if (confirm("Another program has changed the file. Replace it? Its content is kept as .bak.")) send({ t: "save", force: true });
};

let noteTimer = 0;
function note(text, isError = false) {
  const place = byId("note");
  place.textContent = text;
  place.className = isError ? "error" : "";
  place.hidden = false;
  clearTimeout(noteTimer);
  noteTimer = setTimeout(() => (place.hidden = true), isError ? 8000 : 3000);
}

const shown = (v) => (Math.abs(v) >= 1000 ? v.toFixed(0) : String(Number(v.toPrecision(5))));

function showStatistics(header) {
  const [samples, rays, first, latency] = byId("statistics").querySelectorAll("dd");
  const count = `${header.samples} of ${header.of}`;
  const small = `1, at ${header.width}x${header.height}`;
  samples.textContent = header.stage === "coarse" ? small : header.stage === "part" ? `up to ${count}` : count;
  rays.textContent = `${(header.rays_per_second / 1e6).toFixed(1)} M`;
  if (header.stage === "coarse") first.textContent = `${header.ms.toFixed(0)} ms`;
  const recent = link.latencies.slice(-100).sort((a, b) => a - b);
  if (recent.length > 0) {
    const median = recent[recent.length >> 1];
    latency.textContent = `${median.toFixed(0)} ms (max. ${recent[recent.length - 1].toFixed(0)})`;
  }
  const state = header.stage === "final" ? "finished" : "rendering";
  const isAway = !header.on_path && timeline.keys.length > 0;
  const place = header.on_path ? " of the path" : isAway ? ", away from the path (K sets a key here)" : "";
  byId("progress").textContent = `${page.hello.resolution.join("x")}, ${state}, frame ${rounded(header.frame)}${place}`;
}

// The camera

function wantCamera(camera, asked, field) {
  page.camera = camera;
  sendView({ t: "view", camera }, asked, field);
  showCamera();
}

function setLens(name, value, field) {
  wantCamera({ ...page.camera, lens: { ...page.camera.lens, [name]: value } }, performance.now(), field);
}

/** The names of lens parameters with their bounds. */
const LENS = {
  fov: ["Field of view", 0, 180], fov_x: ["Width of view", 0, 180], focal_length: ["Focal length, mm", 0],
  aperture_radius: ["Aperture radius", 0], fstop: ["f-number", 0], focus_distance: ["Focus", 0], shift_x: ["Shift right"],
  shift_y: ["Shift up"],
};

function showCamera() {
  const { camera } = page;
  for (const name of ["eye", "target", "up"]) {
    const inputs = byId(name).querySelectorAll("input");
    camera[name].forEach((v, i) => setField(inputs[i], rounded(v)));
  }
  setField(byId("roll"), rounded(camera.roll));
  const lens = { ...page.lens, ...camera.lens };
  const names = Object.keys(LENS).filter((name) => lens[name] !== undefined && page.hello.columns.includes(name));
  const holder = byId("lens");
  if (holder.dataset.names !== names.join()) {
    holder.dataset.names = names.join();
    holder.replaceChildren(...names.map(lensField));
  }
  names.forEach((name, i) => setField(holder.children[i].querySelector("input"), rounded(lens[name])));
}

function onNumber(field, change) {
  field.onchange = () => {
    const value = numberOf(field);
    if (value !== null) change(value, field);
  };
}

function numberInput(label, change, min = "", max = "") {
  const input = Object.assign(document.createElement("input"), { type: "number", step: "any", min, max });
  if (label) input.setAttribute("aria-label", label);
  onNumber(input, change);
  return input;
}

function lensField(name) {
  const [text, ...bounds] = LENS[name];
  const label = document.createElement("label");
  const input = numberInput("", (v, field) => setLens(name, v, field), ...bounds);
  input.id = name;
  label.append(`${text} `, input);
  return label;
}

for (const name of ["eye", "target", "up"]) {
  for (const i of [0, 1, 2]) {
    const change = (v, field) => {
      const vector = page.camera[name].map((old, j) => (i === j ? v : old));
      wantCamera({ ...page.camera, [name]: vector }, performance.now(), field);
    };
    byId(name).append(numberInput(`${name} ${"xyz"[i]}`, change));
  }
}
onNumber(byId("roll"), (roll, field) => wantCamera({ ...page.camera, roll }, performance.now(), field));

// Keys that move the camera: the first step at once, and while a key is held the speed

/** By the place of a key: under the fingers on every keyboard. */
const MOVES = {
  ArrowRight: [1, 0, 0], ArrowLeft: [-1, 0, 0], F1: [0, 1, 0], F2: [0, -1, 0], ArrowUp: [0, 0, 1], ArrowDown: [0, 0, -1],
  KeyD: [1, 0, 0], KeyA: [-1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0], KeyW: [0, 0, 1], KeyS: [0, 0, -1],
};
/** By the character, as all other keys. */
const ROLLS = { z: 1, x: -1 };
const ROLL_STEP = 1;
const HOLD = 250;

/** The character of a key, or its name. On keyboards without Latin letters it is the letter of the place. */
function characterOf({ key, code }) {
  if (key.length === 1 && key > "\x7f" && code.startsWith("Key")) return code[3].toLowerCase();
  return key.length === 1 ? key.toLowerCase() : key;
}

/** The motion of a key: a direction and a roll; undefined for other keys. */
function motionOf(event) {
  const [move, roll] = [MOVES[event.code], ROLLS[characterOf(event)]];
  return move || roll ? { move: move ?? [0, 0, 0], roll: move ? 0 : roll } : undefined;
}

/** The motions of the keys that are down, by their places, with the time since when. */
const held = new Map();
let isFast = false;
let lastTick = 0;

function press(code, motion, asked) {
  held.set(code, { motion, since: asked });
  step([motion], page.step * (isFast ? 5 : 1), ROLL_STEP * (isFast ? 5 : 1), asked);
  if (held.size === 1) {
    lastTick = asked;
    requestAnimationFrame(tick);
  }
}

/** Moves by `metres` and rolls by `degrees` along the keys' directions. */
function step(motions, metres, degrees, asked) {
  if (!page.camera) return;
  let by = [0, 0, 0];
  let roll = 0;
  for (const motion of motions) {
    by = add(by, motion.move);
    roll += motion.roll;
  }
  let { camera } = page;
  if (by.some((v) => v !== 0)) camera = moved(camera, scale(by, metres));
  if (roll !== 0) camera = rolled(camera, roll * degrees);
  if (camera !== page.camera) wantCamera(camera, asked);
}

function tick(now) {
  if (held.size === 0) return;
  const moving = [...held.values()].filter(({ since }) => now - since > HOLD).map(({ motion }) => motion);
  const seconds = Math.min(0.1, Math.max(0, (now - lastTick) / 1000)) * (isFast ? 5 : 1);
  lastTick = now;
  if (moving.length > 0 && seconds > 0) step(moving, page.speed * seconds, 10 * ROLL_STEP * seconds, performance.now());
  requestAnimationFrame(tick);
}

function changeSteps(factor) {
  [page.step, page.speed] = [page.step, page.speed].map((v) => Number((v * factor).toPrecision(3)));
  showSteps();
}

function showSteps() {
  setField(byId("step"), page.step);
  setField(byId("speed"), page.speed);
}

for (const id of ["step", "speed"]) {
  onNumber(byId(id), (v, field) => {
    if (v === 0) return refuseField(field, "0 is not above 0");
    page[id] = v;
    showSteps();
  });
}

const ACTIONS = {
  " ": play,
  ",": () => goByFrames(-1),
  ".": () => goByFrames(1),
  PageUp: () => goToKey(-1),
  PageDown: () => goToKey(1),
  k: () => send({ t: "set" }),
  Delete: () => keyHere() && send({ t: "delete", frame: timeline.frame }),
  Home: () => sendView({ t: "home" }),
  p: () => pick(0.5, 0.5, false),
  f: () => pick(0.5, 0.5, true),
  h: toggleHelp,
  "+": () => changeSteps(1.25),
  // The plus sign of American keyboards without Shift.
  "=": () => changeSteps(1.25),
  "-": () => changeSteps(0.8),
};

const isField = (element) => element.matches("input, select, textarea");

document.addEventListener("keydown", (event) => {
  isFast = event.shiftKey;
  const [character, motion] = [characterOf(event), motionOf(event)];
  if ((event.ctrlKey || event.metaKey) && character === "s") {
    event.preventDefault();
    send({ t: "save" });
    return;
  }
  if (event.key === "Escape") {
    byId("help").hidden ? view.focus() : toggleHelp();
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || isField(event.target)) return;
  // A button has its own use for the space bar.
  if (character === " " && event.target.matches("button, a")) return;
  if (motion) {
    event.preventDefault();
    // The system's repeats of a key that is held say nothing new.
    if (!held.has(event.code)) press(event.code, motion, performance.now());
  } else if (ACTIONS[character]) {
    event.preventDefault();
    ACTIONS[character]();
  }
});
document.addEventListener("keyup", (event) => {
  isFast = event.shiftKey;
  held.delete(event.code);
});
window.addEventListener("blur", () => held.clear());

// The pointer

const focusing = new Set();
let picks = 0;
function pick(x, y, isFocus) {
  picks += 1;
  if (isFocus) focusing.add(picks);
  send({ t: "pick", id: picks, x, y });
}

view.onpointerdown = (down) => {
  view.focus();
  view.setPointerCapture(down.pointerId);
  let [x, y, isDrag] = [down.clientX, down.clientY, false];
  const box = view.getBoundingClientRect();
  const perPixel = Math.min(60, page.lens.fov ?? 40) / box.height;
  view.onpointermove = (move) => {
    if (!isDrag && Math.hypot(move.clientX - x, move.clientY - y) < 4) return;
    isDrag = true;
    if (page.camera) wantCamera(turned(page.camera, (move.clientX - x) * perPixel, (y - move.clientY) * perPixel));
    [x, y] = [move.clientX, move.clientY];
  };
  view.onpointerup = view.onpointercancel = (up) => {
    view.onpointermove = view.onpointerup = view.onpointercancel = null;
    if (!isDrag && up.type === "pointerup") {
      pick((up.clientX - box.left) / box.width, (up.clientY - box.top) / box.height, up.shiftKey);
    }
  };
};
view.addEventListener("wheel", (event) => {
  // With Ctrl it is the zoom of the browser.
  if (event.ctrlKey) return;
  event.preventDefault();
  changeSteps(event.deltaY < 0 ? 1.25 : 0.8);
  note(`step ${page.step} m, speed ${page.speed} m/s`);
}, { passive: false });

// Looks, the timeline, the job

function fillSelect(id, names) {
  byId(id).replaceChildren(...names.map((name) => new Option(name, name)));
}

for (const [id, key] of Object.entries({ integrator: "integrator", pass: "pass", display: "view" })) {
  byId(id).onchange = (event) => setLook({ [key]: event.target.value });
}
onNumber(byId("exposure"), (exposure, field) => setLook({ exposure }, field));
onNumber(byId("samples"), (v, field) => setLook({ samples: Math.round(v) }, field));
byId("scale").onchange = (event) => setLook({ scale: Number(event.target.value) });
function setLook(change, field) {
  sendView({ t: "look", look: { ...page.look, ...change } }, performance.now(), field);
}

function showLook() {
  const fields = { integrator: "integrator", pass: "pass", display: "view", exposure: "exposure", samples: "samples", scale: "scale" };
  for (const [id, key] of Object.entries(fields)) setField(byId(id), page.look[key]);
}

function goToFrame(frame, isPlaying = false) {
  if (!isPlaying && timeline.playing !== null) play();
  setFrame(frame);
  sendView({ t: "frame", frame });
}
Object.assign(timeline.on, {
  frame: goToFrame,
  move: (from, to) => send({ t: "move", from, to }),
  remove: (frame) => send({ t: "delete", frame }),
  note,
});
byId("set-key").onclick = ACTIONS.k;
byId("delete-key").onclick = ACTIONS.Delete;
byId("home").onclick = ACTIONS.Home;
byId("save").onclick = () => send({ t: "save" });
byId("load").onclick = () => {
  if (!page.isChanged || confirm("Keys were not saved. Load the file all the same?")) send({ t: "load" });
};
byId("reload").onclick = () => {
  send({ t: "reload" });
  view.focus();
};
byId("render").onclick = () => {
  if (page.isChanged) send({ t: "save" });
  send({ t: "render" });
};
byId("cancel").onclick = () => send({ t: "cancel" });
byId("copy").onclick = async () => {
  // A page that is not on this machine and not encrypted has no clipboard.
  if (navigator.clipboard) {
    await navigator.clipboard.writeText(byId("command").textContent);
    note("copied");
  } else {
    getSelection().selectAllChildren(byId("command"));
    note("the command is selected: Ctrl+C copies it");
  }
};
byId("help-button").onclick = toggleHelp;
function toggleHelp() {
  byId("help").hidden = !byId("help").hidden;
  byId("help-button").setAttribute("aria-expanded", String(!byId("help").hidden));
}

/** Makes the picture as large as its place, in its own shape. */
function fit() {
  const stage = byId("stage");
  const scale = Math.min(stage.clientWidth / view.width, stage.clientHeight / view.height);
  view.style.width = `${Math.floor(view.width * scale)}px`;
  view.style.height = `${Math.floor(view.height * scale)}px`;
}
new ResizeObserver(fit).observe(byId("stage"));

startTimeline();
view.focus();
connect();
