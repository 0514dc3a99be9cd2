// What the page shows, and how it looks.

const isFinal = () => document.getElementById("view").dataset.stage === "final" && link.waiting.size === 0;

/** Waits until the page shows all samples of what it has asked for. */
export const settled = (page) => page.waitForFunction(isFinal);

export const fields = (page, id) => page.locator(`#${id} input`).evaluateAll((inputs) => inputs.map((input) => Number(input.value)));

/** Whether the canvas of the page has the pixels of a PNG file. */
export async function isDrawn(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
  const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d", { alpha: false });
  canvas.drawImage(image, 0, 0);
  const of = (context) => context.getImageData(0, 0, image.width, image.height).data;
  const [wanted, drawn] = [of(canvas), of(pen)];
  return wanted.every((v, i) => v === drawn[i]);
}

/** Texts that do not fit into their place, or lie over one another. */
export function clashes() {
  const isShown = (element) => element.checkVisibility() && element.getClientRects().length > 0;
  const texts = [...document.querySelectorAll("body *")].filter((element) => {
    const own = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim() !== "");
    return isShown(element) && own && !["SCRIPT", "STYLE", "OPTION"].includes(element.tagName);
  });
  const found = [];
  const boxes = texts.map((element) => {
    const range = document.createRange();
    const node = [...element.childNodes].find((n) => n.nodeType === Node.TEXT_NODE && n.textContent.trim() !== "");
    range.selectNodeContents(node);
    return range.getBoundingClientRect();
  });
  const visible = texts.map((element, i) => {
    // What a place that scrolls does not show lies over nothing.
    const clip = element.closest("aside")?.getBoundingClientRect();
    return !clip || (boxes[i].top >= clip.top && boxes[i].bottom <= clip.bottom);
  });
  boxes.forEach((a, i) => {
    const place = texts[i].getBoundingClientRect();
    if (a.right > place.right + 1 && getComputedStyle(texts[i]).overflow !== "hidden") found.push(`${texts[i].textContent} is cut off`);
    if (visible[i] && (a.left < 0 || a.right > innerWidth + 1)) found.push(`${texts[i].textContent} leaves the window`);
    boxes.slice(i + 1).forEach((b, j) => {
      const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
      if (over && visible[i] && visible[i + 1 + j]) found.push(`${texts[i].textContent} | ${texts[i + 1 + j].textContent}`);
    });
  });
  const wide = [...document.querySelectorAll("body, main, header, footer, aside")].filter((e) => e.scrollWidth > e.clientWidth + 1);
  return [...found, ...wide.map((element) => `${element.tagName} is too wide`)];
}

/** The picture is as large as its place allows, and not larger. */
export function fits() {
  const [view, stage] = ["view", "stage"].map((id) => document.getElementById(id).getBoundingClientRect());
  const gaps = [stage.width - view.width, stage.height - view.height];
  return Math.min(...gaps) >= 0 && Math.min(...gaps) < 2;
}
