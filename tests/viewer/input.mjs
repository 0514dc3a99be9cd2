// Keys of other keyboards, wrong numbers and long camera paths.

import assert from "node:assert/strict";
import { settled } from "./page.mjs";

export async function wrong_numbers_are_refused_at_their_fields(page) {
  const before = await page.evaluate(() => JSON.stringify([page.camera, page.look, timeline.frame]));
  const fov = (await page.locator("#fov").count()) > 0;
  for (const [id, typed, text] of [
    ["exposure", "999", "999 is above 64"], ["samples", "0", "0 is below 1"], ["frame", "-2e9", "-2000000000 is below -1000000000"],
    ["roll", "e", "a number is needed here"], ["roll", "", "a number is needed here"], ["step", "0", "0 is not above 0"],
    // The renderer knows this one only.
    ...(fov ? [["fov", "180", "frame 1: the view is not an angle between 0 and 180 degrees or a focal length above 0"]] : []),
  ]) {
    const field = page.locator(`#${id}`);
    const shown = await field.inputValue();
    await field.fill("");
    await field.pressSequentially(typed);
    await field.press("Enter");
    await page.locator("#refusal").waitFor();
    assert.equal(await page.locator("#refusal").textContent(), text, `${id} ${typed}`);
    assert.equal(await field.getAttribute("aria-invalid"), "true");
    const [below, box] = [await page.locator("#refusal").boundingBox(), await field.boundingBox()];
    assert.ok(Math.abs(below.y - box.y) < 60 && Math.abs(below.x - box.x) < 300, "the reason is at the field");
    await page.keyboard.press("Escape");
    assert.equal(await field.inputValue(), shown, `${id} shows what is`);
  }
  assert.equal(await page.evaluate(() => JSON.stringify([page.camera, page.look, timeline.frame])), before);
  assert.equal(await page.locator("#link").textContent(), "connected");
  await page.fill("#exposure", "0");
  await page.keyboard.press("Enter");
  assert.equal(await page.locator("#refusal").isVisible(), false);
  await page.keyboard.press("Escape");
}

/** Events as keyboards of these countries send them: the place of a key and its character. */
export async function keys_are_their_characters_and_movement_is_by_place(page) {
  await page.keyboard.press("Home");
  await settled(page);
  const press = (code, key, shiftKey = false) =>
    page.evaluate((init) => {
      for (const type of ["keydown", "keyup"]) {
        view.dispatchEvent(new KeyboardEvent(type, { ...init, bubbles: true, cancelable: true }));
      }
      return [page.step, page.camera.roll, timeline.frame, page.camera.eye[2], timeline.keys.length].map((v) => rounded(v));
    }, { code, key, shiftKey });
  const [metres, roll, frame, z, keys] = await press("KeyN", "n");
  for (const [code, key, shift, wanted] of [
    // German, American and French plus and minus.
    ["BracketRight", "+", false, [metres * 1.25, roll, frame, z]], ["Slash", "-", false, [metres, roll, frame, z]],
    ["Equal", "+", true, [metres * 1.25, roll, frame, z]], ["Digit6", "-", false, [metres, roll, frame, z]],
    // The French full stop and semicolon, and the comma.
    ["Comma", ".", true, [metres, roll, frame + 1, z]], ["Comma", ";", false, [metres, roll, frame + 1, z]],
    ["KeyM", ",", false, [metres, roll, frame, z]],
    // Z and Y of a German keyboard.
    ["KeyY", "z", false, [metres, roll + 1, frame, z]], ["KeyZ", "y", false, [metres, roll + 1, frame, z]],
    ["KeyX", "x", false, [metres, roll, frame, z]],
    // The places of W and S, on a French and a Dvorak keyboard.
    ["KeyW", "z", false, [metres, roll, frame, z - metres]], ["KeyS", "o", false, [metres, roll, frame, z]],
    // The place of K is T on a Dvorak keyboard.
    ["KeyK", "t", false, [metres, roll, frame, z]],
  ]) {
    const state = await press(code, key, shift);
    assert.deepEqual(state.slice(0, 4), wanted.map((v) => Math.round(v * 1e6) / 1e6), `${key} at ${code}`);
    assert.equal(state[4], keys, `${key} at ${code} sets no key`);
  }
  // K of a Dvorak and of a Russian keyboard.
  for (const [code, key] of [["KeyV", "k"], ["KeyK", "\u043b"]]) {
    await press(code, key);
    await page.waitForFunction((n) => timeline.keys.length === n, keys + 1);
    await press("Delete", "Delete");
    await page.waitForFunction((n) => timeline.keys.length === n, keys);
  }
  await page.keyboard.press("Home");
  await settled(page);
}

export async function a_frame_and_an_edit_among_2000_keys_cost_what_they_cost_among_20(page) {
  const [few, many] = await page.evaluate(() => {
    const before = [...timeline.keys];
    const all = (insert) => changeKeys({ at: 0, remove: timeline.keys.length, insert });
    const cost = (count) => {
      all(Array.from({ length: count }, (_, i) => ({ frame: 1 + i, name: null, interp: "smooth" })));
      timeline.to = 2000;
      const run = () => {
        const begun = performance.now();
        for (let i = 0; i < 100; i += 1) {
          setFrame(1 + (i % count));
          changeKeys({ at: 9, remove: 1, insert: [{ frame: 10, name: `${i}`, interp: "smooth" }] });
          nextKey(-1);
        }
        return performance.now() - begun;
      };
      return Math.min(run(), run(), run(), run(), run());
    };
    const costs = [cost(20), cost(2000)];
    all(before);
    return costs;
  });
  console.log(`100 frames and edits: ${few.toFixed(1)} ms among 20 keys, ${many.toFixed(1)} ms among 2,000`);
  assert.ok(many <= 2 * few + 3, `${few} ms, ${many} ms`);
}
