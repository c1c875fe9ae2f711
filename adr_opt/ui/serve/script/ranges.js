// Fields for the least and greatest value of each column: the keyboard's way of brushing.
import { COLUMNS, extent, known } from "./columns.js";
import { box, made, step, text } from "./dom.js";

// A bound of a column, rounded to what a reader would type.
function rounded(value, range) {
  const each = step(range) / 10;
  return text(Math.round(value / each) * each, 5);
}

export function rangeFields(filters, changed) {
  let rows = {};
  const read = (input) => (input.value === "" ? null : Number(input.value));
  return {
    take(field, same) {
      const before = same ? filters.ranges : {};
      rows = {};
      filters.ranges = {};
      for (const [name, { label, unit }] of Object.entries(COLUMNS)) {
        if (!known(field[name])) continue;
        const said = name === "worth" ? field.unit : unit;
        const titled = said ? `${label} [${said}]` : label;
        const [low, high] = extent(field[name]);
        const inputs = ["from", "to"].map((end, at) => made("input", {
          type: "number", step: "any", inputmode: "decimal", id: `range-${name}-${end}`,
          "aria-label": `${titled}, ${end}`, placeholder: rounded([low, high][at], high - low),
          value: before[name]?.[at],
        }));
        filters.ranges[name] = before[name] ?? [null, null];
        for (const input of inputs) {
          input.addEventListener("input", () => {
            filters.ranges[name] = inputs.map(read);
            changed();
          });
        }
        const between = made("span", { "aria-hidden": "true" }, "to");
        const row = made("div", { class: "range" }, made("span", {}, titled), inputs[0], between, inputs[1]);
        rows[name] = { inputs, row };
      }
      box("ranges").replaceChildren(...Object.values(rows).map(({ row }) => row));
    },
    clear() {
      for (const [name, { inputs }] of Object.entries(rows)) {
        for (const input of inputs) input.value = "";
        filters.ranges[name] = [null, null];
      }
    },
  };
}
