// The view of objects: plots, filters and the list of what was dropped, and the choice among them.
import { brush } from "./brush.js";
import { chooseThese } from "./choose.js";
import { COLUMNS, columnsOf, filtering, known, sift } from "./columns.js";
import { box, button, counted, made, put, text } from "./dom.js";
import { List } from "./list.js";
import { paint } from "./paint.js";
import { rangeFields } from "./ranges.js";
import { Scatter } from "./scatter.js";
import { follow, told } from "./store.js";
import { begin, complain, get } from "./talk.js";

const MOST = 2000; // targets that are chosen at once
const LIST_MS = 120; // the list follows a brush that moves this often
const PAIRS = [["inclination", "altitude"], ["node", "inclination"], ["node", "altitude"]];

let field = null;
let passing = null;
let count = 0;
let painted = null;
let asked = 0;
let listed = 0;
let loaded = null; // what the objects on the page were made of
const filters = { plots: [], ranges: {}, hidden: new Set(), words: "" };
let list = null;
let ranges = null;

// ---- Drawing: at most once a frame ---------------------------------------------------------------

function ask(whole = false) {
  if (whole) listed = 0;
  if (asked || !field) return;
  asked = requestAnimationFrame((now) => {
    asked = 0;
    count = sift(field, filters, passing);
    const ticked = tickedOnes();
    for (const plot of filters.plots) plot.drawOver(passing, count, painted, ticked);
    if (now - listed > LIST_MS) {
      listed = now;
      list.filter(passing);
      say(ticked.length);
    } else setTimeout(() => ask(), LIST_MS);
  });
}

function tickedOnes() {
  const found = [];
  for (let at = 0; at < field.count; at += 1) if (field.ticked[at]) found.push(at);
  return found;
}

// Those that Choose takes: what is ticked, or else what passes the filters.
function wanted(ticks) {
  if (ticks) return ticks;
  return filtering(filters) ? count : 0;
}

function say(ticks) {
  put("objects-count", `${count.toLocaleString("en-GB")} of ${counted(field.count, "object")} shown, `
    + `${ticks.toLocaleString("en-GB")} ticked`);
  const number = wanted(ticks);
  box("choose").disabled = !number || number > MOST;
  const taken = counted(number, ticks ? "ticked object" : "shown object");
  put("choose", number ? `Choose ${taken}` : "Choose");
  put("choose-why", !number ? "Brush, filter or tick objects first."
    : number > MOST ? `At most ${MOST.toLocaleString("en-GB")} objects become targets.` : "");
  box("clear-filters").disabled = !filtering(filters);
  box("untick").disabled = !ticks;
  chips();
}

// ---- Brushes -------------------------------------------------------------------------------------

function chips() {
  const brushes = filters.plots.flatMap(
    (plot) => plot.rectangles.map((rectangle) => ({ plot, rectangle })));
  const key = JSON.stringify(brushes.map(({ plot, rectangle }) => [plot.name, rectangle]));
  if (box("chips").dataset.key === key) return;
  box("chips").dataset.key = key;
  box("chips").replaceChildren(...brushes.map(({ plot, rectangle: [x0, x1, y0, y1], rectangle }) => {
    const part = (name, low, high) =>
      `${COLUMNS[name].label.toLowerCase()} ${text(low, 4)} to ${text(high, 4)} ${COLUMNS[name].unit}`;
    const said = `${part(plot.x, x0, x1)}, ${part(plot.y, y0, y1)}`;
    return made("li", {}, button(`${said} ×`, () => {
      plot.rectangles = plot.rectangles.filter((other) => other !== rectangle);
      ask(true);
    }, { class: "act chip", "aria-label": `Remove the brush: ${said}` }));
  }));
}

// Gives whether there was a brush to clear.
export function clearBrushes() {
  const any = filters.plots.some(({ rectangles }) => rectangles.length);
  for (const plot of filters.plots) plot.rectangles = [];
  ask(true);
  return any;
}

function clearFilters() {
  filters.hidden.clear();
  filters.words = "";
  box("search").value = "";
  ranges.clear();
  clearBrushes();
  legend();
}

function tick(at, on) {
  field.ticked[at] = on ? 1 : 0;
  ask(true);
}

function tickShown(on) {
  for (let at = 0; at < field.count; at += 1) if (!on || passing[at]) field.ticked[at] = on ? 1 : 0;
  ask(true);
}

// ---- Colours -------------------------------------------------------------------------------------

function legend() {
  const by = box("colour-by").value;
  painted = paint(field, by);
  box("legend").replaceChildren(...painted.legend.map(({ shade, words, kind }) => {
    const swatch = made("i", { class: "swatch", "aria-hidden": "true" });
    swatch.style.setProperty("--shade", `var(--${shade})`);
    if (kind === null) return made("li", {}, swatch, words);
    const press = button("", () => {
      const off = !filters.hidden.has(kind);
      if (off) filters.hidden.add(kind);
      else filters.hidden.delete(kind);
      press.setAttribute("aria-pressed", String(!off));
      ask(true);
    }, { class: "act key", "aria-pressed": String(!filters.hidden.has(kind)), title: "Show or hide" });
    press.append(swatch, words);
    return made("li", {}, press);
  }));
}

export function fitPlots() {
  if (!field) return;
  for (const plot of filters.plots) plot.fit();
  ask(true);
}

function zoom(to) {
  for (const plot of filters.plots) plot.bounds = to ? plot.boundsOf(passing) : null;
  fitPlots();
}

// ---- From the server -----------------------------------------------------------------------------

function take(answer) {
  const before = field;
  field = columnsOf(answer);
  // The same objects, with their worth: filters and ticks stay.
  const same = before?.count === field.count
    && field.names.every((name, at) => name === before.names[at]);
  if (same) field.ticked.set(before.ticked);
  else {
    passing = new Uint8Array(field.count).fill(1);
    count = field.count;
    filters.hidden.clear();
    for (const plot of filters.plots) Object.assign(plot, { rectangles: [], bounds: null });
  }
  for (const plot of filters.plots) plot.field = field;
  const worth = known(field.worth);
  box("colour-by").value = worth ? "worth" : "kind";
  box("colour-by").disabled = !worth;
  if (worth) box("prizes").value = "worth";
  else if (box("prizes").value === "worth") box("prizes").value = "one";
  box("prizes").querySelector("[value=worth]").disabled = !worth;
  ranges.take(field, same);
  list.take(field);
  const left = answer.skipped ? `; ${counted(answer.skipped, "object")} left out` : "";
  put("epoch", answer.epoch ? `Elements at ${answer.epoch}${left}` : "");
  legend();
  fitPlots();
  document.documentElement.dataset.objects = String(field.count);
}

// Objects are read again when files were dropped, or worth was worked out.
async function reload(state) {
  const files = state.files ?? [];
  const done = told.jobs.filter(({ verb, state: how }) => verb === "worth" && how === "done").length;
  const key = JSON.stringify([files, done]);
  const any = files.some(({ what }) => /catalogue|ephemer/i.test(what));
  box("with-objects").hidden = !any;
  document.body.classList.toggle("no-objects", !any);
  if (key === loaded || (!any && !field)) return;
  loaded = key;
  const { content, refused } = await get("/objects");
  if (refused) complain(refused);
  take(content ?? { names: [] }); // none that are of other files
}

async function choose() {
  const ticks = tickedOnes();
  const names = [];
  for (let at = 0; at < field.count; at += 1) {
    if (ticks.length ? field.ticked[at] : passing[at]) names.push(field.names[at]);
  }
  box("choose").disabled = true;
  await chooseThese(names);
  ask(true);
}

export function start() {
  for (const [x, y] of PAIRS) filters.plots.push(new Scatter(box("plots"), x, y));
  list = new List(tick);
  ranges = rangeFields(filters, () => ask(true));
  for (const plot of filters.plots) {
    brush(plot, {
      changed: (ended) => ask(ended),
      clicked: (right, down) => {
        const at = plot.nearest(right, down, passing);
        if (at >= 0) tick(at, !field.ticked[at]);
        put("picked", at < 0 ? "" : `${field.names[at]} ${field.ticked[at] ? "ticked" : "not ticked"}`);
      },
    });
  }
  new ResizeObserver(fitPlots).observe(box("plots"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    if (field) legend();
    fitPlots();
  });
  box("search").addEventListener("input", () => {
    filters.words = box("search").value.trim().toLowerCase();
    ask(true);
  });
  box("colour-by").addEventListener("change", () => {
    legend();
    ask(true);
  });
  box("clear-filters").addEventListener("click", clearFilters);
  box("tick-shown").addEventListener("click", () => tickShown(true));
  box("untick").addEventListener("click", () => tickShown(false));
  box("zoom").addEventListener("click", () => zoom(true));
  box("zoom-out").addEventListener("click", () => zoom(false));
  box("choose").addEventListener("click", choose);
  box("work-out").addEventListener("click", () => {
    if (box("years").value === "") complain("worth: give a number of years first");
    else begin("worth", { years: Number(box("years").value) });
  });
  follow("state", reload);
  follow("jobs", () => told.state && reload(told.state));
}
