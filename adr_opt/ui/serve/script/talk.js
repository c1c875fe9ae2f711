// Requests to the server, and the one sentence that says why one was refused.
import { box } from "./dom.js";
import { again, tell, told } from "./store.js";

const LOST = "adr-opt serve does not answer; is it still running?";
const OVER = {
  lost: "adr-opt serve has ended or cannot be reached, and this page no longer follows it; start it, "
    + "and open the address that it prints.",
  restarted: "adr-opt serve was started anew, and this page no longer follows it; open the address "
    + "that was printed.",
};
const SERVER = document.documentElement.dataset.server;

let over = ""; // why this page follows no server any more

export function complain(sentence) {
  box("error").textContent = over || sentence;
  box("error").hidden = !box("error").textContent;
}

// Says once that the server is gone: what is on the page stays to be read, and nothing is asked.
function end(why) {
  if (over) return;
  over = OVER[why];
  complain(over);
  for (const part of document.querySelectorAll("header .acts, #desk > section, #desk > div")) {
    part.inert = true;
  }
  if (told.work?.runs) tell("work", { ...told.work, phase: "lost", runs: false });
  tell("jobs", told.jobs.map((job) => (
    ["waiting", "running"].includes(job.state) ? { ...job, state: "lost", said: "" } : job)));
  document.documentElement.dataset.over = why;
}

// An answer as JSON, or the sentence that refuses it.
async function asked(path, options) {
  if (over) return { content: null, refused: over };
  try {
    const headers = { ...options.headers, "Adr-Opt-Server": SERVER };
    const answer = await fetch(path, { ...options, headers });
    const content = await answer.json().catch(() => ({}));
    if (answer.ok) return { content, refused: "" };
    if (answer.status === 403 || answer.status === 409) end("restarted");
    return { content: null, refused: content.error ?? `the server says ${answer.status}` };
  } catch {
    return { content: null, refused: LOST };
  }
}

// A state that is older than the one that is known comes late: answers and the stream overtake each
// other.
function tellState(state) {
  if (state.revision >= (told.state?.revision ?? 0)) tell("state", state);
}

// What changes something is asked one after the other, and each answer has the state that it leaves:
// what follows an edit is of what that has made, however soon it is clicked.
let turn = Promise.resolve();

function inTurn(path, kind, body) {
  const mine = turn.then(async () => {
    const found = await asked(path, { method: "POST", headers: { "Content-Type": kind }, body: body() });
    if (found.content?.state) tellState(found.content.state);
    return found;
  });
  turn = mine.catch(() => {});
  return mine;
}

// Content that is made of the state is a function, which is called when its turn comes.
export const post = (path, content = {}) => inTurn(path, "application/json", () => (
  JSON.stringify(typeof content === "function" ? content() : content)));

export const upload = (file) => inTurn(
  `/upload?name=${encodeURIComponent(file.name)}`, "application/octet-stream", () => file);

export const get = (path) => asked(path, {});

// Posts, and complains at the top of the page; gives the answer, or null.
export async function send(path, content = {}) {
  const { content: answer, refused } = await post(path, content);
  complain(refused);
  if (refused) again("state"); // what was typed is not what holds
  return answer;
}

// The sentence that refuses an edit, for the field that it is of; empty if none does.
export const refusal = async (content) => (await post("/edit", content)).refused;

export const edit = (content) => send("/edit", content);

// A job of a verb; what it makes comes by events.
export const begin = (verb, options = {}, results = []) =>
  send("/jobs", { verb, options, results });

// Follows the stream that all tabs share, while this one is seen, and until it has been told once.
export function listen() {
  const worker = new SharedWorker("/script/stream.js", { name: SERVER });
  const heed = () => {
    if (!over) worker.port.postMessage(!document.hidden || !told.work);
  };
  worker.port.onmessage = ({ data: [kind, content] }) => {
    if (kind === "over") end(content);
    else if (kind === "trouble") complain(JSON.parse(content));
    else if (kind === "state") tellState(JSON.parse(content));
    else tell(kind, JSON.parse(content));
    if (document.hidden) heed();
  };
  worker.onerror = () => end("lost");
  document.addEventListener("visibilitychange", heed);
  addEventListener("pagehide", () => worker.port.postMessage(false));
  addEventListener("pageshow", heed);
  heed();
}

// What the server offers: methods, verbs, and fields of forms.
export async function learn() {
  const [choices, forms] = await Promise.all([get("/choices"), get("/forms")]);
  complain(choices.refused || forms.refused);
  if (choices.content) tell("choices", choices.content);
  if (forms.content) tell("forms", forms.content);
  return told;
}
