// Fields of numbers: what they show, and what they refuse. A refused number stays in its field, with the reason below it.

/** The largest number of camera path files. */
const MAX_NUMBER = 3.4028234663852886e38;

/** Shows a value, but not where one is being typed. */
function setField(field, value) {
  field.dataset.shown = value;
  if (document.activeElement !== field) restoreField(field);
}

function restoreField(field) {
  field.value = field.dataset.shown ?? "";
  field.removeAttribute("aria-invalid");
}

/** The number of a field within its `min` and `max`; otherwise null, and the field says why. */
function numberOf(field) {
  const value = field.valueAsNumber;
  const bound = (text, otherwise) => (text === "" ? otherwise : Number(text));
  const [least, most] = [bound(field.min, -MAX_NUMBER), bound(field.max, MAX_NUMBER)];
  // Also where the text is no number.
  if (Number.isNaN(value)) refuseField(field, "a number is needed here");
  else if (value < least) refuseField(field, `${value} is below ${least}`);
  else if (value > most) refuseField(field, `${value} is above ${most}`);
  else {
    field.removeAttribute("aria-invalid");
    hideRefusal();
    return value;
  }
  return null;
}

let refusalTimer = 0;
function refuseField(field, text) {
  if (document.activeElement === field) field.setAttribute("aria-invalid", "true");
  const place = byId("refusal");
  place.textContent = text;
  place.hidden = false;
  const [box, own] = [field.getBoundingClientRect(), place.getBoundingClientRect()];
  const below = box.bottom + 4 + own.height <= innerHeight;
  place.style.top = `${below ? box.bottom + 4 : box.top - 4 - own.height}px`;
  place.style.left = `${Math.max(4, Math.min(box.left, innerWidth - own.width - 4))}px`;
  clearTimeout(refusalTimer);
  refusalTimer = setTimeout(hideRefusal, 8000);
}

function hideRefusal() {
  byId("refusal").hidden = true;
}

document.addEventListener("input", hideRefusal);
document.addEventListener("focusout", ({ target }) => {
  if (target.getAttribute("aria-invalid")) restoreField(target);
});
