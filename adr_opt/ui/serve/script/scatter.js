// One scatter plot on two canvases: below, axes and all objects, drawn once; above, the objects
// that pass and the rectangles of the brush, drawn as often as they change.
import { COLUMNS, extent } from "./columns.js";
import { colour, made, text, ticks } from "./dom.js";
import { pixel } from "./paint.js";

const ROUND = [1, 2, 5];
const [LEFT, RIGHT, TOP, BOTTOM] = [62, 10, 8, 36]; // margins in CSS pixels
const FEW = 1500; // objects are drawn larger below this number

// A scale from values to pixels and back: of logarithms where values span more than a decade.
function scale(name, [low, high], from, to) {
  const logarithmic = name === "altitude" && low > 0 && high / low > 10;
  const of = logarithmic ? Math.log : (value) => value;
  const back = logarithmic ? Math.exp : (value) => value;
  const room = (of(high) - of(low)) * 0.03 || 1;
  const [first, last] = [of(low) - room, of(high) + room];
  const slope = (to - from) / (last - first);
  const bounds = [back(first), back(last)];
  let marks = ticks(...bounds, Math.abs(to - from) / 70);
  if (logarithmic) {
    marks = [];
    for (let power = 1; power <= bounds[1]; power *= 10) {
      marks.push(...ROUND.map((each) => each * power).filter((at) => at >= bounds[0] && at <= bounds[1]));
    }
  }
  return {
    to: (value) => from + (of(value) - first) * slope,
    back: (at) => back(first + (at - from) / slope),
    marks,
  };
}

export class Scatter {
  constructor(holder, x, y) {
    Object.assign(this, { x, y, rectangles: [], drag: null, field: null });
    const name = `${COLUMNS[y].label} over ${COLUMNS[x].label.toLowerCase()}`;
    this.name = name;
    this.under = made("canvas", { "aria-hidden": "true" });
    this.over = made("canvas", { role: "img", "aria-label": name, class: "brushed" });
    holder.append(made("figure", { class: "plot" }, this.under, this.over));
    this.holder = this.over.parentElement;
    this.bounds = null; // of what is shown; null for all
  }

  boundsOf(passing) {
    return [extent(this.field[this.x], passing), extent(this.field[this.y], passing)];
  }

  // Sizes follow the window; pixels of all objects are worked out once for each size.
  fit() {
    if (!this.field) return false;
    const { clientWidth, clientHeight } = this.holder;
    if (!clientWidth || !clientHeight) return false;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    for (const canvas of [this.under, this.over]) {
      canvas.width = Math.round(clientWidth * this.ratio);
      canvas.height = Math.round(clientHeight * this.ratio);
    }
    this.width = this.over.width;
    this.height = this.over.height;
    const { field, x, y } = this;
    const bounds = this.bounds ?? this.boundsOf(null);
    this.across = scale(x, bounds[0], LEFT, clientWidth - RIGHT);
    this.up = scale(y, bounds[1], clientHeight - BOTTOM, TOP);
    this.pixelX = new Int16Array(field.count);
    this.pixelY = new Int16Array(field.count);
    for (let at = 0; at < field.count; at += 1) {
      const [right, down] = [this.across.to(field[x][at]), this.up.to(field[y][at])];
      const inside = right >= LEFT && right <= clientWidth - RIGHT
        && down >= TOP && down <= clientHeight - BOTTOM;
      this.pixelX[at] = inside ? Math.round(right * this.ratio) : -1;
      this.pixelY[at] = inside ? Math.round(down * this.ratio) : -1;
    }
    this.image = new ImageData(this.width, this.height);
    this.dots = new Uint32Array(this.image.data.buffer);
    this.drawUnder(clientWidth, clientHeight);
    return true;
  }

  drawUnder(width, height) {
    const pen = this.under.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    this.dots.fill(0);
    const dim = pixel("dim");
    for (let at = 0; at < this.field.count; at += 1) this.dot(at, dim, 1);
    pen.putImageData(this.image, 0, 0);
    pen.scale(this.ratio, this.ratio);
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    pen.fillStyle = colour("quiet");
    pen.strokeStyle = colour("line-strong");
    pen.lineWidth = 1;
    pen.strokeRect(LEFT - 0.5, TOP - 0.5, width - LEFT - RIGHT + 1, height - TOP - BOTTOM + 1);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const value of this.across.marks) {
      pen.fillText(text(value, 5), this.across.to(value), height - BOTTOM + 4);
    }
    const title = (name) => {
      const { label, unit } = COLUMNS[name];
      return unit ? `${label} [${unit}]` : label;
    };
    pen.fillText(title(this.x), (LEFT + width - RIGHT) / 2, height - 16);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of this.up.marks) pen.fillText(text(value, 5), LEFT - 5, this.up.to(value));
    pen.save();
    pen.translate(9, (TOP + height - BOTTOM) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(title(this.y), 0, 0);
    pen.restore();
  }

  // A square of pixels; the row above and the column before are within the margins.
  dot(at, pixel, size) {
    const x = this.pixelX[at];
    if (x < 0) return;
    const { dots, width } = this;
    let start = (this.pixelY[at] - (size >> 1)) * width + x - (size >> 1);
    for (let down = 0; down < size; down += 1, start += width) {
      for (let right = 0; right < size; right += 1) dots[start + right] = pixel;
    }
  }

  drawOver(passing, count, painted, ticked) {
    if (!this.image) return;
    const pen = this.over.getContext("2d");
    this.dots.fill(0);
    const size = Math.round((count < FEW ? 4 : 2) * this.ratio);
    const { pixels, numbers } = painted;
    for (let number = 0; number < numbers.length; number += 1) {
      const at = numbers[number];
      if (passing[at]) this.dot(at, pixels[at], size);
    }
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.putImageData(this.image, 0, 0);
    pen.scale(this.ratio, this.ratio);
    pen.strokeStyle = colour("text");
    pen.lineWidth = 1.5;
    for (const at of ticked) {
      if (this.pixelX[at] < 0) continue;
      pen.strokeRect(this.pixelX[at] / this.ratio - 4, this.pixelY[at] / this.ratio - 4, 8, 8);
    }
    pen.strokeStyle = colour("accent");
    for (const [x0, x1, y0, y1] of this.rectangles) {
      const [left, top] = [this.across.to(x0), this.up.to(y1)];
      pen.strokeRect(left, top, this.across.to(x1) - left, this.up.to(y0) - top);
    }
  }

  // The object that is nearest to a place, within a few pixels; -1 for none.
  nearest(right, down, passing) {
    let [found, least] = [-1, (8 * this.ratio) ** 2];
    for (let at = 0; at < this.field.count; at += 1) {
      if (!passing[at] || this.pixelX[at] < 0) continue;
      const away = (this.pixelX[at] - right * this.ratio) ** 2
        + (this.pixelY[at] - down * this.ratio) ** 2;
      if (away < least) [found, least] = [at, away];
    }
    return found;
  }
}
