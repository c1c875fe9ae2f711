// Views of the page: objects, mission, results; in a narrow window also what stands beside them.
import { box } from "./dom.js";
import { follow } from "./store.js";

const VIEWS = ["objects", "mission", "results"];
const BESIDE = { objects: "Plots", mission: "Report", results: "Pages" };
const changed = [];
let stage = null;

export const onView = (act) => changed.push(act);
export const viewed = () => document.body.dataset.view;

function mark() {
  const beside = document.body.classList.contains("at-report");
  for (const name of VIEWS) {
    box(`to-${name}`).setAttribute("aria-pressed", String(!beside && name === viewed()));
    box(`view-${name}`).hidden = name !== viewed();
  }
  box("to-report").setAttribute("aria-pressed", String(beside));
  box("to-report").textContent = BESIDE[viewed()];
  box("plots-pane").hidden = viewed() !== "objects";
  box("frame").hidden = viewed() === "objects";
  for (const act of changed) act(viewed());
}

export function view(name) {
  const lost = box(`view-${viewed()}`).contains(document.activeElement);
  if (name !== viewed()) box("desk").scrollTop = 0; // how far down one is says nothing of another
  document.body.dataset.view = name;
  document.body.classList.remove("at-report");
  mark();
  if (lost) box(`to-${name}`).focus(); // what had the focus is hidden
}

// In a narrow window: what stands beside the view.
export function beside() {
  if (getComputedStyle(box("to-report")).display !== "none") box("to-report").click();
}

export function start() {
  for (const name of VIEWS) box(`to-${name}`).addEventListener("click", () => view(name));
  box("to-report").addEventListener("click", () => {
    document.body.classList.add("at-report");
    mark();
  });
  follow("state", (state) => {
    const now = state.stage ?? "mission";
    for (const name of ["mission", "results"]) box(`to-${name}`).disabled = now !== "mission";
    // The page goes along when a mission comes to be, or is taken back.
    if (stage === null || (now === "mission") !== (stage === "mission")) {
      view(now === "mission" ? "mission" : "objects");
    }
    stage = now;
    document.documentElement.dataset.stage = now;
  });
}
