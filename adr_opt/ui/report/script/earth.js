// The Earth: its coastlines on the map, and land and sea as a picture that the globe is covered with.
const [COLUMNS, ROWS] = [1440, 720]; // of the picture: cells of a quarter degree
const EVERY = 30; // degrees between meridians, and between parallels
const [SEA, LAND, MESH] = [0, 1, 2]; // what a cell is: land or sea, and 2 more on a line of the mesh

function unpacked({ units, lines }) {
  return lines.map((packed) => {
    const places = [];
    for (let x = 0, y = 0, at = 0; at < packed.length; at += 2) {
      x += packed[at];
      y += packed[at + 1];
      places.push([x / units, y / units]);
    }
    return places;
  });
}

const coasts = motion && unpacked(mission.coast);

// Lines of places as one line with gaps.
const coast = motion && (() => {
  const places = coasts.flatMap((line) => [...line, [null, null]]);
  return { longitude: places.map(([x]) => x), latitude: places.map(([, y]) => y) };
})();

// Cells from the north-west on. A line that goes around the Earth is closed by way of the pole.
function mapped() {
  const canvas = new OffscreenCanvas(COLUMNS, ROWS);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  for (const line of coasts) {
    const [from, to] = [line[0][0], line.at(-1)[0]];
    const around = from * to < 0 && Math.abs(from) === 180 && Math.abs(to) === 180;
    (around ? [...line, [to, -90], [from, -90]] : line).forEach(([x, y], at) => {
      context[at ? "lineTo" : "moveTo"]((x + 180) / 360 * COLUMNS, (90 - y) / 180 * ROWS);
    });
    context.closePath();
  }
  context.fill("evenodd");
  const { data } = context.getImageData(0, 0, COLUMNS, ROWS);
  const cells = new Uint8Array(COLUMNS * ROWS);
  for (let at = 0; at < cells.length; at += 1) {
    const meets = (cell, all) => cell % (EVERY * COLUMNS / 360) === 0 && cell > 0 && cell < all;
    cells[at] = (data[4 * at + 3] > 127 ? LAND : SEA)
      + (meets(at % COLUMNS, COLUMNS) || meets(Math.floor(at / COLUMNS), ROWS) ? MESH : 0);
  }
  return cells;
}
