// The view of the globe: turned by pointers and keys, behind a chaser, or from leg to leg.
const TURN = Math.PI / 18; // by a key
const HIGHEST = 1.5; // of the eye over the equator [rad]
const NEARER = 1.25; // by a key
const NEAR = 2.6; // times as near as the whole, behind a chaser
const ASIDE = 55 / HALF_TURN; // of the eye from the normal of an orbit
const SETTLES_MS = 500; // in which the way to another view is halved
const camera = { eye: [1, 0, 0], up: [0, 0, 1], centre: [0, 0, 0], nearer: 1, follows: "", last: 0 };

const unit = (a) => scaled(a, 1 / size(a));

// To the right, up, and towards the eye.
function axes() {
  const eye = unit(camera.eye);
  const right = unit(cross(camera.up, eye));
  return [right, cross(eye, right), eye];
}

// At an angle to the normal of an orbit, over a place of it.
const over = (state, place) =>
  sum(scaled(unit(cross(state.r, state.v)), Math.cos(ASIDE)), scaled(unit(place), Math.sin(ASIDE)));

function whole() {
  const first = motion.chasers.find(({ arcs }) => arcs.length);
  if (!first) return;
  const state = arcState(first.arcs[0], first.arcs[0][BEGIN]);
  const normal = cross(state.r, state.v);
  const node = cross([0, 0, 1], normal);
  const place = size(node) > 0 ? node : state.r;
  // Of the four sides that show the orbit so, the one that has most daylight.
  const sides = [1, -1].flatMap((way) => [1, -1].map((half) =>
    over({ r: scaled(state.r, way), v: state.v }, scaled(place, half))));
  const sun = sunDirection(reach()[0]);
  camera.eye = sum(sides.reduce((best, one) => (dot(one, sun) > dot(best, sun) ? one : best)), [0, 0, 0.25]);
  Object.assign(camera, { up: [0, 0, 1], centre: [0, 0, 0], nearer: 1 });
}

// Turns the eye to where it is wanted, smoothly while time is played; says whether it is on its way.
function turnTo(wanted) {
  const now = performance.now();
  const share = quiet.matches ? 1 : 1 - 2 ** (-Math.min(now - camera.last, 100) / SETTLES_MS);
  camera.last = now;
  const eye = unit(camera.eye);
  const off = Math.acos(Math.min(1, Math.max(-1, dot(eye, unit(wanted)))));
  camera.eye = off < 1e-3 ? unit(wanted) : sum(scaled(eye, 1 - share), scaled(unit(wanted), share));
  return off >= 1e-3;
}

// Moves the camera with what it follows; says whether it is on its way.
function moveCamera() {
  if (camera.follows === "") return false;
  if (camera.follows === "legs") {
    const leg = legShown();
    const { chaser, docked } = motion.legs[Math.max(leg, 1) - 1];
    const state = chaserState(motion.chasers[chaser], docked);
    return state ? turnTo(over(state, state.r)) : false;
  }
  const state = chaserState(motion.chasers[Number(camera.follows)], time);
  if (!state) return false;
  // The chaser in the middle, flying across the picture, with the Earth below it.
  const up = unit(state.r);
  const side = unit(cross(state.r, state.v));
  Object.assign(camera, { up, eye: sum(scaled(up, 0.75), side), centre: state.r, nearer: NEAR });
  return playing !== null;
}

function turnedBy(east, north) {
  const [x, y, z] = unit(camera.eye);
  const around = Math.atan2(y, x) + east;
  const height = Math.min(HIGHEST, Math.max(-HIGHEST, Math.asin(z) + north));
  camera.eye = [Math.cos(height) * Math.cos(around), Math.cos(height) * Math.sin(around), Math.sin(height)];
  return show();
}

function comeNearer(by) {
  camera.nearer = Math.min(40, Math.max(0.5, camera.nearer * by));
  return show();
}

const keys = {
  ArrowLeft: () => turnedBy(-TURN, 0), ArrowRight: () => turnedBy(TURN, 0),
  ArrowUp: () => turnedBy(0, TURN), ArrowDown: () => turnedBy(0, -TURN),
  "+": () => comeNearer(NEARER), "=": () => comeNearer(NEARER), "-": () => comeNearer(1 / NEARER),
};

// Tours can be shown alone where a chaser flies more than one.
function offerTours() {
  const said = ({ chaser }, at) =>
    `tour ${tours[at] + 1}${motion.chasers.length > 1 ? ` of ${plain(motion.chasers[chaser].name)}` : ""}`;
  const named = new Map(motion.legs.map((leg, at) => [tourOf(at + 1), said(leg, at)]));
  if (Math.max(...tours) > 0) box("view").append(...[...named].map(([tour, name]) => new Option(name, tour)));
}

function listenToView() {
  const chart = box("orbits");
  if (!chart) return;
  offerTours();
  const tip = chart.querySelector(".tip");
  const pointers = new Map();
  let moved = 0;
  const placed = ({ clientX, clientY }) => {
    const { left, top } = chart.getBoundingClientRect();
    return [clientX - left, clientY - top];
  };
  chart.addEventListener("pointerdown", (event) => {
    pointers.set(event.pointerId, placed(event));
    moved = 0;
  });
  chart.addEventListener("pointermove", (event) => {
    const [before, now] = [pointers.get(event.pointerId), placed(event)];
    if (!before) {
      const found = nearest(...now);
      tip.hidden = !found;
      if (!found) return;
      tip.textContent = found.said;
      tip.style.transform = `translate(${now[0] + 12}px, ${now[1] + 12}px)`;
      return;
    }
    const others = [...pointers].filter(([id]) => id !== event.pointerId);
    pointers.set(event.pointerId, now);
    const [across, up] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(across, up);
    if (moved < 4) return;
    chart.setPointerCapture(event.pointerId);
    if (others.length) {
      const away = ([x, y]) => Math.hypot(x - others[0][1][0], y - others[0][1][1]);
      comeNearer(away(now) / Math.max(away(before), 1));
    } else turnedBy(-across / 150, up / 150);
  });
  for (const kind of ["pointerup", "pointercancel", "pointerleave"]) {
    chart.addEventListener(kind, (event) => {
      pointers.delete(event.pointerId);
      if (kind === "pointerleave") tip.hidden = true;
    });
  }
  chart.addEventListener("click", (event) => {
    const found = moved < 4 && nearest(...placed(event));
    if (!found) return;
    if (found.leg) choose(found.leg === chosen ? 0 : found.leg);
    if (found.name) told(found.name);
  });
  chart.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== chart) return;
    event.preventDefault();
    comeNearer(1.0015 ** -event.deltaY);
  }, { passive: false });
  chart.addEventListener("keydown", (event) => {
    const does = keys[event.key];
    if (event.target !== chart || !does || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    does();
  });
  box("view").addEventListener("change", ({ target }) => {
    const flown = windows.filter((_, at) => tourOf(at + 1) === target.value);
    const span = [flown[0]?.[0], flown.at(-1)?.[1]].map((days) => days * DAY_S);
    alone = flown.length ? { tour: target.value, span } : null;
    camera.follows = alone ? "" : target.value;
    if (camera.follows === "" || camera.follows === "legs") whole();
    fitSlider();
    setTime(alone ? span[0] : time);
  });
  new ResizeObserver(() => show()).observe(chart);
  const button = box("film");
  button.hidden = typeof MediaRecorder === "undefined" || !MediaRecorder.isTypeSupported("video/webm");
  button.addEventListener("click", film);
}

if (motion && box("orbits")) {
  whole();
  const chart = box("orbits");
  chart.tabIndex = 0;
}
