// The head of the page: what is open, where it is kept, and what undo would take back.
import { box, put } from "./dom.js";
import { follow } from "./store.js";
import { complain } from "./talk.js";

function show(state) {
  const name = state.name ?? state.project?.name ?? "Project";
  document.title = `${name} · adr-opt`;
  put("name", name);
  put("folder", `Kept in ${state.project?.folder ?? state.folder}`);
  if (state.trouble) complain(state.trouble);
  for (const [word, what] of [["Undo", state.undoes], ["Redo", state.redoes]]) {
    const button = box(word.toLowerCase());
    const said = what === null || what === undefined ? word : `${word}: ${what}`;
    button.disabled = said === word;
    button.title = said === word ? "" : said;
    button.setAttribute("aria-label", said);
  }
}

export function start() {
  follow("state", show);
}
