// Forms for chasers, stations, mission, transfer and objective, made from what the server says.
import { ALTERNATIVES, stands } from "./alternatives.js";
import { box, button, made } from "./dom.js";
import { dig, fieldOf, withValue } from "./field.js";
import { follow, told } from "./store.js";
import { post } from "./talk.js";

const LISTS = { chasers: "chaser", stations: "station" };
const SINGLE = { mission: "Mission", transfer: "Transfer", objective: "Objective" };
const built = new Map(); // by the place of an element: { key, fields, holder }

const specsOf = (part) => told.forms.filter((spec) => spec.part === part);

async function change(path, value) {
  const { refused } = await post("/edit", { part: { path, value } });
  return refused;
}

// The fields of one element, each of which changes a copy of it and sends the whole part.
function form(part, at, element, commit) {
  const fields = [];
  const id = (path) => `part-${part}${at === null ? "" : `-${at}`}-${path.replaceAll(".", "-")}`;
  const current = () => (at === null ? told.state.instance[part] : told.state.instance[part][at]);
  const choices = part === "chasers" ? ALTERNATIVES.map((one) => {
    const { instance } = told.state;
    const spec = { ...one, choices: one.choices(instance) };
    const write = (chosen) => commit(one.write(current(), chosen, told.state.instance));
    return { field: fieldOf(spec, id(one.path), write), of: one.read };
  }) : [];
  for (const spec of specsOf(part).filter(({ path }) => stands(element, path))) {
    const field = fieldOf(spec, id(spec.path), (value) => commit(withValue(current(), spec.path, value)));
    fields.push({ field, of: (now) => dig(now, spec.path) ?? (spec.optional ? null : spec.default) });
  }
  return [...fields.slice(0, 1), ...choices, ...fields.slice(1)]; // the name comes first
}

// What the fields of an element depend on beside their values.
const keyOf = (part, element) => JSON.stringify([
  specsOf(part).map(({ path }) => path).filter((path) => stands(element, path)),
  part === "chasers" ? told.state.instance.stations.map(({ name }) => name) : null,
]);

function fill(place, part, at, element, holder, commit) {
  const key = keyOf(part, element);
  let known = built.get(place);
  if (known?.key !== key || known.holder !== holder) {
    const fields = form(part, at, element, commit);
    holder.replaceChildren(...fields.map(({ field }) => field.row));
    known = { key, fields, holder };
    built.set(place, known);
  }
  for (const { field, of } of known.fields) field.set(of(element));
}

function newName(name, names) {
  const stem = name.replace(/ \d+$/, "");
  for (let number = 2; ; number += 1) {
    if (!names.includes(`${stem} ${number}`)) return `${stem} ${number}`;
  }
}

// ---- Lists ---------------------------------------------------------------------------------------

const cards = { chasers: [], stations: [] };

function card(part, at) {
  const title = made("span");
  const holder = made("div", { class: "form" });
  const why = made("p", { class: "why", "aria-live": "polite" });
  const all = () => told.state.instance[part];
  const tell = async (elements) => { why.textContent = await change(part, elements); };
  const another = button("Duplicate", () => {
    const copy = structuredClone(all()[at]);
    copy.name = newName(copy.name, all().map(({ name }) => name));
    tell([...all(), copy]);
  });
  const less = button("Remove", () => tell(all().filter((_, other) => other !== at)));
  const details = made("details", { class: "card" },
    made("summary", {}, title), holder, made("div", { class: "acts small" }, another, less), why);
  const commit = (element) =>
    change(part, all().map((other, number) => (number === at ? element : other)));
  const show = () => {
    const element = all()?.[at];
    if (!element) return;
    title.textContent = element.name;
    another.setAttribute("aria-label", `Duplicate ${element.name}`);
    less.setAttribute("aria-label", `Remove ${element.name}`);
    less.disabled = part === "chasers" && all().length === 1;
    // Fields are made when somebody looks at them first.
    if (details.open) fill(`${part} ${at}`, part, at, element, holder, commit);
  };
  details.addEventListener("toggle", show);
  return { details, show };
}

function showList(part) {
  const elements = told.state.instance[part] ?? [];
  const holder = box(part);
  while (cards[part].length < elements.length) {
    const one = card(part, cards[part].length);
    cards[part].push(one);
    holder.append(one.details);
  }
  while (cards[part].length > elements.length) cards[part].pop().details.remove();
  for (const { show } of cards[part]) show();
}

function add(part) {
  const elements = told.state.instance[part];
  const names = elements.map(({ name }) => name);
  const like = elements.at(-1) ?? {
    orbit: structuredClone(told.state.instance.chasers[0]?.start?.orbit ?? null),
  };
  const name = elements.length ? newName(like.name, names) : LISTS[part];
  return change(part, [...elements, { ...structuredClone(like), name }]);
}

// ---- All of it -----------------------------------------------------------------------------------

function show() {
  const { state } = told;
  if (!state?.instance || !told.forms.length) return;
  for (const part of Object.keys(LISTS)) showList(part);
  for (const part of Object.keys(SINGLE)) {
    const details = box(part).closest("details");
    if (details.open) {
      fill(part, part, null, state.instance[part] ?? {}, box(part), (value) => change(part, value));
    }
  }
}

export function start() {
  for (const part of Object.keys(SINGLE)) {
    box(part).closest("details").addEventListener("toggle", show);
  }
  for (const part of Object.keys(LISTS)) {
    box(`add-${part}`).addEventListener("click", async () => {
      box(`${part}-why`).textContent = await add(part);
    });
  }
  follow("state", show);
  follow("forms", show);
}
