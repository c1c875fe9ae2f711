// Forms for chasers, stations, mission, transfer and objective, made from what the server says.
import { branch, branches, stands, withBranch } from "./alternatives.js";
import { box, button, made } from "./dom.js";
import { dig, fieldOf, withValue } from "./field.js";
import { follow, told } from "./store.js";
import { refusal } from "./talk.js";

const LISTS = { chasers: "chaser", stations: "station", keep_out_zones: "zone" };
const SINGLE = { mission: "Mission", transfer: "Transfer", objective: "Objective" };
// Of each group one is given; the others make room for it.
const INSTEAD = [["service_revolutions", "service_s"]];
const EARTH_RADIUS_M = 6378137;
const built = new Map(); // by the place of an element: { key, fields, holder }

const specsOf = (part) => told.forms.filter((spec) => spec.part === part);

// A part is made of what it is when its turn comes, so that of two edits none undoes the other.
const change = (path, make) => refusal(() => ({ part: { path, value: make() } }));

// The fields of one element, each of which changes a copy of it and sends the whole part.
function form(part, at, element, commit) {
  const specs = specsOf(part);
  const id = (path) => `part-${part}${at === null ? "" : `-${at}`}-${path.replaceAll(".", "-")}`;
  const current = () => (at === null ? told.state.instance[part] : told.state.instance[part][at]);
  const one = (spec) => {
    const { path } = spec;
    if (branches(specs, spec)) {
      const write = (chosen) => withBranch(specs, path, current(), chosen, told.state.instance);
      const field = fieldOf(spec, id(path), (chosen) => commit(() => write(chosen)));
      return { field, of: (now) => branch(specs, path, now) };
    }
    const described = path.endsWith(".station")
      ? { ...spec, kind: "choice", choices: stationNames() } : spec;
    const field = fieldOf(described, id(path), (value) => commit(() => changed(current(), path, value)));
    return { field, of: (now) => dig(now, path) ?? (spec.optional ? null : spec.default) };
  };
  return specs.filter((spec) => stands(specs, spec, element))
    .map((spec) => ({ ...spec, ...one(spec) }));
}

function changed(element, path, value) {
  const copy = withValue(element, path, value);
  const group = value === null ? [] : INSTEAD.find((names) => names.includes(path)) ?? [];
  for (const other of group) if (other !== path) copy[other] = null;
  return copy;
}

const stationNames = () => told.state.instance.stations.map(({ name }) => name);

// What the fields of an element depend on beside their values.
const keyOf = (part, element) => JSON.stringify([
  specsOf(part).filter((spec) => stands(specsOf(part), spec, element)).map(({ path }) => path),
  part === "chasers" ? stationNames() : null,
]);

const opened = new Set(); // places whose seldom fields are shown

function fill(place, part, at, element, holder, commit) {
  const key = keyOf(part, element);
  let known = built.get(place);
  if (known?.key !== key || known.holder !== holder) {
    const fields = form(part, at, element, commit);
    const rows = (seldom) => fields.filter((one) => one.seldom === seldom).map(({ field }) => field.row);
    const more = made("details", { class: "more" }, made("summary", {}, "More"), ...rows(true));
    // What is not as usual is seen.
    const unusual = ({ seldom, of, default: usual }) =>
      seldom && JSON.stringify(of(element) ?? null) !== JSON.stringify(usual ?? null);
    more.open = opened.has(place) || fields.some(unusual);
    more.addEventListener("toggle", () => (more.open ? opened.add(place) : opened.delete(place)));
    holder.replaceChildren(...rows(false), ...(rows(true).length ? [more] : []));
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

const cards = Object.fromEntries(Object.keys(LISTS).map((part) => [part, []]));

function card(part, at) {
  const title = made("span");
  const holder = made("div", { class: "form" });
  const why = made("p", { class: "why", "aria-live": "polite" });
  const all = () => told.state.instance[part];
  const tell = async (make) => { why.textContent = await change(part, make); };
  const another = button("Duplicate", () => tell(() => {
    const copy = structuredClone(all()[at]);
    if (copy.name) copy.name = newName(copy.name, all().map(({ name }) => name));
    return [...all(), copy];
  }));
  const less = button("Remove", () => tell(() => all().filter((_, other) => other !== at)));
  const details = made("details", { class: "card" },
    made("summary", {}, title), holder, made("div", { class: "acts small" }, another, less), why);
  const commit = (make) =>
    change(part, () => all().map((other, number) => (number === at ? make() : other)));
  const show = () => {
    const element = all()?.[at];
    if (!element) return;
    title.textContent = element.name ?? `${LISTS[part]} ${at + 1}`;
    another.setAttribute("aria-label", `Duplicate ${title.textContent}`);
    less.setAttribute("aria-label", `Remove ${title.textContent}`);
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

function withAnother(part) {
  const { instance, duration_s: end } = told.state;
  const elements = instance[part];
  if (part === "keep_out_zones") {
    const axis = (instance.stations[0]?.orbit ?? instance.chasers[0].start?.orbit)?.semi_major_axis_m;
    const height = Math.round(((axis ?? EARTH_RADIUS_M + 800000) - EARTH_RADIUS_M) / 1000) * 1000;
    return [...elements, {
      start_s: end / 3, end_s: end / 2, min_altitude_m: height + 10000, max_altitude_m: height + 20000,
    }];
  }
  const names = elements.map(({ name }) => name);
  const like = elements.at(-1) ?? {
    orbit: structuredClone(instance.chasers[0]?.start?.orbit ?? null),
  };
  const name = elements.length ? newName(like.name, names) : LISTS[part];
  return [...elements, { ...structuredClone(like), name }];
}

// How bodies move: a word of the instance, not a part of it.
let dynamics = null;

function showDynamics({ instance }) {
  if (!dynamics) {
    const spec = told.forms.find(({ part }) => part === "dynamics");
    if (!spec) return;
    dynamics = fieldOf(spec, "part-dynamics", (value) => refusal({ dynamics: value }));
    box("dynamics").replaceChildren(dynamics.row);
  }
  dynamics.set(instance.dynamics);
}

// ---- All of it -----------------------------------------------------------------------------------

function show() {
  const { state } = told;
  if (!state?.instance || !told.forms.length) return;
  for (const part of Object.keys(LISTS)) showList(part);
  showDynamics(state);
  for (const part of Object.keys(SINGLE)) {
    const details = box(part).closest("details");
    if (details.open) {
      fill(part, part, null, state.instance[part] ?? {}, box(part), (make) => change(part, make));
    }
  }
}

export function start() {
  for (const part of Object.keys(SINGLE)) {
    box(part).closest("details").addEventListener("toggle", show);
  }
  for (const part of Object.keys(LISTS)) {
    box(`add-${part}`).addEventListener("click", async () => {
      box(`${part}-why`).textContent = await change(part, () => withAnother(part));
    });
  }
  follow("state", show);
  follow("forms", show);
}
