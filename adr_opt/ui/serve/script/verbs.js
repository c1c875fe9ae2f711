// Verbs of the server as a small menu: a button for each, its options, and what it waits for.
import { box, button, made, put } from "./dom.js";
import { fieldOf } from "./field.js";
import { onSelection, selection } from "./results.js";
import { follow, told } from "./store.js";
import { begin } from "./talk.js";

const verbs = new Map(); // by name: { press, panel, run, why, fields }

// Why a verb cannot begin yet; empty if it can.
function missing(needs) {
  const chosen = selection().length;
  for (const need of needs ?? []) {
    if (need === "plan" && !told.state?.plan) return "Needs a plan: press Plan in the mission view.";
    if (need === "two plans" && chosen !== 2) return "Select two plans in the list of results.";
    if (need === "plans" && chosen < 2) return "Select at least two plans in the list of results.";
  }
  return "";
}

function panelOf(name, { label, options = [] }) {
  const fields = options.map((option) => [option.name, fieldOf(option, `${name}-${option.name}`)]);
  const why = made("p", { class: "why", id: `${name}-why`, "aria-live": "polite" });
  const run = button(`Begin: ${label}`, async () => {
    const given = {};
    for (const [option, field] of fields) {
      const value = field.read();
      if (value !== null) given[option] = value;
    }
    run.disabled = true;
    await begin(name, given, selection());
    show();
  }, { class: "act first", "aria-describedby": `${name}-why` });
  const panel = made("div", { class: "panel-of", id: `verb-${name}`, hidden: true },
    made("div", { class: "form" }, ...fields.map(([, field]) => field.row)), run, why);
  const press = button(label, () => {
    const opens = panel.hidden;
    for (const other of verbs.values()) {
      other.panel.hidden = true;
      other.press.setAttribute("aria-expanded", "false");
    }
    panel.hidden = !opens;
    press.setAttribute("aria-expanded", String(opens));
  }, { "aria-expanded": "false", "aria-controls": `verb-${name}` });
  return { press, panel, run, why, fields };
}

function show() {
  for (const [name, { run, why }] of verbs) {
    const said = missing(told.choices.verbs[name].needs);
    run.disabled = said !== "";
    put(why, said);
  }
}

function build(choices) {
  verbs.clear();
  for (const [name, verb] of Object.entries(choices.verbs ?? {})) {
    if (name === "worth" || name === "replan") continue; // have places of their own
    verbs.set(name, panelOf(name, verb));
  }
  const all = [...verbs.values()];
  box("verbs").replaceChildren(...all.map(({ press }) => press));
  box("panels").replaceChildren(...all.map(({ panel }) => panel));
  show();
}

export function start() {
  follow("choices", build);
  follow("state", () => told.choices && show());
  onSelection(() => told.choices && show());
}
