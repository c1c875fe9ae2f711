// Keys of the whole page.
import { box } from "./dom.js";
import { clearBrushes } from "./objects.js";
import { viewed } from "./views.js";

export function start() {
  document.addEventListener("keydown", (event) => {
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    // What is being typed has an undo of its own.
    const typing = event.target.matches?.("input:not([type=checkbox], [type=range])");
    if (command && key === "enter" && viewed() === "mission") {
      event.target.blur(); // what is typed counts
      box("plan").click();
    } else if (key === "escape" && viewed() === "objects" && clearBrushes()) {
      // Brushes first; pressed again, it stops what runs.
    } else if (key === "escape" && !box("stop").disabled) box("stop").click();
    else if (command && !typing && key === "z") box(event.shiftKey ? "redo" : "undo").click();
    else if (command && !typing && key === "y") box("redo").click();
    else return;
    event.preventDefault();
  });
}
