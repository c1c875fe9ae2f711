// The chart of a run: incumbent and bound over time.
import { box, text, ticks } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const HEIGHT = 150;

function drawn(tag, attributes, content = "") {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = content;
  return element;
}

export function drawChart(work) {
  const chart = box("chart");
  const width = chart.clientWidth || 360;
  chart.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
  chart.replaceChildren();
  if (!work || !work.points.length) {
    chart.append(drawn("text", { x: width / 2, y: HEIGHT / 2, "text-anchor": "middle" },
      "best plan and bound come here"));
    return;
  }
  const lines = ["incumbent", "bound"].map((name, at) => ({
    name, points: work.points.map((point) => [point[0], point[at + 1]])
      .filter((point) => point[1] !== null),
  }));
  const values = lines.flatMap((line) => line.points.map((point) => point[1]));
  if (!values.length) return;
  const end = Math.max(work.elapsed_s, 1e-3);
  let low = Math.min(...values);
  let high = Math.max(...values);
  const room = (high - low) * 0.12 || Math.abs(high) * 0.05 || 1;
  [low, high] = [Math.max(low - room, Math.min(low, 0)), high + room];
  const [left, right] = [44, width - 8];
  const [top, bottom] = [16, HEIGHT - 20];
  const x = (at) => left + ((right - left) * at) / end;
  const y = (value) => bottom - ((bottom - top) * (value - low)) / (high - low);
  for (const value of ticks(low, high, 4)) {
    chart.append(
      drawn("line", { class: "grid", x1: left, x2: right, y1: y(value), y2: y(value) }),
      drawn("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, text(value, 5)),
    );
  }
  for (const at of ticks(0, end, 4)) {
    chart.append(drawn("text", { x: Math.min(x(at), right - 8), y: HEIGHT - 5, "text-anchor": "middle" },
      `${text(at, 4)} s`));
  }
  // Each value holds until the next one.
  const stairs = (points) => {
    const corners = points.flatMap(([at, value], number) => {
      const next = number + 1 < points.length ? points[number + 1][0] : end;
      return [[at, value], [Math.max(next, at), value]];
    });
    return corners.map(([at, value]) => `${x(at).toFixed(1)},${y(value).toFixed(1)}`);
  };
  const both = work.points.filter((point) => point[1] !== null && point[2] !== null);
  if (both.length) {
    const under = stairs(both.map((point) => [point[0], point[1]]));
    const over = stairs(both.map((point) => [point[0], point[2]]));
    chart.append(drawn("polygon", { class: "between", points: [...over, ...under.reverse()].join(" ") }));
  }
  for (const { name, points } of lines) {
    if (!points.length) continue;
    chart.append(drawn("polyline", { class: name, points: stairs(points).join(" ") }));
  }
  const names = drawn("text", { x: right, y: 11, "text-anchor": "end" });
  names.append(
    drawn("tspan", { class: "name-incumbent" }, "best plan"), "\u2003",
    drawn("tspan", { class: "name-bound" }, "bound (dashed)"),
  );
  chart.append(names);
}
