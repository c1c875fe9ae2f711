// Marks that move, and the table of where the chasers are.
const MARKS = { station: 9, visited: 6, "not visited": 4 };
const MOST_TOLD = 3; // chasers, of which the spoken text says where they are
const GOAL = 10; // where the leg leads

// Chasers that are somewhere, with their states.
const present = () =>
  motion.chasers.flatMap((chaser) => {
    const state = chaserState(chaser, time);
    return state ? [{ chaser, ...state }] : [];
  });

const paint = ({ chaser, phase }) =>
  chaser.colour ?? (phase ? motion.phases[phase][1] : colour("text"));

// Names are kept as charts take them, who read tags and entities; elsewhere they are plain text.
const plain = (name) =>
  name.replace(/&lt;/g, "<").replace(/&gt;/g, ">").replace(/&amp;/g, "&");

function marks() {
  const bodies = motion.bodies.map((body) => bodyState(body, time).r);
  const leg = legShown();
  const goal = leg ? motion.legs[leg - 1].to : null;
  const chasers = present();
  return [
    {
      at: bodies, text: motion.bodies.map(({ name }) => name),
      colours: motion.bodies.map((body) => motion.kinds[body.kind]),
      sizes: motion.bodies.map((body, at) => (at === goal ? GOAL : MARKS[body.kind])),
      edges: motion.bodies.map((_, at) => (at === goal ? 2 : 0)),
    },
    {
      at: chasers.map(({ r }) => r), text: chasers.map(({ chaser }) => chaser.name),
      colours: chasers.map(paint), sizes: chasers.map(() => 12),
      edges: chasers.map(() => 1.5),
    },
  ];
}

// Lengths in metres below ten kilometres.
const far = (metres) =>
  (metres < 1e4 ? `${metres.toFixed(0)}\u202fm` : `${(metres / 1000).toFixed(0)}\u202fkm`);

const signed = (value, digits) => value.toFixed(digits).replace("-", "−");

// The phase, and where arcs are arcs of thrust whether it is on.
function stage(state) {
  if (!state.phase) return "done";
  const [title] = motion.phases[state.phase];
  if (!motion.spirals || state.arc[MIDDLE] === null) return title;
  return `${title}, ${thrusts(state, time) ? "on" : "off"}`;
}

// What is told of the chasers by the text that is spoken.
function whereabouts() {
  return present().map((state) => {
    const { chaser, r } = state;
    const { latitude, longitude, altitude } = above(r, time);
    const degrees = (value, [plus, minus]) => {
      const whole = Math.round(value);
      return `${Math.abs(whole)}°${whole ? ` ${whole < 0 ? minus : plus}` : ""}`;
    };
    return `${plain(chaser.name)}: ${stage(state)}, ` +
      `${far(altitude)} above ${degrees(latitude, ["north", "south"])}, ` +
      `${degrees(longitude, ["east", "west"])}, in ${isLit(r, time) ? "sunlight" : "shadow"}`;
  }).join(". ");
}

function status() {
  for (const row of document.querySelectorAll("tr[data-chaser]")) {
    const state = chaserState(motion.chasers[Number(row.dataset.chaser)], time);
    let said = ["—", "—", "—", "—", "—", "—", "—"];
    if (state) {
      const { latitude, longitude, altitude } = above(state.r, time);
      const leg = state.arc[LEG];
      const to = motion.legs[leg - 1].to;
      const goal = to === null ? null : motion.bodies[to];
      said = [
        state.phase ? `${leg}${goal ? ` → ${plain(goal.name)}` : ""}` : "—",
        stage(state),
        signed(altitude / 1000, 1), signed(latitude, 2), signed(longitude, 2),
        goal ? far(size(sum(state.r, scaled(bodyState(goal, time).r, -1)))) : "—",
        isLit(state.r, time) ? "sunlight" : "shadow",
      ];
    }
    [...row.cells].slice(1).forEach((cell, at) => { cell.textContent = said[at]; });
  }
}

if (motion) {
  views.push({ show: status });
  if (motion.chasers.length <= MOST_TOLD) tellers.push(whereabouts);
  stages.push(() => present().map(({ phase }) => phase).join());
}
