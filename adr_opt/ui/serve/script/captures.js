// Light and contacts: windows of captures are found by a job, taken up as an edit, and lifted.
import { box, put } from "./dom.js";
import { optionFields } from "./field.js";
import { follow, told } from "./store.js";
import { begin, send } from "./talk.js";

const SAID = {
  found: "Each capture waits for a window of those that were found, which the report shows as bands; "
    + "find them anew after another duration or other orbits.",
  given: "Targets have windows of their own, in a file that came with the mission; those that are "
    + "found lie within them.",
};

function show({ captures, instance }) {
  put("captures", SAID[captures] ?? "Captures may be at any time that the windows of targets allow.");
  box("windows").disabled = !instance;
  box("lift").disabled = captures !== "found";
}

let fields = [];

function build(choices) {
  fields = optionFields("windows", choices.verbs?.windows?.options ?? []);
  box("windows-options").replaceChildren(...fields.map(([, field]) => field.row));
}

// What is emptied is not asked for, and not as usual.
const asked = () => Object.fromEntries(fields.map(([name, field]) => [name, field.read()]));

export function start() {
  follow("choices", build);
  follow("state", show);
  box("windows").addEventListener("click", () => begin("windows", asked()));
  box("lift").addEventListener("click", () => send("/lift"));
}
