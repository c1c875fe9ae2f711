// Files that are dropped on the page or chosen by the button, and the list of them.
import { box, button, counted, made, put } from "./dom.js";
import { follow, told } from "./store.js";
import { send, upload } from "./talk.js";
import { view } from "./views.js";

const MOST_BYTES = 64 * 2 ** 20;
const refusals = new Map(); // why the latest file of a name was refused

async function read(file) {
  if (file.size > MOST_BYTES) {
    return "larger than 64 MiB; import it by the command line";
  }
  put("dropped", `Reading ${file.name}`);
  const { refused } = await upload(file);
  return refused.startsWith(`${file.name}: `) ? refused.slice(file.name.length + 2) : refused;
}

// One after the other; what was refused once more at the end, since a plan that stands before its
// instance is understood after it.
async function take(files) {
  document.documentElement.dataset.uploading = String(files.length);
  let left = files.map((file) => ({ file, refused: "" }));
  for (let turn = 0; turn < 2 && left.length; turn += 1) {
    const before = left.length;
    for (const each of left) each.refused = await read(each.file);
    left = left.filter(({ refused }) => refused);
    if (left.length === before) break;
  }
  delete document.documentElement.dataset.uploading;
  for (const { name } of files) refusals.delete(name);
  for (const { file, refused } of left) refusals.set(file.name, refused);
  const taken = `${counted(files.length - left.length, "file")} read`;
  put("dropped", left.length ? `${taken}, ${left.length.toLocaleString("en-GB")} refused` : taken);
  if (left.length) view("objects"); // where the reasons are
  show(told.state);
}

const forgotten = (name) => {
  refusals.delete(name);
  show(told.state);
};

// A file, what is wrong in it, and a button that removes it.
const rowOf = (name, said, wrong, remove) => made("li", {}, made("b", {}, name), said,
  button("Remove", remove, { "aria-label": `Remove ${name}` }),
  ...wrong.map((each) => made("p", { class: "why" }, each)));

function keptRow({ id, name, what, count, skipped, bad }) {
  const rows = count ? `, ${count.toLocaleString("en-GB")}` : "";
  const left = skipped ? `; ${counted(skipped, "bad row")} left out` : "";
  const more = skipped - bad.length;
  return rowOf(name, ` ${what}${rows}${left}`,
    [...bad, ...(more > 0 ? [`and ${counted(more, "bad row")} more`] : [])],
    () => send("/files/remove", { file: id }));
}

function show(state) {
  const files = state?.files ?? [];
  const key = JSON.stringify([files, [...refusals]]);
  if (box("files").dataset.key !== key) {
    box("files").dataset.key = key;
    box("files").replaceChildren(...files.map(keptRow), ...[...refusals].map(([name, refused]) => (
      rowOf(name, " refused", [refused], () => forgotten(name)))));
  }
  if (!state) return;
  document.body.classList.toggle("empty", !files.length && state.stage === "empty");
}

export function start() {
  const input = box("file");
  input.addEventListener("change", () => {
    take([...input.files]);
    input.value = "";
  });
  // The whole page takes files, so that one that misses the zone does not replace the page.
  for (const name of ["dragenter", "dragover"]) {
    addEventListener(name, (event) => {
      if (![...event.dataTransfer.types].includes("Files")) return;
      event.preventDefault();
      document.body.classList.add("dragging");
    });
  }
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dragging");
  });
  addEventListener("drop", (event) => {
    document.body.classList.remove("dragging");
    if (!event.dataTransfer.files.length) return;
    event.preventDefault();
    take([...event.dataTransfer.files]);
  });
  box("sample").addEventListener("click", () => send("/sample"));
  follow("state", show);
}
