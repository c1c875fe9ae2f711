// Small helpers of all rooms: elements, numbers in words, round steps.
export const DAY_S = 86400;
export const NOTHING = "—";
export const box = (name) => document.getElementById(name);

// An element; attributes that are undefined, null or false are left out.
export function made(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

export function button(said, act, attributes = {}) {
  const element = made("button", { type: "button", class: "act", ...attributes }, said);
  element.addEventListener("click", act);
  return element;
}

// Text is set where it differs, or it is read out again.
export function put(element, said) {
  const found = typeof element === "string" ? box(element) : element;
  if (found.textContent !== said) found.textContent = said;
}

// Rows stay where they are, and the focus in them, unless they are others.
export function placed(holder, rows) {
  const present = [...holder.children];
  if (present.length !== rows.length || present.some((row, at) => row !== rows[at])) {
    holder.replaceChildren(...rows);
  }
}

export const text = (value, digits = 6) =>
  value === null || value === undefined || Number.isNaN(value)
    ? NOTHING : String(Number(value.toPrecision(digits)));

export const counted = (count, noun, many = `${noun}s`) =>
  `${count.toLocaleString("en-GB")} ${count === 1 ? noun : many}`;

// About a hundredth of the range, as 1, 2 or 5 times a power of ten.
export function step(range) {
  const rough = range / 100 || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((each) => each * power >= rough) ?? 10);
}

// Round numbers that divide a range into about this number of parts.
export function ticks(low, high, parts) {
  const each = step(((high - low) / parts) * 100);
  const found = [];
  for (let at = Math.ceil(low / each - 1e-9); at * each <= high + 1e-9 * each; at += 1) {
    found.push(Number((at * each).toPrecision(12)));
  }
  return found;
}

// Values of the style sheet, for what is drawn by hand.
export const colour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
