// Parts that are one thing or another, such as a tank counted in ΔV or by mass: a choice, and the
// fields that belong to each of its values (`of` in the description of a field).
import { withValue } from "./field.js";

const LIKE = { dry_mass_kg: 1000, isp_s: 300 }; // a tank by mass that replaces one in ΔV
const DISPOSAL = { circle_m: 500000, perigee_m: 60000 };
const STANDARD_GRAVITY_M_S2 = 9.80665;
const round = (value) => Math.round(value * 10) / 10;

const belonging = (specs, path) => specs.filter(({ of }) => of?.[0] === path);

// Whether a choice has fields of its own; otherwise its value is what the instance says.
export const branches = (specs, { path, kind }) =>
  kind === "choice" && belonging(specs, path).length > 0;

// Which value of a choice the instance has, as it is now.
export function branch(specs, path, element) {
  const value = element?.[path];
  if (value === null || value === undefined) return null;
  if (typeof value !== "object") return value;
  return belonging(specs, path)
    .find((spec) => spec.path.split(".")[1] in value)?.of[1] ?? null;
}

// Whether a field belongs to an element as it is now.
export const stands = (specs, { of }, element) => !of || branch(specs, of[0], element) === of[1];

// What is filled in at first: what the other tank holds, by the rocket equation, the station or the
// orbit that is there, and defaults.
function first(path, value, element, instance) {
  const tank = path === "tank" ? element.tank : null;
  if (value === "mass") {
    const speed = tank?.delta_v_m_s ?? 0;
    const full = LIKE.dry_mass_kg * Math.expm1(speed / (STANDARD_GRAVITY_M_S2 * LIKE.isp_s));
    return { ...LIKE, propellant_kg: round(full) };
  }
  if (value === "delta-v") {
    const { dry_mass_kg: dry = 1, propellant_kg: full = 0, isp_s: isp = 0 } = tank ?? {};
    return { delta_v_m_s: round(STANDARD_GRAVITY_M_S2 * isp * Math.log1p(full / dry)) };
  }
  if (value in DISPOSAL) return { [value]: DISPOSAL[value] };
  const orbit = instance.stations.find((station) => station.orbit)?.orbit
    ?? instance.chasers.find(({ start }) => start?.orbit)?.start.orbit ?? {};
  if (value === "launch") {
    return { launch: { altitude_m: 500000, inclination_deg: orbit.inclination_deg ?? 98 } };
  }
  if (value === "station") return { station: instance.stations[0]?.name ?? "" };
  if (value === "orbit") return { orbit: structuredClone(orbit) };
  return path === "orbit" ? structuredClone(orbit) : {};
}

// A copy of an element with another value of a choice.
export function withBranch(specs, path, element, value, instance) {
  if (value === null) return withValue(element, path, null);
  const own = belonging(specs, path).filter(({ of }) => of[1] === value);
  if (!own.length) return withValue(element, path, value);
  const content = first(path, value, element, instance);
  for (const spec of own) {
    const names = spec.path.split(".").slice(1);
    if (names.length === 1 && !(names[0] in content) && spec.default !== null) {
      content[names[0]] = spec.default;
    }
  }
  return withValue(element, path, content);
}
