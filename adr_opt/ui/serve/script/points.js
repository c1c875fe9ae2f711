// Points of a trade-off beside the list of results: a plot and a table, in which each opens its plan.
import { box, button, made, NOTHING, text } from "./dom.js";
import { around, axes, drawn } from "./svg.js";
import { complain, get, send } from "./talk.js";

const [WIDTH, HEIGHT] = [420, 240];
const [LEFT, RIGHT, TOP, BOTTOM] = [52, 10, 10, 38];
const COLOURS = 6;

// The points of one value of all that is varied besides are a row, joined by a line.
function rowsOf({ across, points }) {
  const rows = new Map();
  for (const point of points) {
    const key = JSON.stringify(point.values.filter((_, at) => at !== across));
    rows.set(key, [...(rows.get(key) ?? []), point]);
  }
  return [...rows.values()];
}

// With a mark, a line stands at that value across.
export function plot(id, told, mark = null) {
  const { titles, across, prize } = told;
  const svg = drawn("svg", {
    class: "points", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, "aria-hidden": "true",
  });
  const known = told.points.filter(({ values, prize: value }) => values[across] !== null && value !== null);
  if (!known.length) return svg;
  const places = known.map(({ values }) => values[across]);
  const x = around(mark === null ? places : [...places, mark], 0.06, LEFT, WIDTH - RIGHT);
  const y = around(known.flatMap((point) => [point.prize, point.bound ?? point.prize]), 0.06, HEIGHT - BOTTOM, TOP);
  svg.append(...axes(x, y));
  if (mark !== null) {
    svg.append(drawn("line", { class: "mark", x1: x.at(mark), x2: x.at(mark), y1: TOP, y2: HEIGHT - BOTTOM }));
  }
  svg.append(
    drawn("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, titles[across]),
    drawn("text", { x: 12, y: HEIGHT / 2, "text-anchor": "middle", transform: `rotate(-90 12 ${HEIGHT / 2})` }, prize),
  );
  rowsOf({ across, points: known }).forEach((row, number) => {
    const shade = `line-${number % COLOURS}`;
    const sorted = [...row].sort((a, b) => a.values[across] - b.values[across]);
    const line = sorted.map((point) => `${x.at(point.values[across])},${y.at(point.prize)}`);
    svg.append(drawn("polyline", { class: shade, points: line.join(" ") }));
    for (const point of sorted) {
      const right = x.at(point.values[across]);
      if (point.bound !== null) {
        svg.append(drawn("circle", { class: `limit ${shade}`, cx: right, cy: y.at(point.bound), r: 4 }));
      }
      const dot = drawn("circle", { class: `dot ${shade}`, cx: right, cy: y.at(point.prize), r: 6 });
      dot.append(drawn("title", {}, words(told, point)));
      if (point.has_plan) dot.addEventListener("click", () => open(id, point));
      svg.append(dot);
    }
  });
  return svg;
}

// What the colours of the lines mean, where there is more than one.
function legend({ titles, across, points }) {
  const rows = rowsOf({ across, points });
  const said = ({ values }) => titles.map((title, at) => `${title} ${text(values[at], 5)}`)
    .filter((_, at) => at !== across).join(", ");
  return made("ul", { class: "plain keys", "aria-label": "Colours of the points" },
    ...(rows.length < 2 ? [] : rows.slice(0, COLOURS).map(([point], number) => made("li", {},
      made("i", { class: `swatch kind-${number}`, "aria-hidden": "true" }), said(point)))));
}

const words = ({ titles, prize }, point) => [
  ...titles.map((title, at) => `${title} ${text(point.values[at], 5)}`),
  `${prize} ${text(point.prize, 5)}`,
].join(", ");

const open = (id, point) => send("/show", { result: id, point: point.point });

function table(id, told) {
  const head = [...told.titles, told.prize, "bound", "plan"].map((title) => made("th", { scope: "col" }, title));
  const rows = told.points.map((point) => made("tr", {},
    ...[...point.values, point.prize, point.bound].map((value) => made("td", { class: "n" }, text(value, 5))),
    made("td", {}, point.has_plan
      ? button("Open", () => open(id, point), { "aria-label": `Open the plan of ${words(told, point)}` })
      : NOTHING)));
  return made("div", { class: "scroll", role: "region", "aria-label": "Table of points", tabindex: "0" },
    made("table", {}, made("caption", { class: "away" }, "Points; each opens its plan"),
      made("thead", {}, made("tr", {}, ...head)), made("tbody", {}, ...rows)));
}

// Shows the points of a result, or hides them if they are shown.
export async function showPoints(id, label) {
  const section = box("with-points");
  if (!section.hidden && section.dataset.of === String(id)) {
    section.hidden = true;
    return;
  }
  const { content, refused } = await get(`/results/points?id=${encodeURIComponent(id)}`);
  complain(refused);
  if (refused) return;
  section.dataset.of = String(id);
  section.hidden = false;
  box("points-title").textContent = `Points of ${label} (${id})`;
  box("points").replaceChildren(
    plot(id, content), legend(content), table(id, content));
  section.scrollIntoView({ block: "nearest" });
}
