// Day and night: the direction of the Sun, night on the map, and the shadow of the Earth, which is a
// cylinder.
const MERIDIANS = 121; // of the line on the map
const LEAST_TILT = 1e-5; // of the Sun over the equator, at which the line is drawn

// A unit vector in the frame of the elements.
function sunDirection(time) {
  const [longitude, rate, anomaly, anomalyRate, once, twice, obliquity] = motion.sun;
  const mean = anomaly + anomalyRate * time;
  const along = longitude + rate * time + once * Math.sin(mean) + twice * Math.sin(2 * mean);
  const [c, s] = [Math.cos(along), Math.sin(along)];
  return [c, Math.cos(obliquity) * s, Math.sin(obliquity) * s];
}

function isLit(r, time) {
  const sun = sunDirection(time);
  const ahead = dot(r, sun);
  return ahead > 0 || size(sum(r, scaled(sun, -ahead))) > motion.radius;
}

// Whether a chaser with low thrust thrusts: within a window about two opposite places, in sunlight.
function thrusts({ arc, phase, r, latitude }, time) {
  if (!motion.spirals || !phase || arc[MIDDLE] === null) return false;
  const off = (latitude - arc[MIDDLE]) / Math.PI;
  return Math.abs(off - Math.round(off)) * Math.PI <= arc[MIDDLE + 1] && isLit(r, time);
}

// Night on the map, as the outline of an area: along the line, and back along the dark pole.
function night(time) {
  const { latitude, longitude } = above(sunDirection(time), time);
  const tilt = Math.tan(latitude * Math.PI / 180);
  const tangent = Math.abs(tilt) > LEAST_TILT ? tilt : LEAST_TILT;
  const x = Array.from({ length: MERIDIANS }, (_, at) => 360 * at / (MERIDIANS - 1) - 180);
  const y = x.map((east) =>
    Math.atan(-Math.cos((east - longitude) * Math.PI / 180) / tangent) * 180 / Math.PI);
  const pole = tangent > 0 ? -90 : 90;
  return { x: [...x, 180, -180, x[0]], y: [...y, pole, pole, y[0]], sun: { latitude, longitude } };
}
