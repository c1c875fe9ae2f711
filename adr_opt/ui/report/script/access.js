// Charts for the keyboard and for screen readers: each is a group with the name of its section, its
// drawing is silent, and its buttons are one stop, with arrow keys from one to the next.
const titleOf = (chart) => chart.closest("section")?.querySelector("h2, h3")?.textContent ?? chart.id;

function madeReachable(chart) {
  chart.setAttribute("role", "group");
  if (!chart.hasAttribute("aria-label")) {
    const same = chart.closest("section")?.querySelectorAll(".chart").length > 1;
    chart.setAttribute("aria-label", `chart: ${titleOf(chart)}${same ? `, ${chart.id}` : ""}`);
  }
  for (const drawing of chart.querySelectorAll("svg")) drawing.setAttribute("aria-hidden", "true");
  const bar = chart.querySelector(".modebar");
  if (!bar) return;
  bar.setAttribute("aria-label", `tools: ${titleOf(chart)}`);
  const buttons = [...bar.querySelectorAll("button")];
  buttons.forEach((button, at) => { button.tabIndex = at ? -1 : 0; });
}

function listenToTools() {
  document.querySelector("main").addEventListener("keydown", (event) => {
    const bar = event.target.closest?.(".modebar");
    const way = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
    if (!bar || !way) return;
    event.preventDefault();
    const buttons = [...bar.querySelectorAll("button")];
    const at = buttons.indexOf(event.target);
    const next = buttons[(at + way + buttons.length) % buttons.length];
    event.target.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
  // The library measures texts by a drawing of its own, out of sight.
  document.getElementById("js-plotly-tester")?.setAttribute("aria-hidden", "true");
}
