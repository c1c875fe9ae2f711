// Files that are dropped on the page or chosen by the button, and the list of them.
import { box, counted, made, put } from "./dom.js";
import { follow } from "./store.js";
import { complain, upload } from "./talk.js";

const MOST_BYTES = 64 * 2 ** 20;

async function read(file) {
  if (file.size > MOST_BYTES) {
    return `${file.name}: larger than 64 MiB; import it by the command line`;
  }
  put("dropped", `Reading ${file.name}`);
  const { refused } = await upload(file);
  return !refused || refused.includes(file.name) ? refused : `${file.name}: ${refused}`;
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
  put("dropped", left.length ? "" : `${counted(files.length, "file")} read`);
  complain(left.map(({ refused }) => refused).join("; "));
}

function show(state) {
  const files = state.files ?? [];
  box("files").replaceChildren(...files.map(({ name, what, count }) => made(
    "li", {}, made("b", {}, name), ` ${what}${count ? `, ${count.toLocaleString("en-GB")}` : ""}`,
  )));
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
  follow("state", show);
}
