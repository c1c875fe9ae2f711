// Where chasers and bodies are at a time, in metres and the frame of the elements, from the orbits
// that the page holds: the closed form that the plan was made with.
const { motion } = mission;
const [LEG, PHASE, BEGIN, END, STATE, PACE, NODE_RATE] = [0, 1, 2, 3, 4, 10, 11]; // of an arc

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const size = (a) => Math.hypot(...a);
const scaled = (a, by) => a.map((value) => value * by);
const sum = (a, b) => a.map((value, at) => value + b[at]);

// About the axis of the Earth.
function turned([x, y, z], angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c * x - s * y, s * x + c * y, z];
}

// On a circle whose node and argument of latitude advance evenly.
function bodyState(body, time) {
  const [radius, inclination, node, nodeRate, latitude, latitudeRate] = body.row;
  const u = latitude + latitudeRate * time;
  const omega = node + nodeRate * time;
  const [c, s] = [Math.cos(inclination), Math.sin(inclination)];
  const ascending = [Math.cos(omega), Math.sin(omega), 0];
  const ahead = [-Math.sin(omega) * c, Math.cos(omega) * c, s];
  const speed = Math.sqrt(motion.mu / radius);
  return {
    r: sum(scaled(ascending, radius * Math.cos(u)), scaled(ahead, radius * Math.sin(u))),
    v: sum(scaled(ascending, -speed * Math.sin(u)), scaled(ahead, speed * Math.cos(u))),
  };
}

// Kepler's equation in the difference x of eccentric anomalies: x - c sin x + s (1 - cos x) = mean.
// The left side grows with x, so Newton's step is kept between bounds that close in.
function anomaly(mean, c, s) {
  const reach = 2 * Math.hypot(c, s) + 1e-12;
  let [low, high] = [mean - reach, mean + reach];
  let x = Math.min(high, Math.max(low, mean + c * Math.sin(mean) - s * (1 - Math.cos(mean))));
  for (let round = 0; round < 60; round += 1) {
    const excess = x - c * Math.sin(x) + s * (1 - Math.cos(x)) - mean;
    if (excess < 0) low = x;
    else high = x;
    let next = x - excess / (1 - c * Math.cos(x) + s * Math.sin(x));
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const done = Math.abs(next - x) <= 1e-14 * (1 + Math.abs(x));
    x = next;
    if (done) break;
  }
  return x;
}

// Of a chaser with low thrust: a circle whose speed, inclination and node change evenly. Argument of
// latitude: the integral of v³/μ, and a rate in addition.
const [SPEED, TILT, SPIRAL_NODE, LATITUDE, MIDDLE] = [4, 6, 8, 10, 12]; // each before its rate
function spiralState(arc, time) {
  const since = time - arc[BEGIN];
  const now = (at) => arc[at] + arc[at + 1] * since;
  const [first, speed] = [arc[SPEED], now(SPEED)];
  const cubes = speed ** 3 + speed ** 2 * first + speed * first ** 2 + first ** 3;
  const row = [motion.mu / speed ** 2, now(TILT), now(SPIRAL_NODE), 0,
    now(LATITUDE) + since * cubes / (4 * motion.mu), 0];
  return { ...bodyState({ row }, 0), latitude: row[4] };
}

// On the orbit of an arc, run through at its pace, in a plane that turns with the node.
function arcState(arc, time) {
  if (motion.spirals) return spiralState(arc, time);
  const r = arc.slice(STATE, STATE + 3);
  const v = arc.slice(STATE + 3, STATE + 6);
  const since = time - arc[BEGIN];
  const radius = size(r);
  const axis = 1 / (2 / radius - dot(v, v) / motion.mu);
  const root = Math.sqrt(motion.mu * axis);
  const [c, s] = [1 - radius / axis, dot(r, v) / root];
  const whole = root / (axis * axis) * arc[PACE] * since;
  const x = anomaly(whole - 2 * Math.PI * Math.round(whole / (2 * Math.PI)), c, s);
  const [sine, cosine] = [Math.sin(x), Math.cos(x)];
  const versine = 2 * Math.sin(0.5 * x) ** 2;
  const distance = axis * (1 - c * cosine + s * sine);
  const f = 1 - axis / radius * versine;
  const g = (radius * sine + s * axis * versine) * axis / root;
  const fDot = -root / (distance * radius) * sine;
  const gDot = 1 - axis / distance * versine;
  const angle = arc[NODE_RATE] * since;
  return {
    r: turned(sum(scaled(r, f), scaled(v, g)), angle),
    v: turned(sum(scaled(r, fDot), scaled(v, gDot)), angle),
  };
}

// The arc that a chaser is on; null before a launch, and after a tow that ends its route. After the
// last of its legs it stays where it is, which is no phase.
function arcAt(chaser, time) {
  const { arcs, stays } = chaser;
  if (!arcs.length) return null;
  let [low, high] = [0, arcs.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (arcs[middle][BEGIN] <= time) low = middle;
    else high = middle;
  }
  const arc = arcs[low];
  if (time < arc[BEGIN] && motion.legs[arc[LEG] - 1].launch) return null;
  const isOver = low === arcs.length - 1 && time > arc[END];
  if (isOver && !stays) return null;
  return { arc, phase: isOver ? null : arc[PHASE] };
}

function chaserState(chaser, time) {
  const found = arcAt(chaser, time);
  return found && { ...found, ...arcState(found.arc, time) };
}

// Above the turning Earth: latitude and longitude as on a sphere [°], altitude [m].
function above(r, time) {
  const [angle, rate] = motion.sidereal;
  const east = Math.atan2(r[1], r[0]) - angle - rate * time;
  return {
    latitude: Math.asin(r[2] / size(r)) * 180 / Math.PI,
    longitude: (east - 2 * Math.PI * Math.round(east / (2 * Math.PI))) * 180 / Math.PI,
    altitude: size(r) - motion.radius,
  };
}

// A place as seen from a body, along its orbit: how much higher, how far ahead as it flies, along
// the arc, and how far to the side of its plane [m]. Near it these are the axes of its local frame.
function seenFrom(body, r) {
  const up = scaled(body.r, 1 / size(body.r));
  const normal = cross(body.r, body.v);
  const side = scaled(normal, 1 / size(normal));
  const ahead = cross(side, up);
  const [a, b] = [dot(r, up), dot(r, ahead)];
  return {
    radial: Math.hypot(a, b) - size(body.r),
    along: Math.atan2(b, a) * size(body.r),
    cross: dot(r, side),
  };
}
