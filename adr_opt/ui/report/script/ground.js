// The way over the ground: where the chasers are above the turning Earth, a revolution before the
// time that is shown and one after it.
const STEPS = 120; // of a revolution

function lap(arc) {
  if (motion.spirals) return 2 * Math.PI * motion.mu / arc[SPEED] ** 3;
  const v = arc.slice(STATE + 3, STATE + 6);
  const axis = 1 / (2 / size(arc.slice(STATE, STATE + 3)) - dot(v, v) / motion.mu);
  return 2 * Math.PI * Math.sqrt(axis ** 3 / motion.mu) / arc[PACE];
}

// Points of a way; a gap where it leaves the map on one side and comes in on the other, and where it
// is not wanted.
function way(chaser, from, until, wanted = () => true) {
  const x = [];
  const y = [];
  for (let at = 0; at <= STEPS; at += 1) {
    const then = from + (until - from) * at / STEPS;
    const state = chaserState(chaser, then);
    if (!state) continue;
    if (!wanted(state, then)) {
      if (x.length && x.at(-1) !== null) {
        x.push(null);
        y.push(null);
      }
      continue;
    }
    const { latitude, longitude } = above(state.r, then);
    if (x.length && x.at(-1) !== null && Math.abs(longitude - x.at(-1)) > 180) {
      const past = x.at(-1);
      const edge = past > 0 ? 180 : -180;
      const ahead = longitude + 2 * edge;
      const part = (edge - past) / (ahead - past || 1);
      const crossing = y.at(-1) + part * (latitude - y.at(-1));
      x.push(edge, null, -edge);
      y.push(crossing, null, crossing);
    }
    x.push(longitude);
    y.push(latitude);
  }
  return { x, y };
}

function groundTraces() {
  const { x: east, y: north, sun } = night(time);
  const made = [{
    type: "scatter", mode: "lines", name: "night", x: east, y: north, fill: "toself",
    fillcolor: colour("night"), hoverinfo: "skip", line: { width: 0 },
  }, {
    type: "scatter", mode: "lines", name: "coastlines", x: coast.longitude, y: coast.latitude,
    hoverinfo: "skip", line: { color: colour("line-strong"), width: 1 },
  }, {
    type: "scatter", mode: "markers", name: "Sun", x: [sun.longitude], y: [sun.latitude],
    hovertemplate: "the Sun is overhead<extra></extra>",
    marker: {
      symbol: "star-diamond", size: 13, color: "#e0a010",
      line: { width: 1, color: colour("text") },
    },
  }];
  const chasers = present();
  for (const which of chasers) {
    const { chaser, arc } = which;
    const round = lap(arc);
    const shade = chaser.colour ?? colour("accent");
    if (motion.spirals) {
      made.push({
        type: "scatter", mode: "lines", name: `${chaser.name}, thrust on`, hoverinfo: "skip",
        ...way(chaser, Math.max(time - round, chaser.arcs[0][BEGIN]), time + round, thrusts),
        opacity: 0.5, line: { color: shade, width: 7 },
      });
    }
    for (const [since, until, opacity, title] of [
      [time - round, time, 0.9, "the revolution before"], [time, time + round, 0.4, "the next one"],
    ]) {
      made.push({
        type: "scatter", mode: "lines", name: `${chaser.name}, ${title}`,
        ...way(chaser, Math.max(since, chaser.arcs[0][BEGIN]), until),
        hoverinfo: "skip", opacity,
        line: { color: shade, width: 2, dash: until > time ? "dot" : "solid" },
      });
    }
  }
  const places = marks();
  places.forEach(({ at, text, colours, sizes, edges }, which) => {
    const found = at.map((r) => above(r, time));
    made.push({
      type: "scatter", mode: "markers", name: ["bodies", "chasers"][which],
      x: found.map(({ longitude }) => longitude), y: found.map(({ latitude }) => latitude),
      text, customdata: found.map(({ altitude }) => altitude / 1000),
      hovertemplate: "%{text}<br>%{y:.1f}°, %{x:.1f}°, %{customdata:.0f} km<extra></extra>",
      marker: {
        color: colours, size: sizes,
        symbol: which ? "diamond" : "circle",
        opacity: 1, line: { width: edges, color: colour("text") },
      },
    });
  });
  return made;
}

const degrees = (every, most, [plus, minus]) => {
  const tickvals = [];
  for (let at = -most; at <= most; at += every) tickvals.push(at);
  const ticktext = tickvals.map((at) =>
    `${Math.abs(at)}°${at > 0 && at < 180 ? plus : at < 0 && at > -180 ? minus : ""}`);
  return { tickvals, ticktext, range: [-most, most], fixedrange: false };
};

function moveOverGround() {
  const wide = narrow.matches ? 60 : 30;
  figures.ground = {
    data: groundTraces(),
    layout: {
      xaxis: { ...degrees(wide, 180, ["E", "W"]), showgrid: true },
      yaxis: { ...degrees(30, 90, ["N", "S"]), showgrid: true },
    },
  };
  return draw("ground");
}

if (motion) views.push({ chart: "ground", show: moveOverGround });
