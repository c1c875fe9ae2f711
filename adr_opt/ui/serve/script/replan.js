// Replanning from a time that is dragged over the duration of the mission.
import { box, DAY_S, text } from "./dom.js";
import { optionFields, valuesOf } from "./field.js";
import { follow, told } from "./store.js";
import { begin } from "./talk.js";

const STEPS = 1000;

function at() {
  return (Number(box("replan-at").value) / STEPS) * told.state.duration_s;
}

function words(seconds) {
  const days = `${text(seconds / DAY_S, 4)} d`;
  const epoch = Date.parse(told.state.epoch ?? told.state.instance?.epoch ?? "");
  const date = new Date(epoch + 1000 * seconds);
  if (Number.isNaN(date.getTime())) return days;
  return `${days}, ${date.toISOString().slice(0, 16).replace("T", " ")} UTC`;
}

function show() {
  const { state } = told;
  if (!state?.duration_s) return;
  const can = Boolean(state.plan);
  box("replan-at").disabled = box("replan").disabled = !can;
  const said = can ? words(at()) : "Needs a plan: press Plan in the mission view.";
  box("replan-when").textContent = said;
  box("replan-at").setAttribute("aria-valuetext", said);
}

let fields = [];

function build(choices) {
  const options = choices.verbs?.replan?.options ?? [];
  fields = optionFields("replan", options.filter(({ name }) => name !== "at_s"));
  box("replan-options").replaceChildren(...fields.map(([, field]) => field.row));
}

export function start() {
  follow("choices", build);
  follow("state", show);
  box("replan-at").addEventListener("input", show);
  box("replan").addEventListener("click", () => (
    begin("replan", { ...valuesOf(fields), at_s: Math.round(at()) })));
}
