// Requests to the server, and the one sentence that says why one was refused.
import { box } from "./dom.js";
import { again, tell, told } from "./store.js";

const LOST = "adr-opt serve does not answer; is it still running?";

export function complain(sentence) {
  box("error").textContent = sentence;
  box("error").hidden = !sentence;
}

// An answer as JSON, or the sentence that refuses it.
async function asked(path, options) {
  try {
    const answer = await fetch(path, options);
    const content = await answer.json().catch(() => ({}));
    if (answer.ok) return { content, refused: "" };
    return { content: null, refused: content.error ?? `the server says ${answer.status}` };
  } catch {
    return { content: null, refused: LOST };
  }
}

export const post = (path, content = {}) => asked(path, {
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(content),
});

export const upload = (file) => asked(`/upload?name=${encodeURIComponent(file.name)}`, {
  method: "POST",
  headers: { "Content-Type": "application/octet-stream" },
  body: file,
});

export const get = (path) => asked(path, {});

// Posts, and complains at the top of the page; gives the answer, or null.
export async function send(path, content = {}) {
  const { content: answer, refused } = await post(path, content);
  complain(refused);
  if (refused) again("state"); // what was typed is not what holds
  return answer;
}

export const edit = (content) => send("/edit", content);

// A job of a verb; what it makes comes by events.
export const begin = (verb, options = {}, results = []) =>
  send("/jobs", { verb, options, results });

export function listen() {
  const events = new EventSource("/events");
  let lost = false;
  for (const name of ["state", "work", "jobs", "results"]) {
    events.addEventListener(name, (event) => tell(name, JSON.parse(event.data)));
  }
  events.addEventListener("trouble", (event) => complain(JSON.parse(event.data)));
  events.addEventListener("open", () => {
    if (lost) complain("");
    lost = false;
  });
  events.addEventListener("error", () => {
    lost = true;
    complain(LOST);
  });
}

// What the server offers: methods, verbs, and fields of forms.
export async function learn() {
  const [choices, forms] = await Promise.all([get("/choices"), get("/forms")]);
  complain(choices.refused || forms.refused);
  if (choices.content) tell("choices", choices.content);
  if (forms.content) tell("forms", forms.content);
  return told;
}
