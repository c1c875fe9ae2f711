// Parts of charts in SVG: elements, scales with some room at both ends, and axes.
import { text, ticks } from "./dom.js";

export function drawn(tag, attributes, content = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = content;
  return element;
}

export function scale(low, high, from, to) {
  return { at: (value) => from + ((value - low) / (high - low)) * (to - from), low, high, from, to };
}

// From the least to the greatest of some values, and a share of that beyond.
export function around(values, share, from, to) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = (high - low) * share || Math.abs(high) * 0.05 || 1;
  return scale(low - room, high + room, from, to);
}

// Numbers at round values of both axes, and a grid across.
export const axes = (x, y, unit = "") => [
  ...ticks(y.low, y.high, 4).flatMap((value) => [
    drawn("line", { class: "grid", x1: x.from, x2: x.to, y1: y.at(value), y2: y.at(value) }),
    drawn("text", { x: x.from - 6, y: y.at(value) + 4, "text-anchor": "end" }, text(value, 5)),
  ]),
  ...ticks(x.low, x.high, 4).map((value) => drawn("text", {
    x: Math.min(x.at(value), x.to - 8), y: y.from + 15, "text-anchor": "middle",
  }, `${text(value, 5)}${unit}`)),
];
