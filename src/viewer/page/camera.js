"use strict";

// Vectors and what moves a camera. A camera has an eye, a target, an up direction, a roll and parameters of its lens.

const add = (a, b) => a.map((v, i) => v + b[i]);
const sub = (a, b) => a.map((v, i) => v - b[i]);
const scale = (a, s) => a.map((v) => v * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => scale(a, 1 / length(a));

// Micrometres and microdegrees: files stay readable, and no picture shows less.
const rounded = (v) => Math.round(v * 1e6) / 1e6 + 0;

/** The directions to the right, up in the world and ahead. */
function directions(camera) {
  const ahead = unit(sub(camera.target, camera.eye));
  const up = unit(camera.up);
  let right = cross(ahead, up);
  // Straight up or down, any horizontal direction is one to the right.
  if (length(right) < 1e-6) right = cross(ahead, Math.abs(up[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1]);
  if (length(right) < 1e-6) right = [1, 0, 0];
  return { right: unit(right), up, ahead };
}

/** The camera moved by metres to the right, up and ahead. */
function moved(camera, [right, up, ahead]) {
  const axes = directions(camera);
  const by = add(add(scale(axes.right, right), scale(axes.up, up)), scale(axes.ahead, ahead));
  return { ...camera, eye: add(camera.eye, by).map(rounded), target: add(camera.target, by).map(rounded) };
}

/** `v` turned about the unit vector `axis`. */
function turnedAbout(v, axis, degrees) {
  const angle = (degrees * Math.PI) / 180;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

/** The camera turned by degrees to the right and upwards; it stops short of straight up and down. */
function turned(camera, right, upwards) {
  const axes = directions(camera);
  const pitch = (Math.asin(Math.max(-1, Math.min(1, dot(axes.ahead, axes.up)))) * 180) / Math.PI;
  const by = Math.max(-89, Math.min(89, pitch + upwards)) - pitch;
  const distance = length(sub(camera.target, camera.eye));
  const pitched = turnedAbout(axes.ahead, axes.right, Math.abs(pitch) > 89 ? 0 : by);
  const ahead = turnedAbout(pitched, axes.up, -right);
  return { ...camera, target: add(camera.eye, scale(unit(ahead), distance)).map(rounded) };
}

/** The camera rolled by degrees, counter-clockwise as seen from behind. */
function rolled(camera, degrees) {
  let roll = rounded(camera.roll + degrees);
  if (roll > 180) roll -= 360;
  if (roll <= -180) roll += 360;
  return { ...camera, roll };
}
