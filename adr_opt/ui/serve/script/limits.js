// Limits of the mission: its duration, and a budget for each chaser.
import { box, DAY_S, made, step, text } from "./dom.js";
import { showFrontier } from "./frontier.js";
import { follow, again } from "./store.js";
import { edit } from "./talk.js";

function limit(key, kind, label, unit, first, change) {
  const field = made("input", {
    type: "number", min: "0", step: "any", inputmode: "decimal", id: `limit-${key}`,
  });
  const named = made("label", {}, `${label} [${unit}] `, field);
  const slider = made("input", { type: "range", "aria-label": `${label} [${unit}], slider` });
  const worth = made("span", { class: "worth" });
  const row = made("div", { class: "limit" }, named, slider, worth);
  slider.addEventListener("input", () => {
    field.value = slider.value;
    if (kind) showFrontier(kind, label, Number(slider.value), first);
  });
  for (const input of [slider, field]) {
    input.addEventListener("change", () => {
      if (input.value !== "") change(Number(input.value));
      else again("state");
    });
  }
  const set = (value, told = "") => {
    slider.min = "0";
    slider.step = String(step(2 * first));
    slider.max = String(Math.max(2 * first, value) || 1);
    slider.value = String(value);
    if (document.activeElement !== field || Number(field.value) !== value) {
      field.value = text(value, 10);
    }
    worth.textContent = told;
  };
  return { row, set };
}

let limits = [];
let key = "";

function show(state) {
  if (!state.chasers?.length) return;
  // Chasers come and go by the forms.
  const now = JSON.stringify(state.chasers.map(({ name, unit, first }) => [name, unit, first]));
  if (now !== key) {
    key = now;
    limits = [limit("duration", "duration", "Duration", "d", state.first_duration_s / DAY_S,
      (days) => edit({ duration_s: days * DAY_S }))];
    state.chasers.forEach((chaser, at) => {
      const label = state.chasers.length > 1 ? `Budget of ${chaser.name}` : "Budget";
      const kind = state.chasers.length > 1 ? null : chaser.unit === "kg" ? "propellant" : "delta-v";
      limits.push(limit(`budget-${at}`, kind, label, chaser.unit, chaser.first,
        (amount) => edit({ budget: { chaser: chaser.name, amount } })));
    });
    box("limits").replaceChildren(...limits.map((each) => each.row));
  }
  limits[0].set(state.duration_s / DAY_S);
  state.chasers.forEach((chaser, at) => {
    const told = chaser.unit === "kg" ? `${text(chaser.delta_v_m_s, 5)} m/s without cargo` : "";
    limits[at + 1].set(chaser.amount, told);
  });
}

export function start() {
  follow("state", show);
}
