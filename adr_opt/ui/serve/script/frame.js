// The frame beside the views: the report of the plan, or the page of a result.
import { box, made } from "./dom.js";
import { follow, told } from "./store.js";

let reported = null; // which plan's report is there, or which run's reason for having none
let paged = null; // number of the result whose page is there

// Another frame each time, so that the way back in the browser leads out of the page. It runs
// scripts of its own, and has no way to those of this page.
function open(title, address, loaded) {
  const frame = made("iframe", { title, sandbox: "allow-scripts allow-downloads allow-modals", src: address });
  frame.addEventListener("load", loaded);
  box("frame").replaceChildren(frame);
}

function showReport() {
  const { state, work } = told;
  if (!state || (state.stage ?? "mission") !== "mission") return;
  const number = state.plan?.number ?? 0;
  const without = !number && ["done", "failed"].includes(work?.phase) ? work.number : 0;
  if (`${number} ${without}` === reported) return;
  reported = `${number} ${without}`;
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
export function showPlanReport() {
  if (paged === null) return;
  reported = null;
  showReport();
}

export function start() {
  follow("state", showReport);
  follow("work", showReport);
}
