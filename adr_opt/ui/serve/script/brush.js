// Rectangles that are dragged in a plot: another one replaces them, with Shift it is added to them.
const SMALL = 4; // CSS pixels; what moves less is a click

// Calls changed() while a rectangle grows and at its end, clicked(right, down) for a click.
export function brush(plot, { changed, clicked }) {
  let from = null;
  let kept = [];
  const place = (event) => {
    const { left, top } = plot.over.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  const rectangle = ([right, down]) => {
    const x = [plot.across.back(from[0]), plot.across.back(right)].sort((a, b) => a - b);
    const y = [plot.up.back(from[1]), plot.up.back(down)].sort((a, b) => a - b);
    return [...x, ...y];
  };
  const large = ([right, down]) =>
    Math.abs(right - from[0]) > SMALL || Math.abs(down - from[1]) > SMALL;
  plot.over.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !plot.image) return;
    from = place(event);
    kept = event.shiftKey ? plot.rectangles : [];
    plot.over.setPointerCapture?.(event.pointerId);
    event.preventDefault();
  });
  plot.over.addEventListener("pointermove", (event) => {
    if (!from || !large(place(event))) return;
    plot.rectangles = [...kept, rectangle(place(event))];
    changed(false);
  });
  const end = (event) => {
    if (!from) return;
    const at = place(event);
    if (event.type === "pointerup" && !large(at)) clicked(...at, event.shiftKey);
    from = null;
    changed(true);
  };
  plot.over.addEventListener("pointerup", end);
  plot.over.addEventListener("pointercancel", end);
}
