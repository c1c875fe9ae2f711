// What the page knows and what the reader has chosen.
const mission = JSON.parse(document.getElementById("mission").textContent);
const { figures, titles, windows } = mission;
const timed = ["lanes", "altitude", "budget", "mass", "nodes", "gantt"].filter((name) => name in figures);
// The first share their time axis.
const quick = [...timed, "costs", "planes"].filter((name) => name in figures);
const box = (name) => document.getElementById(name);
const narrow = matchMedia("(max-width: 640px)");
const dark = matchMedia("(prefers-color-scheme: dark)");
const coarse = matchMedia("(pointer: coarse)").matches;
const hidden = new Set(); // phases switched off
let chosen = 0; // leg shown; 0 is the whole mission
let alone = null; // tour that the globe shows without the others: its name and when it is flown [s]
const drawn = new Set();
const derived = new Set(["ground", "closeup", "across"]); // by the script, for a time
const config = {
  displaylogo: false,
  displayModeBar: coarse ? false : "hover",
  responsive: true,
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "resetCameraLastSave3d"],
};

for (const figure of Object.values(figures)) {
  for (const trace of figure.data) {
    const { titled, names, each } = trace.meta ?? {};
    if (titled) trace.text = trace.customdata.map((leg) => titles[leg]);
    if (names) trace.text = names.flatMap((name) => new Array(each).fill(name));
  }
}
