// The frame beside the views: the report of the plan, or the page of a result.
import { box, made } from "./dom.js";
import { follow } from "./store.js";

let reported = null; // number of the plan whose report is there
let paged = null; // number of the result whose page is there

// Another frame each time, so that the way back in the browser leads out of the page. It runs
// scripts of its own, and has no way to those of this page.
function open(title, address, loaded) {
  const frame = made("iframe", { title, sandbox: "allow-scripts allow-downloads", src: address });
  frame.addEventListener("load", loaded);
  box("frame").replaceChildren(frame);
}

function showReport(state) {
  const number = state.plan?.number ?? 0;
  if (number === reported || (state.stage ?? "mission") !== "mission") return;
  reported = number;
  paged = null;
  open("Report of the plan", `/report?plan=${number}`, () => {
    document.documentElement.dataset.reported = String(number);
  });
}

export function showPage(id, label) {
  if (paged === id) return;
  paged = id;
  open(label, `/results/page?id=${encodeURIComponent(id)}`, () => {
    document.documentElement.dataset.paged = String(id);
  });
}

// The report of the plan again, after the page of a result.
export function showPlanReport(state) {
  if (paged === null) return;
  reported = null;
  showReport(state);
}

export function start() {
  follow("state", showReport);
}
