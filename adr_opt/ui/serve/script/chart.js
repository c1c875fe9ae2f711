// The chart of a run: incumbent and bound over time.
import { box } from "./dom.js";
import { around, axes, drawn, scale } from "./svg.js";

const HEIGHT = 150;

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
  const least = Math.min(...values);
  const { low, high } = around(values, 0.12);
  const x = scale(0, end, 44, width - 8);
  const y = scale(Math.max(low, Math.min(least, 0)), high, HEIGHT - 20, 16);
  chart.append(...axes(x, y, " s"));
  // Each value holds until the next one.
  const stairs = (points) => {
    const corners = points.flatMap(([at, value], number) => {
      const next = number + 1 < points.length ? points[number + 1][0] : end;
      return [[at, value], [Math.max(next, at), value]];
    });
    return corners.map(([at, value]) => `${x.at(at).toFixed(1)},${y.at(value).toFixed(1)}`);
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
  const names = drawn("text", { x: x.to, y: 11, "text-anchor": "end" });
  names.append(
    drawn("tspan", { class: "name-incumbent" }, "best plan"), "\u2003",
    drawn("tspan", { class: "name-bound" }, "bound (dashed)"),
  );
  chart.append(names);
}
