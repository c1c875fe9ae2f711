// Keep-out zones on the altitude chart, within a page that may move them: it says where they are, and
// is told where they were dragged to.
let drawings = 0;

function showZones(zones) {
  const edge = colour("bad");
  config.edits = { shapePosition: true };
  hidden.add("zone"); // the marks of those that the plan was made with
  Object.assign(figures.altitude.layout, {
    editrevision: drawings += 1, // lest what was dragged stays where that was taken back
    shapes: zones.map((zone) => ({
      type: "rect", opacity: 0.28, fillcolor: edge, line: { width: 1, color: edge },
      x0: zone.start_s / DAY_S, x1: zone.end_s / DAY_S,
      y0: zone.min_altitude_m / 1000, y1: zone.max_altitude_m / 1000,
    })),
  });
  drawAgain(["altitude"]);
}

function tellZones(event) {
  if (!Object.keys(event).some((key) => key.startsWith("shapes["))) return;
  const ends = (one, other, by) => [one, other].map((value) => Math.round(value * by)).sort((a, b) => a - b);
  parent.postMessage({
    zones: box("altitude").layout.shapes.map(({ x0, x1, y0, y1 }) => {
      const [[start_s, end_s], [min_altitude_m, max_altitude_m]] = [ends(x0, x1, DAY_S), ends(y0, y1, 1000)];
      return { start_s, end_s, min_altitude_m, max_altitude_m };
    }),
  }, "*");
}

function listenToZones() {
  if (parent === window || !figures.altitude) return;
  addEventListener("message", ({ source, data }) => {
    if (source === parent && data?.zones) showZones(data.zones);
  });
  box("altitude").on("plotly_relayout", tellZones);
  parent.postMessage({ ready: true }, "*");
}
