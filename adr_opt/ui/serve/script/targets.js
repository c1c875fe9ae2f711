// The table of targets: prize, required, excluded, one by one or all that are shown.
import { box, made, placed, text } from "./dom.js";
import { fieldOf } from "./field.js";
import { again, follow, told } from "./store.js";
import { complain, edit, refusal } from "./talk.js";

const MOST_ROWS = 300; // the filter finds the others
const rows = new Map(); // by name
let shown = []; // names of the targets in the table

function rowOf(name) {
  if (rows.has(name)) return rows.get(name);
  const number = { type: "number", min: "0", step: "any", "aria-label": `Prize of ${name}` };
  const prize = made("input", number);
  const required = made("input", { type: "checkbox", "aria-label": `Require ${name}` });
  const excluded = made("input", { type: "checkbox", "aria-label": `Exclude ${name}` });
  const row = made("tr", {}, made("td", { title: name }, name),
    ...[prize, required, excluded].map((input) => made("td", {}, input)));
  const change = (changes) => edit({ targets: { names: [name], ...changes } });
  prize.addEventListener("change", () => {
    if (prize.value !== "") change({ prize: Number(prize.value) });
    else again("state");
  });
  required.addEventListener("change", () => change({ required: required.checked }));
  excluded.addEventListener("change", () => change({ excluded: excluded.checked }));
  const parts = { row, prize, required, excluded };
  rows.set(name, parts);
  return parts;
}

const KINDS = {
  all: () => true,
  visited: ([, , , , visited]) => visited,
  left: ([, , , excluded, visited]) => !visited && !excluded,
  required: ([, , required]) => required,
  excluded: ([, , , excluded]) => excluded,
};

function show(state) {
  const targets = state?.targets ?? [];
  const wanted = box("filter").value.trim().toLowerCase();
  const kind = KINDS[box("kind").value];
  const found = targets.filter(
    (target) => kind(target) && target[0].toLowerCase().includes(wanted));
  const first = found.slice(0, MOST_ROWS);
  for (const [name, prize, required, excluded, visited] of first) {
    const parts = rowOf(name);
    if (document.activeElement !== parts.prize || Number(parts.prize.value) !== prize) {
      parts.prize.value = text(prize, 10);
    }
    parts.required.checked = required;
    parts.excluded.checked = excluded;
    parts.row.classList.toggle("excluded", excluded);
    parts.row.classList.toggle("visited", visited);
  }
  placed(box("targets"), first.map(([name]) => rowOf(name).row));
  shown = found.map(([name]) => name);
  const more = found.length - first.length;
  box("more").textContent = more
    ? `${more} more: the filter finds them; what is set of all shown is set of them, too` : "";
  box("shown").textContent = `All ${found.length} shown:`;
  for (const name of ["exclude-shown", "include-shown", "set-shown", "prize-shown"]) {
    box(name).disabled = !found.length;
  }
  for (const [at, field] of services) {
    const values = new Set(found.map((target) => JSON.stringify(target[at])));
    field.set(values.size === 1 ? JSON.parse([...values][0]) : null);
    field.control.disabled = !found.length;
  }
  const count = (kindOf) => targets.filter(KINDS[kindOf]).length;
  box("counts").textContent = `${targets.length} in all, ${count("visited")} visited, `
    + `${count("required")} required, ${count("excluded")} excluded`;
}

// Fields that are set of all targets shown, and show what these have in common.
const PLACES = { window_s: 5, removal: 6, mass_kg: 7 };
let services = [];

function build(forms) {
  services = forms.filter(({ part }) => part === "targets").map((spec) => {
    const change = (value) => refusal({ targets: { names: shown, [spec.path]: value } });
    return [PLACES[spec.path], fieldOf({ ...spec, default: spec.kind === "list" ? [null, null] : null },
      `targets-${spec.path}`, change)];
  });
  box("services").replaceChildren(...services.map(([, field]) => field.row));
}

export function start() {
  follow("forms", build);
  follow("state", show);
  box("filter").addEventListener("input", () => show(told.state));
  box("kind").addEventListener("change", () => show(told.state));
  const all = (changes) => edit({ targets: { names: shown, ...changes } });
  box("exclude-shown").addEventListener("click", () => all({ excluded: true }));
  box("include-shown").addEventListener("click", () => all({ excluded: false }));
  box("set-shown").addEventListener("click", () => {
    if (box("prize-shown").value !== "") all({ prize: Number(box("prize-shown").value) });
    else complain("a prize of all shown: give a number first");
  });
}
