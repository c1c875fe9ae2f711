// The leg in close-up: the chaser as its target sees it.
const LONGEST_S = 2 * DAY_S; // of a transfer; what is drawn of a drift is its end
const MOST_POINTS = 1200;
let part = "transfer"; // or "approach"

const wordsOf = { along: "along-track", radial: "radial", cross: "cross-track" };

function span(leg) {
  const { leaves, standoff, docked } = motion.legs[leg - 1];
  if (part === "approach" && standoff !== null) return [standoff, docked];
  return [Math.max(leaves, docked - LONGEST_S), docked];
}

// What the target sees over a leg, phase by phase. The way along the track is continuous, so that
// laps behind are laps behind, and it ends near the target.
function approached(leg) {
  const { chaser, to } = motion.legs[leg - 1];
  const target = motion.bodies[to];
  const [start, end] = span(leg);
  const found = [];
  const arcs = motion.chasers[chaser].arcs.filter((arc) =>
    arc[LEG] === leg && arc[END] > start && arc[BEGIN] < end);
  for (const arc of arcs) {
    const [from, until] = [Math.max(start, arc[BEGIN]), Math.min(end, arc[END])];
    const steps = Math.max(32, Math.round(MOST_POINTS * (until - from) / (end - start)));
    const points = [];
    for (let at = 0; at <= steps; at += 1) {
      const then = from + (until - from) * at / steps;
      points.push({ then, ...seenFrom(bodyState(target, then), arcState(arc, then).r) });
    }
    found.push({ phase: arc[PHASE], points });
  }
  const around = 2 * Math.PI * target.row[0];
  let laps = 0;
  let after = null;
  for (const { points } of [...found].reverse()) {
    for (let at = points.length - 1; at >= 0; at -= 1) {
      const raw = points[at].along;
      if (after !== null) laps += Math.round((after - raw) / around);
      after = raw;
      points[at].along = raw + laps * around;
    }
  }
  return found;
}

let kept = { key: "", phases: [] }; // of the leg that was drawn last

function closeup() {
  const leg = legShown();
  const known = leg && motion.legs[leg - 1].to !== null && !motion.legs[leg - 1].launch;
  const key = known ? `${leg} ${part}` : "";
  if (key !== kept.key) {
    kept = { key, phases: known ? approached(leg) : [] };
    const title = leg && box("leg").options[leg].textContent;
    const who = leg && motion.chasers[motion.legs[leg - 1].chaser];
    box("closeup-leg").textContent = leg
      ? `${who.colour ? `${plain(who.name)}, ` : ""}leg ${title}` +
        (known ? "" : ": there is no way to show")
      : "No leg is flown at this time.";
  }
  const ends = kept.phases.flatMap(({ points }) => [points[0].then, points.at(-1).then]);
  const [start, end] = [Math.min(...ends), Math.max(...ends)];
  let here = null;
  if (known && time >= start && time <= end) {
    const { chaser, to } = motion.legs[leg - 1];
    const state = chaserState(motion.chasers[chaser], time);
    here = seenFrom(bodyState(motion.bodies[to], time), state.r);
    const near = kept.phases.flatMap(({ points }) => points)
      .reduce((best, point) =>
        (Math.abs(point.then - time) < Math.abs(best.then - time) ? point : best));
    const around = 2 * Math.PI * motion.bodies[to].row[0];
    here.along += around * Math.round((near.along - here.along) / around);
    here.phase = state.phase;
  }
  return { key, phases: kept.phases, here };
}

const pictures = { closeup: ["along", "radial"], across: ["along", "cross"] };

// What is left of rounding is not drawn.
const tidy = (value) => Math.round(1000 * value) / 1000;

function seenTraces([across, up], { phases, here }) {
  const unit = part === "approach" ? 1 : 1000;
  const lines = phases.map(({ phase, points }) => ({
    type: "scatter", mode: "lines", name: motion.phases[phase][0], meta: { phase },
    x: points.map((point) => tidy(point[across] / unit)),
    y: points.map((point) => tidy(point[up] / unit)),
    text: points.map(({ then }) => clock(then)),
    hovertemplate: `${motion.phases[phase][0]}, %{text}<br>${wordsOf[across]} %{x:.1f}, ` +
      `${wordsOf[up]} %{y:.1f}<extra></extra>`,
    line: { color: motion.phases[phase][1], width: 2 },
  }));
  const spot = (x, y, name, marker) => ({
    type: "scatter", mode: "markers", name, x: [x], y: [y], marker, cliponaxis: false,
    hovertemplate: `${name}<extra></extra>`,
  });
  if (lines.length && part === "approach" && motion.keepOut) {
    const turns = [...Array(65).keys()].map((at) => at * Math.PI / 32);
    lines.unshift({
      type: "scatter", mode: "lines", name: "kept out of", fill: "toself",
      x: turns.map((turn) => tidy(motion.keepOut * Math.cos(turn))),
      y: turns.map((turn) => tidy(motion.keepOut * Math.sin(turn))),
      line: { color: colour("text"), width: 1, dash: "dot" },
      hovertemplate: `kept out of, ${motion.keepOut} m<extra></extra>`,
    });
  }
  const shown = lines.length
    ? [...lines, spot(0, 0, "target", { symbol: "cross", size: 11, color: colour("text") })]
    : [];
  if (here) {
    shown.push(spot(tidy(here[across] / unit), tidy(here[up] / unit), "chaser", {
      symbol: "diamond", size: 12, color: here.phase ? motion.phases[here.phase][1] : colour("text"),
      line: { width: 1.5, color: colour("text") },
    }));
  }
  return shown;
}

async function moveInCloseup() {
  const found = closeup();
  const unit = part === "approach" ? "m" : "km";
  for (const [name, axes] of Object.entries(pictures)) {
    figures[name] = {
      data: seenTraces(axes, found),
      layout: {
        xaxis: { title: { text: `${wordsOf[axes[0]]} [${unit}]` }, zeroline: true },
        yaxis: { title: { text: `${wordsOf[axes[1]]} [${unit}]` }, zeroline: true },
        uirevision: found.key,
      },
    };
    await draw(name);
  }
}

function listenToCloseup() {
  for (const button of document.querySelectorAll("button[data-part]")) {
    button.addEventListener("click", () => {
      part = button.dataset.part;
      for (const other of document.querySelectorAll("button[data-part]")) {
        other.setAttribute("aria-pressed", String(other === button));
      }
      const leg = legShown();
      const [start, end] = leg ? span(leg) : [time, time];
      if (time < start || time > end) setTime(start);
      else show();
    });
  }
}

if (motion && box("closeup")) views.push({ chart: "closeup", show: moveInCloseup });
