// Colours of objects: by kind, or by worth in five classes.
import { colour, text } from "./dom.js";
import { known } from "./columns.js";

const CLASSES = 5;
const KINDS = ["accent", "kind-1", "good", "kind-3", "bad", "quiet"]; // further kinds share the last colour

// A colour of the style sheet as a pixel of an ImageData seen as 32-bit numbers (little endian).
export function pixel(name) {
  const [red, green, blue] = colour(name).slice(1).match(/../g).map((pair) => parseInt(pair, 16));
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

// Bounds of classes: quantiles of the worth that is not zero, so that each has as many objects.
function classes(worth) {
  const values = worth.filter((value) => value > 0).sort();
  const at = (share) => values[Math.min(values.length - 1, Math.floor(share * values.length))];
  return Array.from({ length: CLASSES - 1 }, (_, number) => at((number + 1) / CLASSES));
}

// A pixel for each object, the order of drawing, and the entries of the legend.
export function paint(field, by) {
  const pixels = new Uint32Array(field.count);
  const numbers = Uint32Array.from({ length: field.count }, (_, at) => at);
  if (by === "worth" && known(field.worth)) {
    const bounds = classes(field.worth);
    const shades = Array.from({ length: CLASSES }, (_, number) => pixel(`worth-${number}`));
    const none = pixel("dim");
    for (let at = 0; at < field.count; at += 1) {
      const value = field.worth[at];
      if (Number.isNaN(value)) pixels[at] = none;
      else pixels[at] = shades[bounds.reduce((number, bound) => number + (value >= bound), 0)];
    }
    const keys = Float64Array.from(field.worth, (value) => (Number.isNaN(value) ? -1 : value));
    numbers.sort((a, b) => keys[a] - keys[b]); // what is worth most is drawn over the others
    const legend = shades.map((_, number) => {
      const [low, high] = [bounds[number - 1], bounds[number]];
      const words = low === undefined ? `below ${text(high, 3)}`
        : high === undefined ? `from ${text(low, 3)}` : `${text(low, 3)} to ${text(high, 3)}`;
      return { shade: `worth-${number}`, words, kind: null };
    });
    return { pixels, numbers, legend };
  }
  const shades = field.kinds.map((_, number) => KINDS[number] ?? KINDS.at(-1));
  const of = shades.map(pixel);
  for (let at = 0; at < field.count; at += 1) pixels[at] = of[field.kind[at]];
  const counts = new Array(field.kinds.length).fill(0);
  for (const kind of field.kind) counts[kind] += 1;
  const legend = field.kinds.map((words, kind) => (
    { shade: shades[kind], words: `${words} (${counts[kind].toLocaleString("en-GB")})`, kind }));
  return { pixels, numbers, legend };
}
