// What can be asked of an object that was clicked in the report, which says its name.
import { box, DAY_S, put, text } from "./dom.js";
import { follow, told } from "./store.js";
import { edit } from "./talk.js";

let name = null;

const target = () => told.state?.targets.find(([each]) => each === name);

function show() {
  const found = name === null ? null : target();
  if (!found) {
    box("object").close();
    return;
  }
  const [, prize, required, excluded, visited, window_s] = found;
  put("object-name", name);
  put("object-said", `prize ${text(prize)}${visited ? ", visited" : ""}${required ? ", required" : ""}`
    + `${excluded ? ", excluded" : ""}`);
  put("object-required", required ? "Require no more" : "Require");
  put("object-excluded", excluded ? "Include" : "Exclude");
  if (document.activeElement !== box("object-deadline")) {
    const end = window_s?.[1] ?? null;
    box("object-deadline").value = end === null ? "" : text(end / DAY_S, 10);
  }
}

// Keep-out zones are dragged in the report, which is told where they are now.
const framed = () => document.querySelector("#frame iframe")?.contentWindow;
const tellZones = () => framed()?.postMessage({ zones: told.state?.instance?.keep_out_zones ?? [] }, "*");
const moveZones = (moved) => edit(() => ({
  part: {
    path: "keep_out_zones",
    value: told.state.instance.keep_out_zones.map((zone, at) => ({ ...zone, ...moved[at] })),
  },
}));

export function start() {
  addEventListener("message", ({ source, data }) => {
    if (!source || source !== framed()) return;
    if (data?.ready) tellZones();
    if (data?.zones) moveZones(data.zones);
    if (typeof data?.object !== "string") return;
    name = data.object;
    if (!target()) return;
    show();
    box("object").show();
  });
  const change = (changes) => edit({ targets: { names: [name], ...changes } });
  box("object-required").addEventListener("click", () => change({ required: !target()[2] }));
  box("object-excluded").addEventListener("click", () => change({ excluded: !target()[3] }));
  box("object-deadline").addEventListener("change", ({ target: { value } }) => change({
    window_s: [target()[5]?.[0] ?? 0, value === "" ? null : Number(value) * DAY_S],
  }));
  box("object-close").addEventListener("click", () => box("object").close());
  follow("state", () => {
    tellZones();
    if (box("object").open) show();
  });
}
