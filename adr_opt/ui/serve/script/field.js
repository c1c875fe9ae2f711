// A field of a form as the server describes it: label, unit, help, and why a value is refused.
import { DAY_S, made, text } from "./dom.js";
import { told } from "./store.js";

// Values of choices in words, where they are none.
const WORDS = {
  "delta-v": "ΔV", mass: "mass", station: "at a station", orbit: "own orbit", launch: "launched into an orbit", anywhere: "anywhere", given: "stated",
  circle_m: "circle", perigee_m: "perigee",
};

const EMPTY = "";

// Lists are written as numbers between commas; nothing between two of them stands for none.
function ofList(written) {
  return written.split(",").map((part) => {
    const word = part.trim();
    if (word === EMPTY) return null;
    return Number.isNaN(Number(word)) ? word : Number(word);
  });
}

const wordsOf = (value) => (Array.isArray(value) ? value.map((each) => each ?? EMPTY).join(", ") : EMPTY);

// Numbers are shown in a unit that people use: one of it is spec.by in the unit of the file.
const shownAs = ({ by = 1 }, value) => (typeof value === "number" ? value / by : value);
const numberInput = (spec, more = {}) => made("input", {
  type: "number", step: spec.whole ? "1" : "any", inputmode: "decimal", min: shownAs(spec, spec.least),
  max: shownAs(spec, spec.most), ...more,
});
const numberOf = ({ by = 1 }, input) => (
  input.value === EMPTY ? null : Number((Number(input.value) * by).toPrecision(14)));
const wordOf = (spec, value) => (typeof value === "number" ? text(shownAs(spec, value), 12) : EMPTY);

// What limits may be varied around, in the unit that they are varied in.
const NOW = {
  duration: (state) => state.duration_s / DAY_S,
  "delta-v": (state) => state.chasers[0]?.delta_v_m_s,
  propellant: (state) => (state.chasers[0]?.unit === "kg" ? state.chasers[0].amount : undefined),
};
const SHARES = [0.5, 1.5, 0.25]; // of that: from, to, and step

// The control, its value read, and its value set; where there are others beside it, these, too.
const CONTROLS = {
  number: (spec) => {
    const control = numberInput(spec);
    return {
      control,
      read: () => numberOf(spec, control),
      write: (value) => { control.value = wordOf(spec, value); },
    };
  },
  window: (spec, titled) => {
    const control = numberInput(spec, { placeholder: "from" });
    const second = numberInput(spec, { placeholder: "to", "aria-label": `${titled}, to` });
    return {
      control,
      others: [second],
      read: () => [control, second].map((input) => numberOf(spec, input)),
      write: (value) => [control, second].forEach((input, at) => { input.value = wordOf(spec, value?.[at]); }),
    };
  },
  text: () => {
    const control = made("input", { type: "text", autocomplete: "off" });
    return {
      control,
      read: () => (control.value.trim() === EMPTY ? null : control.value.trim()),
      write: (value) => { control.value = value ?? EMPTY; },
    };
  },
  list: () => {
    const control = made("input", { type: "text", autocomplete: "off" });
    return {
      control,
      read: () => (control.value.trim() === EMPTY ? null : ofList(control.value)),
      write: (value) => { control.value = wordsOf(value); },
    };
  },
  choice: (spec) => {
    const control = made("select");
    if (spec.optional) control.append(new Option(spec.absent ?? "none", EMPTY));
    control.append(...(spec.choices ?? []).map((each) => new Option(WORDS[each] ?? each, each)));
    return {
      control,
      read: () => (control.value === EMPTY ? null : control.value),
      write: (value) => { control.value = value ?? EMPTY; },
    };
  },
  vary: (spec, titled) => {
    const control = made("select", {}, new Option("nothing", EMPTY));
    control.append(...spec.choices.map((each) => new Option(spec.words[each] ?? each, each)));
    const others = ["from", "to", "step"].map((word) => (
      numberInput(spec, { placeholder: word, "aria-label": `${titled}, ${word}` })));
    control.addEventListener("change", () => {
      const now = told.state && NOW[control.value]?.(told.state);
      others.forEach((input, at) => { input.value = now ? text(SHARES[at] * now) : EMPTY; });
    });
    return {
      control,
      others,
      read: () => (control.value === EMPTY || others.some(({ value }) => value === EMPTY) ? null
        : `${control.value}=${others.map(({ value }) => value).join(":")}`),
      write: () => { control.value = EMPTY; },
    };
  },
  flag: () => {
    const control = made("input", { type: "checkbox" });
    return {
      control,
      read: () => control.checked,
      write: (value) => { control.checked = Boolean(value); },
    };
  },
};

// change(value) gives, be it later, the sentence that refuses it, or an empty one.
export function fieldOf(spec, id, change = null) {
  const titled = spec.unit ? `${spec.label} [${spec.unit}]` : spec.label;
  const between = spec.kind === "list" && spec.default?.length === 2;
  const kind = between ? "window" : spec.kind;
  const { control, others = [], read, write } = (CONTROLS[kind] ?? CONTROLS.text)(spec, titled);
  const inputs = [control, ...others];
  control.id = id;
  const help = made("span", { class: "help", id: `${id}-help` }, spec.help ?? EMPTY);
  const why = made("span", { class: "why", id: `${id}-why`, "aria-live": "polite" });
  const row = made("div", { class: `field ${kind}` },
    made("label", { for: id }, titled), made("span", { class: "inputs" }, ...inputs), help, why);
  help.hidden = !spec.help;
  if (spec.optional && ["number", "text", "list"].includes(kind)) control.placeholder = spec.absent ?? "none";
  const refuse = (sentence) => {
    why.textContent = sentence;
    for (const input of inputs) {
      if (sentence) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
    }
  };
  for (const input of inputs) {
    input.setAttribute("aria-describedby", `${id}-help ${id}-why`);
    if (!change) continue;
    input.addEventListener("change", async () => {
      const value = read();
      if (value === null && !spec.optional) refuse(`${spec.label} must be given.`);
      else refuse(await change(value));
    });
  }
  const set = (value) => {
    // What was refused stays as it is typed, with its sentence, until it is changed.
    if (control.hasAttribute("aria-invalid")) return;
    const typing = inputs.includes(document.activeElement) && kind !== "flag";
    if (!typing || JSON.stringify(read()) !== JSON.stringify(value ?? null)) write(value);
  };
  write(spec.default);
  return { row, control, read, set, refuse };
}

export const dig = (element, path) =>
  path.split(".").reduce((value, name) => value?.[name], element);

// A copy with another value at a path of names between dots.
export function withValue(element, path, value) {
  const copy = structuredClone(element);
  const names = path.split(".");
  const last = names.pop();
  let at = copy;
  for (const name of names) {
    if (at[name] === null || typeof at[name] !== "object") at[name] = {};
    at = at[name];
  }
  at[last] = value;
  return copy;
}

// Fields for the options of a verb, all of which may be left out, and what they say.
export const optionFields = (verb, options) => options.map((option) => (
  [option.name, fieldOf({ absent: "as usual", ...option, optional: option.default === null },
    `${verb}-${option.name}`)]));

export function valuesOf(fields) {
  const given = {};
  for (const [name, field] of fields) if (field.read() !== null) given[name] = field.read();
  return given;
}
