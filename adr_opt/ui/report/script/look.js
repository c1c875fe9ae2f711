// How charts look.
// Canvas and WebGL charts do not read the style sheet, so the colours are handed to them.
const colour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

function axis(given) {
  return {
    gridcolor: colour("line"), linecolor: colour("line-strong"), zeroline: false,
    zerolinecolor: colour("line-strong"),
    automargin: true, ...given,
    title: { ...given.title, standoff: 10, font: { size: 13, color: colour("quiet") } },
  };
}

function layout(name) {
  const given = figures[name].layout;
  const made = {
    ...given,
    autosize: true,
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: {
      family: getComputedStyle(document.body).fontFamily, size: 12, color: colour("text"),
    },
    hoverlabel: {
      bgcolor: colour("card"), bordercolor: colour("line-strong"), align: "left",
      font: { color: colour("text") },
    },
    margin: { l: 8, r: 12, t: 12, b: 8 },
    modebar: {
      bgcolor: "rgba(0,0,0,0)", color: colour("line-strong"), activecolor: colour("accent"),
    },
    showlegend: given.showlegend === true,
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    uirevision: given.uirevision ?? "kept",
  };
  made.dragmode = coarse ? false : "zoom"; // a finger scrolls the page
  made.hovermode = "closest";
  made.xaxis = axis(given.xaxis);
  made.yaxis = axis(given.yaxis);
  if (timed.includes(name)) {
    made.yaxis.fixedrange = name !== "nodes"; // which shows what is near the chaser first
    if (chosen) {
      const [start, end] = windows[chosen - 1];
      const room = 0.05 * (end - start) || 0.01;
      made.xaxis.range = [start - room, end + room];
    }
    made.uirevision = `leg ${chosen}`;
  }
  if (name === "lanes") { // the days stand below the next chart
    made.xaxis.title = {};
    made.height -= 24;
  }
  if (name === "gantt" && narrow.matches) made.yaxis.tickfont = { size: 10 };
  return made;
}
