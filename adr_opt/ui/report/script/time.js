// The time that is shown: the slider, the readings beside it, and what plays it.
const DAY_S = 86400;
let time = 0; // seconds since the epoch
let playing = null; // what asks for the next picture
const quiet = matchMedia("(prefers-reduced-motion: reduce)");
const QUIET_MS = 1000; // between two pictures for who wants little motion
const views = []; // what moves: { chart, show }, show may give a promise
const seen = new Set(); // charts near the window
const stops = []; // what else ends when time is no longer played

const pad = (value) => String(value).padStart(2, "0");

function clock(seconds, fine = false) {
  if (fine) {
    const whole = Math.floor(seconds);
    return `${clock(60 * Math.floor(whole / 60))}:${pad(whole % 60)}`;
  }
  const minutes = Math.round(seconds / 60);
  const hours = Math.floor(minutes / 60);
  return `${Math.floor(hours / 24)}\u202fd ${pad(hours % 24)}:${pad(minutes % 60)}`;
}

function calendar(seconds) {
  const date = new Date(mission.epoch_ms + 60000 * Math.round(seconds / 60));
  if (Number.isNaN(date.getTime())) return "beyond the calendar";
  return `${date.toISOString().slice(0, 16).replace("T", " ")} UTC`;
}

const legsAt = (seconds) =>
  windows.flatMap(([start, end], at) =>
    (start * DAY_S <= seconds && seconds < end * DAY_S ? [at + 1] : []));

// The chosen leg, or the first of those that are flown.
const legShown = () => chosen || legsAt(time)[0] || 0;

const reach = () =>
  (chosen ? windows[chosen - 1].map((days) => days * DAY_S) : alone?.span ?? [0, mission.end_s]);

// A leg as the list of legs has it; on a phone without its origin.
function called(leg) {
  const text = box("leg").options[leg].textContent;
  return narrow.matches ? `${leg} ${text.slice(text.lastIndexOf("→"))}` : text;
}

function readings() {
  const said = legsAt(time).map(called).join("; ");
  box("now").textContent = clock(time, Number(box("speed").value) < 60);
  box("then").textContent = calendar(time);
  box("doing").textContent = said;
  // While time is played the slider would speak at every picture.
  if (playing === null) {
    box("time").setAttribute("aria-valuetext", `${clock(time)}, ${said || "no leg"}`);
  }
  speakLater();
}

// Charts of times have a line at the time, laid over them: to draw them again would be slow.
function line(name) {
  const chart = box(name);
  let mark = chart.querySelector(":scope > .now");
  if (!mark) {
    mark = document.createElement("div");
    mark.className = "now";
    chart.append(mark);
  }
  const { xaxis, yaxis } = chart._fullLayout ?? {};
  if (!xaxis) return;
  const at = xaxis.d2p(time / DAY_S);
  mark.hidden = !(at >= 0 && at <= xaxis._length);
  mark.style.transform = `translate(${xaxis._offset + at}px, ${yaxis._offset}px)`;
  mark.style.height = `${yaxis._length}px`;
}

// One picture at a time; what was asked for meanwhile comes next. A chart that takes long is drawn
// less often, so that the page answers.
let busy = false;
let again = false;
async function show() {
  if (busy) {
    again = true;
    return;
  }
  busy = true;
  try {
    do {
      again = false;
      await showOnce();
    } while (again);
  } finally {
    busy = false;
  }
}

async function showOnce() {
  readings();
  for (const name of timed) line(name);
  for (const view of views) {
    if (view.chart && !(drawn.has(view.chart) && seen.has(view.chart))) continue;
    const began = performance.now();
    if (playing !== null && began < (view.rests ?? 0)) continue;
    await view.show();
    const ended = performance.now();
    view.rests = ended + 1.5 * Math.max(0, ended - began - 20);
  }
}

function setTime(seconds) {
  const [start, end] = reach();
  time = Math.min(end, Math.max(start, seconds));
  box("time").value = String(time);
  return show();
}

// A thousandth of what the slider runs over, rounded up to what people count in. Until the reader
// chooses a speed it is the slowest one that plays that in time.
const LONGEST_PLAY_S = 1200;
let paced = false;

function fitSlider() {
  const [start, end] = reach();
  const speeds = [...box("speed").options].map(({ value }) => value);
  const enough = speeds.find((speed) => end - start <= LONGEST_PLAY_S * Number(speed));
  if (!paced) box("speed").value = enough ?? speeds.at(-1);
  const steps = [1, 10, 60, 300, 600, 1800, 3600, 7200, 21600, 43200, 86400];
  const slider = box("time");
  slider.min = String(start);
  slider.max = String(end);
  slider.step = String(steps.find((step) => step >= (end - start) / 1000) ?? 86400);
}

function pausePlay() {
  cancelAnimationFrame(playing);
  clearTimeout(playing);
  playing = null;
  for (const end of stops.splice(0)) end();
  const button = box("play");
  button.textContent = "▶";
  button.setAttribute("aria-label", "play");
  return show();
}

function play() {
  const button = box("play");
  button.textContent = "❚❚";
  button.setAttribute("aria-label", "pause");
  if (time >= reach()[1]) setTime(reach()[0]);
  let before = performance.now();
  const next = () => {
    if (quiet.matches) playing = setTimeout(() => step(performance.now()), QUIET_MS);
    else playing = requestAnimationFrame(step);
  };
  function step(at) {
    const passed = Math.max(0, Math.min(at - before, QUIET_MS)) / 1000;
    before = at;
    setTime(time + passed * Number(box("speed").value));
    if (time >= reach()[1]) pausePlay();
    else next();
  }
  next();
}

// The next of the speeds, or the one before it.
function playFaster(by) {
  const list = box("speed");
  list.selectedIndex = Math.min(list.length - 1, Math.max(0, list.selectedIndex + by));
  list.dispatchEvent(new Event("change"));
  box("spoken").textContent = `speed ${list.selectedOptions[0].textContent}`;
}

function listenToTime() {
  const slider = box("time");
  slider.addEventListener("input", () => {
    if (playing !== null) pausePlay();
    setTime(Number(slider.value));
  });
  slider.addEventListener("keydown", (event) => {
    const faster = { "+": 1, "=": 1, "-": -1 }[event.key];
    if (event.key === " ") box("play").click();
    else if (faster && !event.ctrlKey && !event.metaKey) playFaster(faster);
    else return;
    event.preventDefault();
  });
  box("speed").addEventListener("change", () => { paced = true; readings(); });
  box("play").addEventListener("click", () => (playing === null ? play() : pausePlay()));
  document.addEventListener("visibilitychange", () => {
    if (document.hidden && playing !== null) pausePlay();
  });
  for (const name of timed) {
    box(name).on("plotly_afterplot", () => line(name));
  }
  for (const name of ["altitude", "budget", "mass", "nodes"].filter((name) => name in figures)) {
    box(name).on("plotly_click", (event) => setTime(event.points[0].x * DAY_S));
  }
  const near = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) seen.add(target.id);
      else seen.delete(target.id);
    }
    show();
  }, { rootMargin: "100px" });
  for (const { chart } of views) if (chart) near.observe(box(chart));
}
