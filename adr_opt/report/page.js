"use strict";
(() => {
  const mission = JSON.parse(document.getElementById("mission").textContent);
  const { figures, titles, windows } = mission;
  const timed = ["lanes", "altitude", "budget", "nodes", "gantt"].filter((name) => name in figures);
  // The first share their time axis.
  const quick = [...timed, "costs", "planes"].filter((name) => name in figures);
  const box = (name) => document.getElementById(name);
  const narrow = matchMedia("(max-width: 640px)");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const coarse = matchMedia("(pointer: coarse)").matches;
  const hidden = new Set(); // phases switched off
  let chosen = 0; // leg shown; 0 is the whole mission
  const drawn = new Set();
  const config = {
    displaylogo: false,
    displayModeBar: coarse ? false : "hover",
    responsive: true,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "resetCameraLastSave3d"],
  };

  for (const figure of Object.values(figures)) {
    for (const trace of figure.data) {
      const { titled, names, each } = trace.meta ?? {};
      if (titled) trace.text = trace.customdata.map((leg) => titles[leg]);
      if (names) trace.text = names.flatMap((name) => new Array(each).fill(name));
    }
  }

  // Canvas and WebGL charts do not read the style sheet, so the colours are handed to them.
  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  function axis(given) {
    return {
      gridcolor: colour("line"), linecolor: colour("line-strong"), zeroline: false,
      automargin: true, ...given,
      title: { ...given.title, standoff: 10, font: { size: 13, color: colour("quiet") } },
    };
  }

  function layout(name) {
    const given = figures[name].layout;
    const made = {
      ...given,
      autosize: true,
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: {
        family: getComputedStyle(document.body).fontFamily, size: 12, color: colour("text"),
      },
      hoverlabel: {
        bgcolor: colour("card"), bordercolor: colour("line-strong"), align: "left",
        font: { color: colour("text") },
      },
      margin: { l: 8, r: 12, t: 12, b: 8 },
      modebar: {
        bgcolor: "rgba(0,0,0,0)", color: colour("line-strong"), activecolor: colour("accent"),
      },
      showlegend: given.showlegend === true,
      legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
      uirevision: "kept",
    };
    if (given.scene) {
      made.margin = { l: 0, r: 0, t: 0, b: 0 };
      return made;
    }
    made.dragmode = coarse ? false : "zoom"; // a finger scrolls the page
    made.hovermode = "closest";
    made.xaxis = axis(given.xaxis);
    made.yaxis = axis(given.yaxis);
    if (timed.includes(name)) {
      made.yaxis.fixedrange = name !== "nodes"; // which shows what is near the chaser first
      if (chosen) {
        const [start, end] = windows[chosen - 1];
        const room = 0.05 * (end - start) || 0.01;
        made.xaxis.range = [start - room, end + room];
      }
      made.uirevision = `leg ${chosen}`;
    }
    if (name === "gantt" && narrow.matches) made.yaxis.tickfont = { size: 10 };
    return made;
  }

  // Points of other legs become gaps where a chart has no axis that could be narrowed.
  function only(trace, leg) {
    const mine = (at) => trace.customdata[at] === leg;
    const cut = (values) => values.map((value, at) => (mine(at) ? value : null));
    const shown = { ...trace, x: cut(trace.x), y: cut(trace.y) };
    if (trace.z) shown.z = cut(trace.z);
    return shown;
  }

  function traces(name) {
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

  // Without WebGL, the scene is seen from its camera as a flat drawing.
  function flat(data) {
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
    const along = (trace, way) =>
      trace.x.map((x, at) =>
        x === null ? null : x * way[0] + trace.y[at] * way[1] + trace.z[at] * way[2]);
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
    return Plotly.react(box(name), data, made, options);
  }

  const drawAgain = (names = [...drawn]) =>
    Promise.all(names.filter((name) => drawn.has(name)).map(draw));

  function choose(leg) {
    chosen = leg;
    box("leg").value = String(leg);
    for (const row of document.querySelectorAll("tr[data-leg]")) {
      row.classList.toggle("chosen", Number(row.dataset.leg) === leg);
    }
    return drawAgain();
  }

  // What is zoomed in one chart of times is zoomed in all of them.
  let following = false;
  function follow(name, event) {
    if (following) return;
    let range = null;
    if ("xaxis.range[0]" in event) range = [event["xaxis.range[0]"], event["xaxis.range[1]"]];
    else if ("xaxis.range" in event) range = event["xaxis.range"];
    else if (event["xaxis.autorange"]) range = figures[name].layout.xaxis.range;
    if (!range) return;
    following = true;
    const update = { "xaxis.range": range, "xaxis.autorange": false };
    const others = timed.filter((other) => other !== name || event["xaxis.autorange"]);
    Promise.all(others.map((other) => Plotly.relayout(box(other), update)))
      .finally(() => { following = false; });
  }

  function listen() {
    box("leg").addEventListener("change", (event) => choose(Number(event.target.value)));
    for (const row of document.querySelectorAll("tr[data-leg]")) {
      row.addEventListener("click", () => {
        const leg = Number(row.dataset.leg);
        choose(leg === chosen ? 0 : leg);
      });
    }
    for (const button of document.querySelectorAll("button.phase")) {
      button.addEventListener("click", () => {
        const { phase } = button.dataset;
        const off = !hidden.has(phase);
        if (off) hidden.add(phase);
        else hidden.delete(phase);
        button.setAttribute("aria-pressed", String(!off));
        drawAgain(["lanes", "altitude", "nodes", "gantt", "orbits"]);
      });
    }
    for (const name of timed) {
      box(name).on("plotly_relayout", (event) => follow(name, event));
    }
    for (const name of ["lanes", "gantt", "costs"].filter((name) => name in figures)) {
      box(name).on("plotly_click", (event) => choose(event.points[0].customdata));
    }
    for (const query of [dark, narrow]) query.addEventListener("change", () => drawAgain());
  }

  // One chart per task, so that the page can be scrolled in between; the orbits, which take
  // longest, when everything else works and they come near the window.
  const pause = () => new Promise((done) => setTimeout(done));
  const mark = (what) => {
    document.documentElement.dataset[what] = String(Math.round(performance.now()));
  };
  (async () => {
    for (const name of quick) {
      await draw(name);
      await pause();
    }
    listen();
    mark("ready");
    if (!("orbits" in figures)) {
      mark("complete");
      return;
    }
    const near = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      near.disconnect();
      draw("orbits").then(() => mark("complete"));
    }, { rootMargin: "300px" });
    near.observe(box("orbits"));
  })();
})();
