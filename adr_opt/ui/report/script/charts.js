// Points of other legs become gaps where a chart has no axis that could be narrowed.
function only(trace, leg) {
  const mine = (at) => trace.customdata[at] === leg;
  const cut = (values) => values.map((value, at) => (mine(at) ? value : null));
  const shown = { ...trace, x: cut(trace.x), y: cut(trace.y) };
  if (trace.z) shown.z = cut(trace.z);
  return shown;
}

function traces(name) {
  const shown = tracesOf(name);
  if (name !== "orbits" || !motion) return shown;
  return [...shown.map(inDaylight), ...earthLines(), ...moving()];
}

function tracesOf(name) {
  return figures[name].data.map((trace) => {
    const phase = trace.meta?.phase;
    let shown = trace;
    if (chosen && name === "orbits" && trace.customdata) {
      shown = only(trace, chosen);
      if (trace.mode === "lines") shown.line = { ...trace.line, width: 6 };
    }
    if (chosen && name === "planes" && trace.mode === "lines") {
      // from where the leg begins to where it ends
      const at = trace.customdata.indexOf(chosen);
      const keep = (values) => values.slice(Math.max(0, at - 1), at + 1);
      shown = {
        ...trace, x: at < 0 ? [] : keep(trace.x), y: at < 0 ? [] : keep(trace.y), opacity: 1,
        line: { ...trace.line, width: 3 },
      };
    }
    return hidden.has(phase) ? { ...shown, visible: false } : shown;
  });
}

// What draws in three dimensions: "gpu", "cpu" (slow, so it is asked for fewer pixels) or "".
// Found out when it is needed, because a context without a GPU takes its time.
let means = null;
function drawsWith() {
  if (means === null) {
    const tried = (options) => {
      const context = document.createElement("canvas").getContext("webgl", options);
      if (context) context.getExtension("WEBGL_lose_context")?.loseContext();
      return Boolean(context);
    };
    means = tried({ failIfMajorPerformanceCaveat: true }) ? "gpu" : tried({}) ? "cpu" : "";
  }
  return means;
}

// Axes of the flat drawing: to the right, up, and towards the eye.
function flatAxes() {
  const { eye } = figures.orbits.layout.scene.camera;
  const length = Math.hypot(eye.x, eye.y, eye.z);
  const n = [eye.x / length, eye.y / length, eye.z / length];
  const flatness = Math.hypot(n[0], n[1]) || 1;
  const right = [-n[1] / flatness, n[0] / flatness, 0];
  const up = [
    n[1] * right[2] - n[2] * right[1],
    n[2] * right[0] - n[0] * right[2],
    n[0] * right[1] - n[1] * right[0],
  ];
  return [right, up, n];
}

// Without WebGL, the scene is seen from its camera as a flat drawing, without the Earth's far side.
function flat(data) {
  const [right, up, n] = flatAxes();
  const seen = (trace, x, at) =>
    x !== null && !(trace.meta?.earth && x * n[0] + trace.y[at] * n[1] + trace.z[at] * n[2] < 0);
  const along = (trace, way) =>
    trace.x.map((x, at) =>
      seen(trace, x, at) ? x * way[0] + trace.y[at] * way[1] + trace.z[at] * way[2] : null);
  return data
    .filter((trace) => trace.type === "scatter3d")
    .map((trace) => ({
      ...trace, type: "scatter", z: undefined, x: along(trace, right), y: along(trace, up),
      line: trace.line && { ...trace.line, width: trace.line.width / 2 },
    }));
}

function draw(name) {
  const made = layout(name);
  let data = traces(name);
  let options = config;
  drawn.add(name);
  if (name === "orbits" && drawsWith() === "cpu") options = { ...config, plotGlPixelRatio: 1 };
  if (name === "orbits" && drawsWith() === "") {
    delete made.scene;
    data = flat(data);
    made.hovermode = "closest";
    made.xaxis = { visible: false };
    made.yaxis = { visible: false, scaleanchor: "x" };
  }
  return Plotly.react(box(name), data, made, options).then(madeReachable);
}

// What depends on the time is made anew where it is seen.
const drawAgain = (wanted = [...drawn]) =>
  Promise.all(wanted.filter((name) => drawn.has(name) && !derived.has(name)).map(draw)).then(show);

