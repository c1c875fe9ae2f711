// The mission that is made of chosen objects: its options, why one is refused, and what became of them.
import { box, counted, put } from "./dom.js";
import { optionFields, valuesOf } from "./field.js";
import { follow } from "./store.js";
import { post } from "./talk.js";

let fields = [];
let labels = [];

function build({ import: options = [] }) {
  fields = optionFields("import", options);
  box("import-options").replaceChildren(...fields.map(([, field]) => field.row));
  for (const [, field] of fields) field.control.addEventListener("change", () => field.refuse(""));
  labels = options.map(({ label }) => label);
}

// A sentence stands at the field that it begins with, and the form is open then.
function refuse(sentence) {
  put("choose-refused", sentence);
  fields.forEach(([, field], at) => {
    const mine = ["”", " ["].some((end) => sentence.startsWith(`“${labels[at]}${end}`));
    field.refuse(mine ? sentence : "");
    if (mine) {
      box("import-options").closest("details").open = true;
      field.control.focus();
    }
  });
}

export async function chooseThese(names) {
  const { content, refused } = await post("/choose", {
    names, prizes: box("prizes").value, options: valuesOf(fields),
  });
  refuse(refused);
  put("chosen", ""); // what an earlier choice made
  if (refused) return;
  const left = Object.entries(content.left_out).map(([why, count]) => `${why} ${count}`).join(", ");
  put("chosen", [
    `${counted(content.targets, "target")} chosen${left ? `; left out: ${left}` : ""}.`,
    ...content.warnings.map((warning) => `${warning.charAt(0).toUpperCase()}${warning.slice(1)}.`),
  ].join(" "));
}

export function start() {
  follow("choices", build);
}
