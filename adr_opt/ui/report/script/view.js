// The view of the orbits: turned by keys, or behind a chaser that it follows.
const TURN = Math.PI / 18; // by a key
const HIGHEST = 1.5; // of the eye over the equator [rad]
const NEARER = 1.25; // by a key
const BESIDE = 0.9; // how far the eye that follows is to the side of the orbit, for one above it
const NEAR = 2.6; // times as near as the whole
let followed = null; // number of the chaser

const scale = { whole: 0, now: 0 }; // of the scene: size of its box

// From kilometres to the coordinates of the scene's camera.
const inScene = (r) => {
  const [, farthest] = figures.orbits.layout.scene.xaxis.range;
  return scaled(r, scale.now / (2000 * farthest));
};

const vector = ([x, y, z]) => ({ x, y, z });

// The chaser in the middle, flying across the picture, with the Earth below it.
function cameraBeside({ r, v }) {
  const up = scaled(r, 1 / size(r));
  const normal = cross(r, v);
  const side = scaled(normal, 1 / size(normal));
  const toEye = sum(up, scaled(side, BESIDE));
  const at = inScene(r);
  return {
    ...figures.orbits.layout.scene.camera, up: vector(up), center: vector(at),
    eye: vector(sum(at, scaled(toEye, 1.8 / size(toEye)))),
  };
}

const enlarged = (by) => {
  scale.now = by;
  return { "scene.aspectratio": { x: by, y: by, z: by } };
};

// Without WebGL the drawing is moved, and seen from where it was.
function flatBeside({ r }) {
  const [right, up] = flatAxes();
  const [, farthest] = figures.orbits.layout.scene.xaxis.range;
  const [x, y] = [dot(r, right) / 1000, dot(r, up) / 1000];
  const room = farthest / NEAR;
  return { "xaxis.range": [x - room, x + room], "yaxis.range": [y - room, y + room] };
}

// Changes of the layout at the time that is shown.
function viewNow() {
  const state = followed === null ? null : chaserState(motion.chasers[followed], time);
  if (!state) return {};
  return drawsWith() === "" ? flatBeside(state) : { "scene.camera": cameraBeside(state) };
}

function seeFrom(camera) {
  figures.orbits.layout.scene.camera = camera;
  if (drawsWith() === "") return draw("orbits");
  return Plotly.relayout(box("orbits"), { "scene.camera": camera });
}

function turnedBy(east, north) {
  const camera = drawsWith() === "" ? figures.orbits.layout.scene.camera
    : box("orbits")._fullLayout.scene.camera;
  const { x, y, z } = camera.eye;
  const length = Math.hypot(x, y, z);
  const around = Math.atan2(y, x) + east;
  const height = Math.min(HIGHEST, Math.max(-HIGHEST, Math.asin(z / length) + north));
  const level = length * Math.cos(height);
  return seeFrom({
    ...figures.orbits.layout.scene.camera,
    eye: vector([level * Math.cos(around), level * Math.sin(around), length * Math.sin(height)]),
  });
}

function comeNearer(by) {
  if (drawsWith() !== "") return Plotly.relayout(box("orbits"), enlarged(scale.now * by));
  const { xaxis, yaxis } = box("orbits")._fullLayout;
  const nearer = ([low, high]) => [low, high].map((end) => (low + high + (2 * end - low - high) / by) / 2);
  return Plotly.relayout(box("orbits"), {
    "xaxis.range": nearer(xaxis.range), "yaxis.range": nearer(yaxis.range),
  });
}

const keys = {
  ArrowLeft: () => turnedBy(-TURN, 0), ArrowRight: () => turnedBy(TURN, 0),
  ArrowUp: () => turnedBy(0, TURN), ArrowDown: () => turnedBy(0, -TURN),
  "+": () => comeNearer(NEARER), "=": () => comeNearer(NEARER), "-": () => comeNearer(1 / NEARER),
};

async function followChaser(which) {
  followed = which;
  if (!drawn.has("orbits")) return;
  const whole = which === null;
  if (drawsWith() !== "") {
    await Plotly.relayout(box("orbits"), enlarged(whole ? scale.whole : NEAR * scale.whole));
    if (whole) await seeFrom({ ...figures.orbits.layout.scene.camera, center: vector([0, 0, 0]) });
  } else if (whole) {
    await Plotly.relayout(box("orbits"), { "xaxis.autorange": true, "yaxis.autorange": true });
  }
  await Plotly.relayout(box("orbits"), viewNow());
}

function listenToView() {
  if (!motion || !figures.orbits) return;
  const chart = box("orbits");
  chart.tabIndex = 0;
  chart.addEventListener("keydown", (event) => {
    const does = keys[event.key];
    if (event.target !== chart || !does || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (drawn.has("orbits")) does();
  });
  box("view").addEventListener("change", ({ target }) =>
    followChaser(target.value === "" ? null : Number(target.value)));
}

if (motion && figures.orbits) {
  scale.whole = figures.orbits.layout.scene.aspectratio.x;
  scale.now = scale.whole;
}
