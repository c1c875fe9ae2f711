// The list of objects that pass: sorted by any column, with only the rows in the DOM that are seen.
import { COLUMNS, known, order } from "./columns.js";
import { box, made, placed, put, text } from "./dom.js";

const ROW = 30; // height in CSS pixels, as page.css has it
const SPARE = 4; // rows beyond the edges
const DIGITS = { altitude: 4, inclination: 4, node: 4, mass: 4, worth: 3 };

export class List {
  // ticked(at, on) is called when the reader ticks a row.
  constructor(ticked) {
    this.ticked = ticked;
    this.sorted = { name: "name", upwards: true };
    this.rows = [];
    this.shown = new Uint32Array(0);
    this.scroll = box("objects-scroll");
    this.body = box("objects-rows");
    this.scroll.addEventListener("scroll", () => this.ask(), { passive: true });
    new ResizeObserver(() => this.ask()).observe(this.scroll);
    this.body.addEventListener("keydown", (event) => this.walk(event));
    this.body.addEventListener("change", (event) => {
      this.ticked(Number(event.target.closest("tr").dataset.at), event.target.checked);
    });
  }

  take(field) {
    this.field = field;
    this.names = ["altitude", "inclination", "node", "mass", "worth"]
      .filter((name) => known(field[name]));
    this.rows = [];
    this.head();
    this.sort(this.sorted.name, this.sorted.upwards);
  }

  head() {
    const cell = (name, words) => {
      const title = COLUMNS[name]?.label;
      const press = made("button", { type: "button", class: "sort", title }, words);
      press.addEventListener("click", () => {
        this.sort(name, this.sorted.name === name ? !this.sorted.upwards : name === "name");
        this.scroll.scrollTop = 0;
        this.filter(this.passing);
      });
      return made("th", { scope: "col", "data-column": name }, press);
    };
    const titled = (name) => {
      const { label, short, unit } = COLUMNS[name];
      return unit ? `${short ?? label} [${unit}]` : label;
    };
    box("objects-head").replaceChildren(
      made("th", { scope: "col" }, made("span", { class: "away" }, "Ticked")),
      cell("name", "Name"), ...this.names.map((name) => cell(name, titled(name))),
    );
  }

  sort(name, upwards) {
    this.sorted = { name, upwards };
    this.order = order(this.field, name, upwards);
    for (const cell of box("objects-head").querySelectorAll("[data-column]")) {
      const mine = cell.dataset.column === name;
      if (mine) cell.setAttribute("aria-sort", upwards ? "ascending" : "descending");
      else cell.removeAttribute("aria-sort");
    }
  }

  filter(passing) {
    this.passing = passing;
    const kept = new Uint32Array(this.order.length);
    let count = 0;
    for (const at of this.order) if (passing[at]) kept[count++] = at;
    this.shown = kept.subarray(0, count);
    box("objects-table").setAttribute("aria-rowcount", String(count + 1));
    this.ask();
  }

  ask() {
    if (this.asked || !this.field) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = 0;
      this.draw();
    });
  }

  rowOf(number) {
    while (this.rows.length <= number) {
      const tick = made("input", { type: "checkbox" });
      const cells = this.names.map(() => made("td", { class: "n" }));
      const name = made("td", { class: "what" });
      this.rows.push({
        row: made("tr", {}, made("td", {}, tick), name, ...cells), tick, name, cells,
      });
    }
    return this.rows[number];
  }

  draw() {
    const seen = Math.ceil(this.scroll.clientHeight / ROW) + 2 * SPARE;
    const most = Math.max(this.shown.length - seen, 0);
    const first = Math.min(Math.max(Math.floor(this.scroll.scrollTop / ROW) - SPARE, 0), most);
    const last = Math.min(first + seen, this.shown.length);
    const drawn = [];
    // A row keeps its object while it is in view, and the focus with it: row n of m shows
    // objects n, n + m, n + 2 m of the list.
    for (let number = first; number < last; number += 1) {
      const at = this.shown[number];
      const mine = this.rowOf(number % seen);
      mine.row.dataset.at = String(at);
      mine.row.dataset.number = String(number);
      mine.row.setAttribute("aria-rowindex", String(number + 2));
      mine.tick.checked = this.field.ticked[at] === 1;
      mine.tick.setAttribute("aria-label", `Tick ${this.field.names[at]}`);
      put(mine.name, this.field.names[at]);
      mine.name.title = this.field.names[at];
      this.names.forEach((name, column) => (
        put(mine.cells[column], text(this.field[name][at], DIGITS[name]))));
      drawn.push(mine.row);
    }
    const [before, after] = [first * ROW, (this.shown.length - last) * ROW];
    box("objects-before").style.height = `${before}px`;
    box("objects-after").style.height = `${after}px`;
    const focused = document.activeElement;
    const within = this.body.contains(focused);
    placed(this.body, drawn);
    if (within && document.activeElement !== focused && this.body.contains(focused)) {
      focused.focus({ preventScroll: true });
    }
  }

  // Arrow keys go from row to row, beyond those that are seen, too.
  walk(event) {
    const page = Math.max(Math.floor(this.scroll.clientHeight / ROW) - 2, 1);
    const steps = {
      ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity,
    };
    const by = steps[event.key];
    const row = event.target.closest("tr");
    if (by === undefined || !row) return;
    event.preventDefault();
    const number = Math.min(Math.max(Number(row.dataset.number) + by, 0), this.shown.length - 1);
    const [top, height] = [number * ROW, this.scroll.clientHeight - 2 * ROW];
    if (top < this.scroll.scrollTop) this.scroll.scrollTop = top;
    else if (top > this.scroll.scrollTop + height) this.scroll.scrollTop = top - height;
    this.draw();
    this.body.querySelector(`tr[data-number="${number}"] input`)?.focus({ preventScroll: true });
  }
}
