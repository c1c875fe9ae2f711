// Verbs of the server as a small menu: a button for each, its options, and what it waits for.
import { box, button, made, put } from "./dom.js";
import { optionFields, valuesOf } from "./field.js";
import { nameOf, onSelection, selection } from "./results.js";
import { follow, told } from "./store.js";
import { begin } from "./talk.js";

const verbs = new Map(); // by name: { press, panel, run, why, fields }

// Why a verb cannot begin yet; empty if it can.
function missing(needs) {
  const chosen = selection();
  const plans = chosen.filter((result) => result.has_plan);
  const dropped = (what) => told.state?.files?.some((file) => file.what.includes(what));
  const absent = {
    plan: !told.state?.plan && !chosen.length && "Needs a plan: press Plan in the mission view.",
    plans: plans.length < 2 ? "Select two plans or more in the list of results."
      : new Set(plans.map(({ mission }) => mission)).size > 1
        && "These plans are of different missions: above the list stands what one gains and loses, by name.",
    certificate: !told.results.some(({ files }) => files.some((name) => name.startsWith("certificate")))
      && "Needs a certificate: prove a bound with one first.",
  };
  absent["plan or refined"] = absent.plan;
  absent.refined = absent.plan || (!told.results.some(({ files }) => files.includes("refined.json"))
    && "Needs a refined plan: refine the plan first.");
  absent.catalogue = !dropped("catalogue") && "Needs a dropped catalogue of objects.";
  return needs.map((need) => absent[need]).find(Boolean) ?? "";
}

function panelOf(name, { label, options = [] }) {
  const fields = optionFields(name, options);
  const why = made("p", { class: "why", id: `${name}-why`, "aria-live": "polite" });
  const run = button(label, async () => {
    run.disabled = true;
    await begin(name, valuesOf(fields), selection().map(({ id }) => id));
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

// What a verb acts on: the plans that are selected, or the one that is shown.
function subject(needs) {
  if (needs.includes("instance")) return "";
  const chosen = selection();
  const refined = /refined/.test(needs) && chosen.find(({ files }) => files.includes("refined.json"));
  const plans = chosen.filter((result) => result.has_plan);
  const shown = told.results.filter(({ id }) => id === told.state?.result);
  const of = refined ? [refined] : plans.length ? plans.slice(0, needs.includes("plans") ? undefined : 1) : shown;
  return of.length ? ` ${of.map(nameOf).join(" and ")}` : "";
}

function show() {
  for (const [name, { run, why }] of verbs) {
    const { label, needs } = told.choices.verbs[name];
    const said = missing(needs);
    put(run, `${label}${subject(needs)}`);
    run.disabled = said !== "";
    put(why, said);
  }
}

function build(choices) {
  verbs.clear();
  for (const [name, verb] of Object.entries(choices.verbs ?? {})) {
    if (["worth", "replan", "windows"].includes(name)) continue; // have places of their own
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
