// What the reader does, and the order in which the page is drawn.
function choose(leg) {
  chosen = leg;
  box("leg").value = String(leg);
  for (const row of document.querySelectorAll("tr[data-leg]")) {
    row.classList.toggle("chosen", Number(row.dataset.leg) === leg);
  }
  for (const row of document.querySelectorAll("tr[data-of]")) {
    row.classList.toggle("chosen", Number(row.dataset.of) === leg);
  }
  fitSlider();
  setTime(time);
  return drawAgain();
}

// A page that the report is part of is told which object was clicked.
function told(name) {
  if (parent !== window) parent.postMessage({ object: name }, "*");
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

// Tables that go on to the side say so at their edge.
function sides() {
  for (const table of document.querySelectorAll(".scroll")) {
    const edge = () =>
      table.classList.toggle("more", table.scrollLeft + table.clientWidth < table.scrollWidth - 1);
    table.addEventListener("scroll", edge, { passive: true });
    new ResizeObserver(edge).observe(table);
    edge();
  }
}

function listen() {
  box("leg").addEventListener("change", (event) => choose(Number(event.target.value)));
  for (const row of document.querySelectorAll("tr[data-leg]")) {
    row.addEventListener("click", () => {
      const leg = Number(row.dataset.leg);
      choose(leg === chosen ? 0 : leg);
    });
  }
  for (const button of document.querySelectorAll("button[data-phase]")) {
    button.addEventListener("click", () => {
      const { phase } = button.dataset;
      const off = !hidden.has(phase);
      if (off) hidden.add(phase);
      else hidden.delete(phase);
      button.setAttribute("aria-pressed", String(!off));
      drawAgain(["lanes", "altitude", "nodes", "gantt"]);
    });
  }
  for (const name of timed) {
    box(name).on("plotly_relayout", (event) => follow(name, event));
  }
  for (const name of ["lanes", "gantt", "costs"].filter((name) => name in figures)) {
    box(name).on("plotly_click", (event) => choose(event.points[0].customdata));
  }
  if (figures.planes) {
    box("planes").on("plotly_click", ({ points: [{ id }] }) => id && told(id));
  }
  for (const query of [dark, narrow]) {
    query.addEventListener("change", async () => {
      await drawAgain();
      for (const { chart, show: shown } of views) if (derived.has(chart)) await shown();
    });
  }
}

// Charts are as wide as the window; on paper they are as wide as what A4 and letters have room for.
const PAPER_PX = 690;
const PAPER_HEIGHT_PX = { budget: 170, ground: PAPER_PX / 2 };
const onPaper = (width) => Promise.all(
  [...document.querySelectorAll(".chart")].filter((chart) => chart.data?.length).map((chart) => {
    const own = chart.classList.contains("own") ? chart.layout.height : undefined;
    const height = own ?? (width ? PAPER_HEIGHT_PX[chart.id] ?? 300 : undefined);
    return Plotly.relayout(chart, { width, height, autosize: !width });
  }),
);

// The story and its legs alone.
function printBrief() {
  document.documentElement.classList.add("brief");
  print();
}

// One chart per task, so that the page can be scrolled in between; the globe comes first.
const pause = () => new Promise((done) => setTimeout(done));
const mark = (what) => {
  document.documentElement.dataset[what] = String(Math.round(performance.now()));
};
async function begin() {
  if (box("orbits")) {
    madeReachable(box("orbits"));
    showGlobe();
    await pause();
  }
  for (const name of quick) {
    await draw(name);
    await pause();
  }
  fitSlider();
  await setTime(0);
  listen();
  listenToTime();
  listenToCloseup();
  listenToBurns();
  listenToPictures();
  listenToView();
  listenToTools();
  listenToZones();
  window.addEventListener("beforeprint", () => onPaper(PAPER_PX));
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("brief");
    onPaper(undefined);
  });
  box("brief").addEventListener("click", printBrief);
  sides();
  mark("ready");
  for (const view of views.filter(({ chart }) => derived.has(chart))) {
    await view.show();
    await pause();
  }
  mark("complete");
}
await begin();
