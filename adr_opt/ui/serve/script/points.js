// Points of a trade-off beside the list of results: a plot and a table, in which each opens its plan.
import { box, button, made, NOTHING, text } from "./dom.js";
import { complain, get, send } from "./talk.js";

const open = (id, point) => send("/show", { result: id, point });

// The chart of the server, in which dots open plans. With a mark, a line stands at that value across.
export function plot(id, { chart, ends: [low, high, left, right, floor] }, mark = null) {
  const figure = made("div", { class: "points" });
  figure.innerHTML = chart;
  figure.addEventListener("click", (event) => {
    const link = event.target.closest("a");
    if (!link) return;
    event.preventDefault();
    open(id, Number(link.getAttribute("href").slice(1)));
  });
  if (mark !== null) {
    const share = (Math.min(Math.max(mark, low), high) - low) / (high - low);
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("d", `M${left + share * (right - left)} 0V${floor}`);
    line.setAttribute("class", "mark");
    figure.querySelector("svg").append(line);
  }
  return figure;
}

const words = ({ titles, prize }, point) => [
  ...titles.map((title, at) => `${title} ${text(point.values[at], 5)}`),
  `${prize} ${text(point.prize, 5)}`,
].join(", ");

function table(id, told) {
  const head = [...told.titles, told.prize, "bound", "plan"].map((title) => made("th", { scope: "col" }, title));
  const rows = told.points.map((point) => made("tr", {},
    ...[...point.values, point.prize, point.bound].map((value) => made("td", { class: "n" }, text(value, 5))),
    made("td", {}, point.has_plan
      ? button("Open", () => open(id, point.point), { "aria-label": `Open the plan of ${words(told, point)}` })
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
  box("points").replaceChildren(plot(id, content), table(id, content));
  section.scrollIntoView({ block: "nearest" });
}
