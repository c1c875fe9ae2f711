// The library of charts is megabytes of script: it runs when the tiles have been painted.
const PATIENCE_MS = 2000; // out of sight nothing is painted
await new Promise((done) => {
  requestAnimationFrame(() => setTimeout(done));
  setTimeout(done, PATIENCE_MS);
});

// It reads back what it draws on canvases, for text in space and for pictures.
const { getContext } = HTMLCanvasElement.prototype;
HTMLCanvasElement.prototype.getContext = function context(kind, options) {
  return getContext.call(this, kind, kind === "2d" ? { willReadFrequently: true, ...options } : options);
};

document.documentElement.dataset.loading = String(Math.round(performance.now()));
const library = document.createElement("script");
library.textContent = document.getElementById("library").textContent;
document.head.append(library);
