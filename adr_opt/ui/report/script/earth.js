// The turning Earth: coastlines on the map, and on the globe with meridians and parallels.
const ABOVE = 1.01; // radii, so that the facets of the globe hide no line
const EVERY = 30; // degrees between meridians, and between parallels

// Lines of places as one line with gaps.
const joined = (lines) => {
  const places = lines.flatMap((line) => [...line, [null, null]]);
  return { longitude: places.map(([x]) => x), latitude: places.map(([, y]) => y) };
};

function unpacked({ units, lines }) {
  return joined(lines.map((packed) => {
    const places = [];
    for (let x = 0, y = 0, at = 0; at < packed.length; at += 2) {
      x += packed[at];
      y += packed[at + 1];
      places.push([x / units, y / units]);
    }
    return places;
  }));
}

function graticule() {
  const lines = [];
  for (let x = -180; x < 180; x += EVERY) {
    lines.push(Array.from({ length: 37 }, (_, at) => [x, 5 * at - 90]));
  }
  for (let y = EVERY - 90; y < 90; y += EVERY) {
    lines.push(Array.from({ length: 73 }, (_, at) => [5 * at - 180, y]));
  }
  return joined(lines);
}

// As points that turn with the Earth [km].
function onGlobe({ longitude, latitude }) {
  const radius = ABOVE * motion.radius / 1000;
  return longitude.map((degrees, at) => {
    if (degrees === null) return null;
    const [east, north] = [degrees, latitude[at]].map((angle) => angle * Math.PI / 180);
    return [Math.cos(north) * Math.cos(east), Math.cos(north) * Math.sin(east), Math.sin(north)]
      .map((part) => radius * part);
  });
}

// The globe in the colours of day and night, which are those of this place of the Sun.
const STALE = Math.cos(0.5 * Math.PI / 180); // of the Sun since
let painted = null;

function facesNow(trace) {
  const sun = sunDirection(time);
  painted = sun;
  return trace.x.map((x, at) => {
    const [r, g, b] = shade([x, trace.y[at], trace.z[at]], sun);
    return `rgb(${r},${g},${b})`;
  });
}

const inDaylight = (trace) =>
  (trace.type === "mesh3d" ? { ...trace, vertexcolor: facesNow(trace) } : trace);

function daylight(chart) {
  if (painted && dot(painted, sunDirection(time)) > STALE) return null;
  const at = chart.data.findIndex(({ type }) => type === "mesh3d");
  return at < 0 ? null : Plotly.restyle(chart, { vertexcolor: [facesNow(chart.data[at])] }, [at]);
}

const coast = motion && unpacked(mission.coast);
const globe = motion && [
  { name: "graticule", width: 1, colour: () => "#b4c7d6", points: onGlobe(graticule()) },
  { name: "coastlines", width: 2, points: onGlobe(coast),
    colour: () => (drawsWith() === "" ? colour("quiet") : "#2b4a66") },
];

// The lines of the globe at the time that is shown.
function earthLines() {
  const [angle, rate] = motion.sidereal;
  const lines = [...globe, {
    name: "day and night", width: 3, colour: () => "#d98a00", still: true,
    points: terminator(time, ABOVE * motion.radius / 1000),
  }];
  return lines.map(({ name, width, colour: painted, points, still }) => {
    const turn = still ? 0 : angle + rate * time;
    const now = turn ? points.map((point) => point && turned(point, turn)) : points;
    const [x, y, z] = [0, 1, 2].map((axis) => now.map((point) => point && point[axis]));
    return {
      type: "scatter3d", mode: "lines", name, showlegend: false, hoverinfo: "skip", x, y, z,
      meta: { earth: true }, line: { color: painted(), width },
    };
  });
}
