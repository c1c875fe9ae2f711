// The frontier below the sliders: what the plans of the latest trade-off collect, with a line where
// the limit is that is dragged. Without such a trade-off a button begins one.
import { box, button, text } from "./dom.js";
import { plot } from "./points.js";
import { told } from "./store.js";
import { begin, get } from "./talk.js";

const [FROM, TO, STEP] = [0.5, 1.5, 0.25]; // of the first value of a limit
let known = { id: 0, points: null };

async function pointsOf(kind) {
  for (const { id } of told.results.filter(({ verb }) => verb === "tradeoff").reverse()) {
    if (known.id !== id) known = { id, points: (await get(`/results/points?id=${id}`)).content };
    if (known.points?.kind === kind) return known.points;
  }
  return null;
}

// The best of the plans that keep to a limit, in words.
function best({ across, points }, value) {
  const within = points.filter(({ values, prize }) => prize !== null && values[across] <= value * (1 + 1e-9));
  const [first] = within.sort((one, other) => other.prize - one.prize);
  if (!first) return "no plan is known of so little";
  const bound = first.bound === null ? "" : `, at most ${text(first.bound, 5)} there`;
  return `the best plan known collects ${text(first.prize, 5)}, at ${text(first.values[across], 5)}${bound}`;
}

export async function showFrontier(kind, label, value, first) {
  const points = await pointsOf(kind);
  box("frontier").hidden = false;
  if (points) {
    const said = `${label} ${text(value, 5)}: ${best(points, value)}. A dot opens its plan.`;
    box("frontier").replaceChildren(said, plot(known.id, points, value));
    return;
  }
  const vary = `${kind}=${[FROM, TO, STEP].map((share) => text(share * first)).join(":")}`;
  box("frontier").replaceChildren("What is gained or lost by more or less, trade-offs show. ",
    button(`Trade off ${label.toLowerCase()}`, () => begin("tradeoff", { vary })));
}
