// The dropped objects as columns of numbers, and the ones among them that pass all filters.

// Columns that are plotted, listed and filtered, by name.
export const COLUMNS = {
  altitude: { key: "altitude_km", label: "Altitude", short: "Alt.", unit: "km" },
  inclination: { key: "inclination_deg", label: "Inclination", short: "Incl.", unit: "deg" },
  node: { key: "raan_deg", label: "Node", unit: "deg", around: 360 },
  eccentricity: { key: "eccentricity", label: "Eccentricity", unit: "" },
  mass: { key: "mass_kg", label: "Mass", unit: "kg" },
  worth: { key: "worth", label: "Worth", unit: "" },
};
const NO_KIND = "unknown";

// Typed arrays of what the server answers; NaN stands where nothing is known.
export function columnsOf(answer) {
  const count = answer.names.length;
  const field = { count, names: answer.names, unit: answer.worth_unit ?? "", epoch: answer.epoch };
  for (const [name, { key }] of Object.entries(COLUMNS)) {
    const column = new Float64Array(count).fill(NaN);
    const given = answer[key] ?? [];
    for (let at = 0; at < given.length; at += 1) if (given[at] !== null) column[at] = given[at];
    field[name] = column;
  }
  field.lower = answer.names.map((name) => name.toLowerCase());
  const kinds = (answer.kind ?? []).map((kind) => kind ?? NO_KIND);
  field.kinds = [...new Set(kinds)].sort((a, b) => (a === NO_KIND) - (b === NO_KIND) || (a < b ? -1 : 1));
  if (!field.kinds.length) field.kinds = [NO_KIND];
  const number = new Map(field.kinds.map((kind, at) => [kind, at]));
  field.kind = Uint8Array.from({ length: count }, (_, at) => number.get(kinds[at] ?? NO_KIND));
  field.ticked = new Uint8Array(count);
  for (const at of answer.chosen ?? []) field.ticked[at] = 1;
  return field;
}

export const known = (column) => column.some((value) => !Number.isNaN(value));

// Least and greatest value among those that are marked; of all, if none is.
export function extent(column, marked = null) {
  let [low, high] = [Infinity, -Infinity];
  for (let at = 0; at < column.length; at += 1) {
    if (marked && !marked[at]) continue;
    const value = column[at];
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 1];
}

// Marks objects that pass: within the rectangles of each plot that has some, within all ranges,
// of a kind that is not hidden, with the words in their names. Gives their number.
export function sift(field, filters, passing) {
  passing.fill(1);
  for (const { x, y, rectangles } of filters.plots) {
    if (!rectangles.length) continue;
    const [across, up] = [field[x], field[y]];
    for (let at = 0; at < field.count; at += 1) {
      if (!passing[at]) continue;
      let inside = 0;
      for (const [x0, x1, y0, y1] of rectangles) {
        if (across[at] >= x0 && across[at] <= x1 && up[at] >= y0 && up[at] <= y1) {
          inside = 1;
          break;
        }
      }
      passing[at] = inside;
    }
  }
  for (const [name, [low, high]] of Object.entries(filters.ranges)) {
    if (low === null && high === null) continue;
    const column = field[name];
    const [least, most] = [low ?? -Infinity, high ?? Infinity];
    // Angles may pass through zero: from 350 to 10 degrees.
    const through = COLUMNS[name].around && least > most;
    for (let at = 0; at < field.count; at += 1) {
      const value = column[at];
      const inside = through ? value >= least || value <= most : value >= least && value <= most;
      if (!inside) passing[at] = 0;
    }
  }
  if (filters.hidden.size) {
    for (let at = 0; at < field.count; at += 1) if (filters.hidden.has(field.kind[at])) passing[at] = 0;
  }
  if (filters.words) {
    for (let at = 0; at < field.count; at += 1) {
      if (passing[at] && !field.lower[at].includes(filters.words)) passing[at] = 0;
    }
  }
  let count = 0;
  for (let at = 0; at < field.count; at += 1) count += passing[at];
  return count;
}

// Whether any filter is set.
export const filtering = (filters) =>
  filters.plots.some(({ rectangles }) => rectangles.length > 0)
  || Object.values(filters.ranges).some(([low, high]) => low !== null || high !== null)
  || filters.hidden.size > 0 || filters.words !== "";

// Numbers of all objects, sorted by a column; what is not known comes last.
export function order(field, name, upwards) {
  const numbers = Uint32Array.from({ length: field.count }, (_, at) => at);
  const sign = upwards ? 1 : -1;
  if (name === "name") {
    const { lower } = field;
    return numbers.sort((a, b) => sign * (lower[a] < lower[b] ? -1 : Number(lower[a] > lower[b])) || a - b);
  }
  const column = field[name];
  const of = (at) => (Number.isNaN(column[at]) ? Infinity : sign * column[at]);
  const keys = Float64Array.from(numbers, of);
  return numbers.sort((a, b) => (keys[a] === keys[b] ? a - b : keys[a] - keys[b]));
}
