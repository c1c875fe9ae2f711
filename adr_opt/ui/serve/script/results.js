// Everything that was made: opened in the frame, shown as the plan, selected for comparisons.
import { box, button, counted, made, placed, put, text } from "./dom.js";
import { showPage, showPlanReport } from "./frame.js";
import { showPoints } from "./points.js";
import { follow, told } from "./store.js";
import { send } from "./talk.js";
import { beside } from "./views.js";

const selected = new Set();
const watching = [];
const rows = new Map();
let newest = null;

export const selection = () => told.results.filter(({ id }) => selected.has(id));
export const onSelection = (act) => watching.push(act);

function figures(result) {
  const said = [];
  const value = (words, number, unit = "") => {
    if (number !== null && number !== undefined) said.push(`${words} ${text(number, 5)}${unit}`);
  };
  value("objective", result.objective);
  value("bound", result.bound);
  if (result.gap !== null && result.gap !== undefined) said.push(`gap ${text(100 * result.gap, 3)} %`);
  value("ΔV", result.delta_v_m_s, " m/s");
  if (Number.isInteger(result.targets)) said.push(counted(result.targets, "target"));
  if (result.status) said.push(result.status);
  return said.join(", ");
}

// Messages of a verb: one or two stand in the list, more can be opened.
const FEW = 2;

// Files that are of use elsewhere.
const TAKEN = /^(flight\..*|disposal\.json|.*\.(csv|zip|oem|cdm|kvn))$/;

export const nameOf = (result) => `${result.label || result.verb} (${result.id})`;
const named = (id) => {
  const found = told.results.find((each) => each.id === id);
  return found ? nameOf(found) : String(id);
};

function messages(result) {
  const lines = (result.said ?? "").split("\n").map((line) => line.replace(/^adr-opt: /, ""))
    .filter((line) => line && !line.startsWith("wrote "));
  if (!lines.length) return null;
  if (lines.length <= FEW) return made("span", { class: "said" }, lines.join("; "));
  return made("details", { class: "said" }, made("summary", {}, counted(lines.length, "message")),
    ...lines.map((line) => made("p", {}, line)));
}

function rowOf(result) {
  if (rows.has(result.id)) return rows.get(result.id);
  const name = nameOf(result);
  const tick = made("input", { type: "checkbox", "aria-label": `Select ${name}` });
  tick.addEventListener("change", () => {
    if (tick.checked) selected.add(result.id);
    else selected.delete(result.id);
    for (const act of watching) act();
  });
  const said = made("span", { class: "said" });
  const acts = made("span", { class: "acts small" });
  for (const file of result.files.filter((each) => TAKEN.test(each))) {
    acts.append(made("a", {
      class: "act", download: "", "aria-label": `Download ${file} of ${name}`,
      href: `/results/file?id=${result.id}&name=${encodeURIComponent(file)}`,
    }, file));
  }
  const open = () => openPage(result);
  if (result.has_page) acts.append(button("Open", open, { "aria-label": `Open ${name}` }));
  if (result.verb === "tradeoff") {
    acts.append(button("Points", () => showPoints(result.id, result.label || result.verb),
      { "aria-label": `Points of ${name}` }));
  }
  const show = button("Show", () => send("/show", { result: result.id }),
    { "aria-label": `Show the plan of ${name}` });
  if (result.has_plan) acts.append(show);
  const moment = result.made_at?.slice(0, 16).replace("T", " ") ?? "";
  const when = made("time", { datetime: result.made_at }, moment);
  const of = result.verb !== "solve" && result.inputs.length
    ? ` of ${result.inputs.map(named).join(" and ")}` : "";
  const row = made("li", { class: "result" }, tick,
    made("span", { class: "what" }, made("b", {}, name), of, " ", when), acts, said);
  const told = messages(result);
  if (told) row.append(told);
  row.dataset.verb = result.verb;
  row.dataset.id = String(result.id);
  rows.set(result.id, { row, said, show, tick });
  return rows.get(result.id);
}

// Two plans that are selected, one over the other: what the later one gains and loses.
function overlay() {
  const [one, other, ...more] = selection().filter(({ has_plan: has }) => has);
  const known = ({ visited, targets }) => visited.length > 0 || !targets;
  box("overlay").hidden = !other || more.length > 0 || !known(one) || !known(other);
  if (box("overlay").hidden) return;
  const without = (from, taken) => from.visited.filter((name) => !taken.visited.includes(name));
  const listed = (words, names) => (names.length ? `${words} ${names.join(", ")}` : "");
  const more_ = (value, digits, unit) => `${value < 0 ? "−" : "+"}${text(Math.abs(value), digits)}${unit}`;
  box("overlay").replaceChildren(
    made("b", {}, `${nameOf(one)} → ${nameOf(other)}`), ": ",
    [`prize ${more_(other.objective - one.objective, 5, "")}`,
      `ΔV ${more_(other.delta_v_m_s - one.delta_v_m_s, 4, " m/s")}`,
      listed("gains", without(other, one)), listed("loses", without(one, other))]
      .filter(Boolean).join("; "),
  );
}

function openPage(result) {
  showPage(result.id, result.label || result.verb);
  beside();
}

function showResults() {
  const { results, state } = told;
  for (const result of results) {
    const { row, said, show } = rowOf(result);
    put(said, figures(result));
    const shown = state?.result === result.id;
    row.classList.toggle("shown", shown);
    show.disabled = shown;
  }
  placed(box("results"), results.map(({ id }) => rows.get(id).row).reverse());
  put("results-none", results.length ? "" : "Nothing made yet: Plan makes the first one.");
  document.documentElement.dataset.results = String(results.length);
}

// What a job has made opens beside the list, where it has a page of its own.
function openNewest(results) {
  const last = results.at(-1);
  if (newest !== null && last && last.id !== newest && last.has_page && last.verb !== "solve"
    && document.body.dataset.view === "results") showPage(last.id, last.label || last.verb);
  newest = last?.id ?? 0;
}

export function start() {
  onSelection(overlay);
  follow("results", (results) => {
    showResults();
    openNewest(results);
    for (const act of watching) act();
  });
  follow("state", showResults);
  box("report-again").addEventListener("click", () => {
    showPlanReport();
    beside();
  });
}
