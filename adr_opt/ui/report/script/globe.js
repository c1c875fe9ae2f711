// The globe: the Earth by day and by night, orbits, and the ways of the chasers, past ones bright and
// future ones faint, drawn on a canvas, so that any browser has it, prints it and films it.
const FILLS = 0.94; // of the canvas, by the farthest orbit
const OF_A_LAP = 72; // points
const HALF_TURN = 180 / Math.PI;
const [FAINT, FADED] = [0.16, 0.4]; // ways that are not flown yet, and those of tours before
const RINGS = { station: 0.7, visited: 0.28, "not visited": 0.16 };
const [STILL_PX, MOVING_PX] = [900, 480]; // most pixels across the Earth
const LEVELS = 24; // of daylight
const RIM = 0.04; // beyond the edge of the Earth, which is cut by a circle
const NEAR_PX = 9; // of the pointer

const DAY = [[126, 164, 199], [170, 184, 148], [146, 180, 211], [186, 198, 166]]; // sea, land, mesh
const DARKEST = 0.38; // of these colours, at night
const TWILIGHT = Math.sin(12 * Math.PI / 180); // how far the Sun is below the horizon in the dark

// Points of arcs, at most a revolution of each, once and for all: what moves is the view.
function waysOf(chaser) {
  return chaser.arcs.map((arc) => {
    const span = Math.max(Math.min(arc[END] - arc[BEGIN], lap(arc)), 0);
    const count = Math.max(2, Math.ceil(OF_A_LAP * span / lap(arc)) + 1);
    const points = new Float64Array(3 * count);
    for (let at = 0; at < count; at += 1) {
      points.set(arcState(arc, arc[BEGIN] + span * at / (count - 1)).r, 3 * at);
    }
    return { arc, which: chaser, span, points, colour: chaser.colour ?? motion.phases[arc[PHASE]][1] };
  });
}

// The circle of a body, as if its node were at the equinox: the node drifts.
function ringOf({ kind, row: [radius, inclination, ...node] }) {
  const points = new Float64Array(3 * (OF_A_LAP + 1));
  for (let at = 0; at <= OF_A_LAP; at += 1) {
    const latitude = 2 * Math.PI * at / OF_A_LAP;
    points.set(bodyState({ row: [radius, inclination, 0, 0, latitude, 0] }, 0).r, 3 * at);
  }
  return { points, kind, colour: motion.kinds[kind], node: (then) => node[0] + node[1] * then };
}

const ways = motion && motion.chasers.flatMap(waysOf);
// By leg: the number of the tour that it is of, as a chaser begins another one at a station.
const tours = motion && motion.legs.map((leg, at) => motion.legs.slice(0, at).filter(({ chaser, to }) =>
  chaser === leg.chaser && to !== null && motion.bodies[to].kind === "station").length);
const tourOf = (leg) => `tour ${motion.legs[leg - 1].chaser} ${tours[leg - 1]}`;
const rings = motion && motion.bodies.map(ringOf);
const farthest = motion && ways.reduce((most, { points }) => {
  for (let at = 0; at < points.length; at += 3) {
    most = Math.max(most, Math.hypot(points[at], points[at + 1], points[at + 2]));
  }
  return most;
}, Math.max(motion.radius, ...motion.bodies.map(({ row }) => row[0])));

// Where points are on the canvas: across, up and towards the eye, in pixels.
function lens(width, height) {
  const [right, up, eye] = axes();
  const by = 0.5 * FILLS * Math.min(width, height) / farthest * camera.nearer;
  const middle = camera.centre;
  const at = (x, y, z) => [
    0.5 * width + by * ((x - middle[0]) * right[0] + (y - middle[1]) * right[1] + (z - middle[2]) * right[2]),
    0.5 * height - by * ((x - middle[0]) * up[0] + (y - middle[1]) * up[1] + (z - middle[2]) * up[2]),
    x * eye[0] + y * eye[1] + z * eye[2],
  ];
  const earth = at(0, 0, 0);
  const radius = by * motion.radius;
  // Behind the Earth
  const hides = ([x, y, depth]) => depth < 0 && Math.hypot(x - earth[0], y - earth[1]) < radius;
  return { right, up, eye, at, hides, earth, radius, width, height };
}

// The Earth as a picture: for each pixel the cell of the map, which turns, and how much light it has.
let land = null;
const discs = new Map(); // places of pixels by the width of the picture, for the view they are of

function discOf(across, { right, up, eye, earth, radius, width, height }) {
  // What of the Earth is on the canvas, in radii
  const middle = [(0.5 * width - earth[0]) / radius, (earth[1] - 0.5 * height) / radius];
  const room = [0.5 * width / radius, 0.5 * height / radius].map((half) => half + RIM);
  const key = [...right, ...up, ...middle, ...room].join();
  const known = discs.get(across);
  if (known?.key === key) return known;
  const made = known ?? {
    canvas: new OffscreenCanvas(across, across), rows: new Int32Array(across * across),
    east: new Float32Array(across * across), normals: new Float32Array(3 * across * across),
  };
  made.key = key;
  for (let line = 0, pixel = 0; line < across; line += 1) {
    const v = 1 - 2 * (line + 0.5) / across;
    for (let column = 0; column < across; column += 1, pixel += 1) {
      const u = 2 * (column + 0.5) / across - 1;
      const off = 1 - u * u - v * v;
      made.rows[pixel] = -1;
      if (off < -RIM || Math.abs(u - middle[0]) > room[0] || Math.abs(v - middle[1]) > room[1]) continue;
      const w = Math.sqrt(Math.max(off, 0));
      const x = u * right[0] + v * up[0] + w * eye[0];
      const y = u * right[1] + v * up[1] + w * eye[1];
      const z = u * right[2] + v * up[2] + w * eye[2];
      made.normals.set([x, y, z], 3 * pixel);
      made.rows[pixel] = COLUMNS * Math.min(ROWS - 1, (0.5 - Math.asin(Math.min(1, Math.max(-1, z))) / Math.PI) * ROWS | 0);
      made.east[pixel] = (Math.atan2(y, x) / (2 * Math.PI) + 0.5) * COLUMNS;
    }
  }
  discs.set(across, made);
  return made;
}

// Colours of cells from night to day over twilight, as the pixels of a picture have them.
const shades = new Uint32Array(DAY.flatMap((parts) => Array.from({ length: LEVELS }, (_, level) => {
  const share = DARKEST + (1 - DARKEST) * level / (LEVELS - 1);
  const [r, g, b] = parts.map((part, at) => Math.round(part * share + (at === 2 ? 14 * (1 - share) : 0)));
  return (255 << 24 | b << 16 | g << 8 | r) >>> 0;
})));

function paintEarth(context, seen, moves) {
  land ??= mapped();
  const across = Math.max(64, Math.min(Math.round(2 * seen.radius), moves ? MOVING_PX : STILL_PX));
  const { canvas, rows, east, normals } = discOf(across, seen);
  const drawing = canvas.getContext("2d");
  const picture = drawing.createImageData(across, across);
  const pixels = new Uint32Array(picture.data.buffer);
  const sun = sunDirection(time);
  const [angle, rate] = motion.sidereal;
  const turn = (angle + rate * time) / (2 * Math.PI);
  const shift = COLUMNS * (1 - (turn - Math.floor(turn)));
  for (let pixel = 0; pixel < rows.length; pixel += 1) {
    const row = rows[pixel];
    if (row < 0) continue;
    const cell = land[row + (east[pixel] + shift) % COLUMNS | 0];
    const height = normals[3 * pixel] * sun[0] + normals[3 * pixel + 1] * sun[1] + normals[3 * pixel + 2] * sun[2];
    const share = Math.min(1, Math.max(0, 1 + height / TWILIGHT));
    pixels[pixel] = shades[cell * LEVELS + Math.round(share * (LEVELS - 1))];
  }
  drawing.putImageData(picture, 0, 0);
  const [x, y] = seen.earth;
  const air = context.createRadialGradient(x, y, 0.97 * seen.radius, x, y, 1.06 * seen.radius);
  air.addColorStop(0, "rgba(120, 170, 220, .5)");
  air.addColorStop(1, "rgba(120, 170, 220, 0)");
  context.fillStyle = air;
  context.beginPath();
  context.arc(x, y, 1.06 * seen.radius, 0, 2 * Math.PI);
  context.fill();
  context.save();
  context.beginPath();
  context.arc(x, y, seen.radius, 0, 2 * Math.PI);
  context.clip();
  context.drawImage(canvas, x - seen.radius, y - seen.radius, 2 * seen.radius, 2 * seen.radius);
  context.restore();
}

// A line, turned about the axis, up to a point of it, without what is behind the Earth.
function trace(context, seen, points, count = points.length / 3, turn = 0) {
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  let pen = false;
  for (let at = 0; at < 3 * count; at += 3) {
    const [x, y] = [points[at], points[at + 1]];
    const place = seen.at(c * x - s * y, s * x + c * y, points[at + 2]);
    if (seen.hides(place)) pen = false;
    else if (pen) context.lineTo(place[0], place[1]);
    else {
      context.moveTo(place[0], place[1]);
      pen = true;
    }
  }
}

function stroke(context, colours, width, alpha, draw) {
  context.strokeStyle = colours;
  context.lineWidth = width;
  context.globalAlpha = alpha;
  context.beginPath();
  draw();
  context.stroke();
  context.globalAlpha = 1;
}

// At the beginning all is shown; once time goes on, what lies ahead is faint.
const atBegin = () => time <= reach()[0];

function shownWays() {
  return ways.filter(({ arc }) => !hidden.has(arc[PHASE])
    && (chosen ? arc[LEG] === chosen : !alone || tourOf(arc[LEG]) === alone.tour));
}

const flying = ({ arc }) => !atBegin() && arc[BEGIN] <= time && time < arc[END];

// How bright a way is: none if it is flown, bright before, faint ahead.
function alphaOf({ arc, which }) {
  if (flying({ arc })) return 0;
  if (chosen || atBegin()) return 0.9;
  if (arc[END] > time) return FAINT;
  const now = arcAt(which, time);
  return !now || tours[now.arc[LEG] - 1] === tours[arc[LEG] - 1] ? 0.9 : FADED;
}

// What changes only with the view, and from arc to arc.
const layer = { key: "", canvas: null };

function layered(seen, ratio, moves) {
  const shown = shownWays();
  const key = [...seen.right, ...seen.up, ...seen.earth, seen.radius, ratio, [...hidden].join(), chosen, alone?.tour,
    atBegin(), shown.findLastIndex(({ arc }) => arc[BEGIN] <= time),
    shown.filter(flying).length, rings.length && rings[0].node(time).toFixed(2), dark.matches].join();
  if (layer.key === key && !moves) return layer.canvas;
  layer.key = key;
  layer.canvas = new OffscreenCanvas(Math.round(seen.width * ratio), Math.round(seen.height * ratio));
  const context = layer.canvas.getContext("2d");
  context.scale(ratio, ratio);
  for (const kind of Object.keys(RINGS)) {
    const mine = rings.filter((ring) => ring.kind === kind);
    if (!mine.length || chosen) continue;
    stroke(context, mine[0].colour, kind === "station" ? 2 : 1, RINGS[kind], () => {
      for (const { points, node } of mine) trace(context, seen, points, points.length / 3, node(time));
    });
  }
  context.lineJoin = "round";
  const alphas = shown.map((way) => alphaOf(way));
  for (const alpha of [FAINT, FADED, 0.9]) {
    const mine = shown.filter((_, at) => alphas[at] === alpha);
    for (const shade of new Set(mine.map((way) => way.colour))) {
      stroke(context, shade, chosen ? 3.5 : 1.8, alpha, () => {
        for (const way of mine) if (way.colour === shade) trace(context, seen, way.points);
      });
    }
  }
  return layer.canvas;
}

function paintFlown(context, seen) {
  for (const way of shownWays().filter(flying)) {
    const share = way.span ? Math.min(1, (time - way.arc[BEGIN]) / way.span) : 1;
    stroke(context, way.colour, 1.8, FAINT, () => trace(context, seen, way.points));
    stroke(context, way.colour, chosen ? 4 : 3, 1, () => {
      trace(context, seen, way.points, Math.max(2, Math.round(share * way.points.length / 3)));
    });
  }
}

// Marks where they are on the canvas, without those behind the Earth.
let markedPlaces = [];

function paintMarks(context, seen) {
  markedPlaces = [];
  marks().forEach(({ at, text, colours, sizes, edges }, which) => at.forEach((r, one) => {
    const place = seen.at(...r);
    if (seen.hides(place)) return;
    const [x, y] = place;
    const half = 0.5 * sizes[one];
    markedPlaces.push({ x, y, name: plain(text[one]), body: which ? null : one });
    context.beginPath();
    if (which) {
      context.moveTo(x - half, y);
      context.lineTo(x, y - half);
      context.lineTo(x + half, y);
      context.lineTo(x, y + half);
      context.closePath();
    } else context.arc(x, y, half, 0, 2 * Math.PI);
    context.fillStyle = colours[one];
    context.fill();
    if (!edges[one]) return;
    context.strokeStyle = colour("text");
    context.lineWidth = edges[one];
    context.stroke();
  }));
}

// A text that can be read on anything.
function write(context, text, x, y, align = "left") {
  context.font = `600 12px ${getComputedStyle(document.body).fontFamily}`;
  context.textAlign = align;
  context.lineJoin = "round";
  context.lineWidth = 3.5;
  context.strokeStyle = colour("card");
  context.strokeText(text, x, y);
  context.fillStyle = colour("text");
  context.fillText(text, x, y);
}

// The leg that is flown: where it leads, and what it costs.
function paintNames(context, seen) {
  const leg = atBegin() && !chosen ? 0 : legShown();
  if (!leg) return;
  const { to, cost_m_s: cost } = motion.legs[leg - 1];
  const goal = markedPlaces.find(({ body }) => body !== null && body === to);
  if (!goal) return;
  const left = goal.x > 0.6 * seen.width;
  const [x, align] = left ? [goal.x - 9, "right"] : [goal.x + 9, "left"];
  write(context, goal.name, x, goal.y - 3, align);
  if (cost !== null) write(context, `leg ${leg}, ${cost.toFixed(0)} m/s`, x, goal.y + 11, align);
}

// Draws the moment on a canvas of any size.
function paintGlobe(canvas, width, height, ratio, { moves = false, caption = false } = {}) {
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const context = canvas.getContext("2d");
  context.setTransform(1, 0, 0, 1, 0, 0);
  if (caption) {
    context.fillStyle = colour("card");
    context.fillRect(0, 0, wide, high);
  } else context.clearRect(0, 0, wide, high);
  const seen = lens(width, height);
  context.scale(ratio, ratio);
  paintEarth(context, seen, moves);
  context.drawImage(layered(seen, ratio, moves), 0, 0, width, height);
  paintFlown(context, seen);
  paintMarks(context, seen);
  paintNames(context, seen);
  if (caption) {
    write(context, `${box("now").textContent}   ${box("then").textContent}`, 14, 24);
    write(context, box("doing").textContent, 14, 42);
  }
  return seen;
}

let filming = null;

function showGlobe() {
  const chart = box("orbits");
  const [width, height] = [chart.clientWidth, chart.clientHeight];
  if (!width || !height) return;
  const moves = moveCamera();
  const canvas = chart.querySelector("canvas");
  const options = { moves, caption: filming !== null };
  const seen = paintGlobe(canvas, width, height, Math.min(devicePixelRatio, 2), options);
  // As with charts of the library, what is drawn stands at the element.
  const legs = [...new Set(shownWays().map(({ arc }) => arc[LEG]))];
  Object.assign(chart, { seen, time, marks: markedPlaces, legs });
  if (moves && playing === null) requestAnimationFrame(show);
}

// The nearest thing to a place on the canvas: a mark, or else a leg.
function nearest(x, y) {
  const off = (one) => Math.hypot(one.x - x, one.y - y);
  const mark = markedPlaces.reduce((best, one) => (!best || off(one) < off(best) ? one : best), null);
  if (mark && off(mark) < NEAR_PX) {
    const leg = motion.legs.findIndex(({ to }) => to !== null && to === mark.body) + 1;
    return { said: mark.name, leg, name: mark.body === null ? null : mark.name };
  }
  const chart = box("orbits");
  const seen = lens(chart.clientWidth, chart.clientHeight);
  let [least, found] = [NEAR_PX, null];
  for (const { arc, points } of shownWays()) {
    for (let at = 0; at < points.length; at += 3) {
      const place = seen.at(points[at], points[at + 1], points[at + 2]);
      const away = Math.hypot(place[0] - x, place[1] - y);
      if (away < least && !seen.hides(place)) [least, found] = [away, arc];
    }
  }
  return found && {
    leg: found[LEG], said: `${plain(titles[found[LEG]])}, ${motion.phases[found[PHASE]][0]}`,
  };
}

async function globePicture(width, height) {
  const canvas = new OffscreenCanvas(1, 1);
  paintGlobe(canvas, width, height, SLIDE.scale, { caption: true });
  return new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
}

// The mission as a film: played from its begin, as fast as is chosen.
function film() {
  const button = box("film");
  if (filming) {
    pausePlay();
    return;
  }
  const stream = box("orbits").querySelector("canvas").captureStream();
  const parts = [];
  filming = new MediaRecorder(stream, { mimeType: "video/webm" });
  filming.addEventListener("dataavailable", ({ data }) => parts.push(data));
  filming.addEventListener("stop", () => {
    filming = null;
    button.textContent = "Film";
    offer(new Blob(parts, { type: "video/webm" }), "video/webm", "film.webm");
    show();
  });
  button.textContent = "Stop filming";
  setTime(reach()[0]);
  filming.start();
  play();
  stops.push(() => filming.stop());
}

if (motion && box("orbits")) {
  derived.add("orbits");
  drawn.add("orbits");
  views.push({ chart: "orbits", show: showGlobe });
}
