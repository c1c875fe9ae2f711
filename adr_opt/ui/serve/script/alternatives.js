// Parts of a chaser that are one thing or another: where it starts and ends, and its tank.
import { dig, withValue } from "./field.js";

const ANYWHERE = "anywhere";
const ORBIT = "orbit of its own";
const [BY_SPEED, BY_MASS] = ["ΔV", "propellant"];
const MASS = ["dry_mass_kg", "propellant_kg", "isp_s", "initial_propellant_kg"];
const SPEED = ["delta_v_m_s", "initial_delta_v_m_s"];
const FIRST = { dry_mass_kg: 1000, propellant_kg: 1000, isp_s: 300 };
const EXHAUST_M_S = 9.80665 * FIRST.isp_s;

const at = (place) => (typeof place === "string" ? place : place?.station ?? ORBIT);

function place(label, path, orbits) {
  return {
    path, label, kind: "choice",
    choices: ({ stations }) => [
      ANYWHERE, ...stations.map(({ name }) => name), ...(orbits ? [ORBIT] : []),
    ],
    read: (chaser) => at(chaser[path]),
    write: (chaser, chosen, { stations }) => {
      if (chosen === ANYWHERE) return withValue(chaser, path, ANYWHERE);
      if (chosen !== ORBIT) return withValue(chaser, path, { station: chosen });
      const known = stations.find(({ name }) => name === chaser[path]?.station) ?? stations[0];
      return withValue(chaser, path, { orbit: structuredClone(known?.orbit ?? {}) });
    },
  };
}

// Each has the paths of its own that stand only with some choice.
export const ALTERNATIVES = [
  place("Start", "start", true),
  place("End", "end", false),
  {
    path: "tank", label: "Tank by", kind: "choice",
    choices: () => [BY_SPEED, BY_MASS],
    read: (chaser) => ("propellant_kg" in chaser.tank ? BY_MASS : BY_SPEED),
    // What fills one tank fills the other: the rocket equation for the first masses.
    write: (chaser, chosen) => {
      const { tank } = chaser;
      if (chosen === BY_SPEED) {
        const { dry_mass_kg: dry, propellant_kg: full, isp_s: isp } = tank;
        const speed = Math.round(9.80665 * isp * Math.log(1 + full / dry) * 10) / 10;
        return withValue(chaser, "tank", { delta_v_m_s: speed });
      }
      const full = FIRST.dry_mass_kg * Math.expm1(tank.delta_v_m_s / EXHAUST_M_S);
      return withValue(chaser, "tank", { ...FIRST, propellant_kg: Math.round(full * 10) / 10 });
    },
  },
];

// Whether a field stands in a chaser or station as it is now.
export function stands(element, path) {
  const [first, ...rest] = path.split(".");
  if (ALTERNATIVES.some((each) => each.path === path)) return false; // has its own control
  if (first === "tank" && element.tank) {
    return ("propellant_kg" in element.tank ? MASS : SPEED).includes(rest[0]);
  }
  if ((first === "start" || first === "end") && rest[0] === "orbit") {
    return dig(element, `${first}.orbit`) !== undefined;
  }
  return !(first === "start" || first === "end");
}
