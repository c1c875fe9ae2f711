// Planning: its orders, its progress, and the figures and notes of the plan that is shown.
import { box, made, NOTHING, put, text } from "./dom.js";
import { follow, told } from "./store.js";
import { send } from "./talk.js";

const PHASES = {
  idle: "Not planned yet",
  waiting: "Waiting for the plan before to stop",
  compiling: "Getting ready",
  timetable: "Building the timetable",
  planning: "Planning",
  done: "Done",
  failed: "Failed",
  lost: "Not followed any more",
};

const plan = () => send("/plan", {
  method: box("method").value,
  time_limit_s: box("limit").value === "" ? 0 : Number(box("limit").value),
  bound: box("bound").value || null,
  goes_on: box("goes-on").checked,
});

function show() {
  const { work, state } = told;
  if (!work) return;
  const { stopping, runs } = work;
  // What was shown since the last run is not of that one.
  const phase = !runs && state && !state.of_last_run ? "idle" : work.phase;
  // While nothing runs: the figures of the plan that is shown, as its report has them. A run that
  // has failed has its own alone.
  const settled = ["idle", "done"].includes(phase) && state?.plan;
  const known = settled
    ? { ...settled, incumbent: settled.objective, bound: settled.upper_bound } : work;
  let line = PHASES[phase];
  if (settled && phase === "idle") {
    line = work.phase === "idle" ? "The plan that was given" : "The plan that is shown";
  }
  if (runs && stopping) line = "Stopping: the best plan so far is on its way";
  put("phase", line);
  put("incumbent", text(known.incumbent));
  put("bound-now", text(known.bound));
  put("gap", known.gap_words);
  const built = phase === "timetable" ? `${Math.round(100 * work.built)} %` : null;
  put("elapsed", phase === "idle" ? NOTHING : built ?? `${work.elapsed_s.toFixed(1)} s`);
  const said = headline(phase, work, state);
  put("failed", said);
  box("failed").hidden = !said;
  put("said", said || phase === "idle" ? "" : work.said);
  box("bar").hidden = !runs;
  if (phase === "timetable") box("bar").value = work.built;
  else if (phase === "planning" && work.limit_s > 0) {
    box("bar").value = Math.min(work.elapsed_s / work.limit_s, 1);
  } else box("bar").removeAttribute("value");
  box("plan").textContent = runs ? "Plan anew" : "Plan";
  box("stop").disabled = !runs || stopping;
  document.documentElement.dataset.phase = phase;
  const chart = phase === "idle" ? "" : work.chart;
  if (box("chart").dataset.drawn !== chart) {
    box("chart").dataset.drawn = chart;
    box("chart").innerHTML = chart;
  }
}

// Why the last run has no plan, or failed after its best one so far; empty if it did not.
function headline(phase, { said }, state) {
  // The state of a run may come before its last words, which are then those of the run before it.
  if (phase === "done" && state && !state.plan && said.startsWith("no plan")) return sentence(said);
  if (phase !== "failed") return "";
  const left = state?.plan ? "its best plan so far is shown" : "there is no plan of this run";
  return `${sentence(said)} Planning failed; ${left}.`;
}

function showPlan(state) {
  const stale = Boolean(state.plan) && !state.plan.fits;
  box("stale").hidden = !stale;
  put("stale", stale ? "Edited since: the report is of the plan before the edits." : "");
  const notes = state.notes ?? state.plan?.notes ?? [];
  box("with-notes").hidden = !notes.length;
  box("notes").replaceChildren(...notes.map((note) => made("li", {}, sentence(note))));
  show();
}

// Notes are parts of lines on the command line.
function sentence(note) {
  const begun = note.charAt(0).toUpperCase() + note.slice(1);
  return /[.!?]$/.test(begun) ? begun : `${begun}.`;
}

export function start() {
  follow("choices", (offered) => {
    box("method").replaceChildren(...offered.methods.map((each) => new Option(each, each)));
    box("method").value = offered.method;
    box("bound").replaceChildren(new Option("none", ""),
      ...offered.bounds.map((each) => new Option(each, each)));
    box("limit").value = text(offered.time_limit_s);
  });
  follow("state", showPlan);
  follow("work", show);
  box("plan").addEventListener("click", plan);
  for (const name of ["stop", "undo", "redo"]) {
    box(name).addEventListener("click", () => send(`/${name}`));
  }
}
