"use strict";
(() => {
  const box = (name) => document.getElementById(name);
  const MOST_ROWS = 300; // of the table of targets; the filter finds the others
  const DAY_S = 86400;
  const NOTHING = "—";
  const PHASES = {
    idle: "Not planned yet",
    waiting: "Waiting for the plan before to stop",
    compiling: "Getting ready",
    timetable: "Building the timetable",
    planning: "Planning",
    done: "Done",
    failed: "Failed",
  };
  let state = null; // as the server told it last
  let work = null;
  let shown = []; // names of the targets in the table
  let reported = null; // number of the plan whose report is there

  // The token stands in a cookie now; an address that is copied or bookmarked need not have it.
  if (location.search) history.replaceState(null, "", "/");

  const text = (value, digits = 6) =>
    value === null || value === undefined ? NOTHING : String(Number(value.toPrecision(digits)));

  function complain(sentence) {
    box("error").textContent = sentence;
    box("error").hidden = !sentence;
  }

  async function send(path, content = {}) {
    let said = "";
    try {
      const answer = await fetch(path, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(content),
      });
      if (!answer.ok) said = (await answer.json()).error ?? `the server says ${answer.status}`;
    } catch {
      said = "adr-opt serve does not answer; is it still running?";
    }
    complain(said);
    if (said) show(); // what was typed is not what holds
    return !said;
  }

  const edit = (content) => send("/edit", content);
  const plan = () => send("/plan", {
    method: box("method").value,
    time_limit_s: box("limit").value === "" ? 0 : Number(box("limit").value),
    bound: box("bound").value || null,
    goes_on: box("goes-on").checked,
  });

  // ---- Limits: duration, and a budget for each chaser -------------------------------------------

  // About a hundredth of the range, as 1, 2 or 5 times a power of ten.
  function step(range) {
    const rough = range / 100 || 1;
    const power = 10 ** Math.floor(Math.log10(rough));
    return power * ([1, 2, 5].find((each) => each * power >= rough) ?? 10);
  }

  function limit(key, label, unit, first, change) {
    const row = document.createElement("div");
    row.className = "limit";
    const named = document.createElement("label");
    named.append(`${label} [${unit}] `);
    const field = document.createElement("input");
    field.type = "number";
    field.min = "0";
    field.step = "any";
    field.inputMode = "decimal";
    field.id = `limit-${key}`;
    named.append(field);
    const slider = document.createElement("input");
    slider.type = "range";
    slider.setAttribute("aria-label", `${label} [${unit}], slider`);
    const worth = document.createElement("span");
    worth.className = "worth";
    row.append(named, slider, worth);
    slider.addEventListener("input", () => { field.value = slider.value; });
    for (const input of [slider, field]) {
      input.addEventListener("change", () => {
        if (input.value !== "") change(Number(input.value));
        else show();
      });
    }
    const set = (value, told = "") => {
      slider.min = "0";
      slider.step = String(step(2 * first));
      slider.max = String(Math.max(2 * first, value) || 1);
      slider.value = String(value);
      if (document.activeElement !== field || Number(field.value) !== value) {
        field.value = text(value, 10);
      }
      worth.textContent = told;
    };
    return { row, set };
  }

  let limits = null;
  function showLimits() {
    if (limits === null) {
      limits = [limit("duration", "Duration", "d", state.first_duration_s / DAY_S,
        (days) => edit({ duration_s: days * DAY_S }))];
      state.chasers.forEach((chaser, at) => {
        const label = state.chasers.length > 1 ? `Budget of ${chaser.name}` : "Budget";
        limits.push(limit(`budget-${at}`, label, chaser.unit, chaser.first,
          (amount) => edit({ budget: { chaser: chaser.name, amount } })));
      });
      box("limits").append(...limits.map((each) => each.row));
    }
    limits[0].set(state.duration_s / DAY_S);
    state.chasers.forEach((chaser, at) => {
      const told = chaser.unit === "kg" ? `${text(chaser.delta_v_m_s, 5)} m/s without cargo` : "";
      limits[at + 1].set(chaser.amount, told);
    });
  }

  // ---- Targets ----------------------------------------------------------------------------------

  const rows = new Map(); // by name

  function rowOf(name) {
    if (rows.has(name)) return rows.get(name);
    const row = document.createElement("tr");
    const cell = (content) => {
      const made = document.createElement("td");
      made.append(content);
      row.append(made);
      return content;
    };
    cell(document.createTextNode(name));
    row.firstChild.title = name;
    const input = (type, label) => {
      const made = document.createElement("input");
      made.type = type;
      made.setAttribute("aria-label", `${label} ${name}`);
      return cell(made);
    };
    const prize = input("number", "Prize of");
    prize.min = "0";
    prize.step = "any";
    const required = input("checkbox", "Require");
    const excluded = input("checkbox", "Exclude");
    const change = (changes) => edit({ targets: { names: [name], ...changes } });
    prize.addEventListener("change", () => {
      if (prize.value !== "") change({ prize: Number(prize.value) });
      else show();
    });
    required.addEventListener("change", () => change({ required: required.checked }));
    excluded.addEventListener("change", () => change({ excluded: excluded.checked }));
    const made = { row, prize, required, excluded };
    rows.set(name, made);
    return made;
  }

  const KINDS = {
    all: () => true,
    visited: ([, , , , visited]) => visited,
    left: ([, , , excluded, visited]) => !visited && !excluded,
    required: ([, , required]) => required,
    excluded: ([, , , excluded]) => excluded,
  };

  function showTargets() {
    const wanted = box("filter").value.trim().toLowerCase();
    const kind = KINDS[box("kind").value];
    const found = state.targets.filter(
      (target) => kind(target) && target[0].toLowerCase().includes(wanted));
    const first = found.slice(0, MOST_ROWS);
    const names = first.map(([name]) => name);
    for (const [name, prize, required, excluded, visited] of first) {
      const made = rowOf(name);
      if (document.activeElement !== made.prize || Number(made.prize.value) !== prize) {
        made.prize.value = text(prize, 10);
      }
      made.required.checked = required;
      made.excluded.checked = excluded;
      made.row.classList.toggle("excluded", excluded);
      made.row.classList.toggle("visited", visited);
    }
    // Rows stay where they are while somebody works in one of them.
    const before = [...box("targets").children].map((row) => row.firstChild.title);
    if (before.length !== names.length || before.some((name, at) => name !== names[at])) {
      box("targets").replaceChildren(...names.map((name) => rowOf(name).row));
    }
    shown = found.map(([name]) => name);
    const more = found.length - first.length;
    box("more").textContent = more
      ? `${more} more: the filter finds them; what is set of all shown is set of them, too` : "";
    box("shown").textContent = `All ${found.length} shown:`;
    for (const name of ["exclude-shown", "include-shown", "set-shown", "prize-shown"]) {
      box(name).disabled = !found.length;
    }
    const count = (kindOf) => state.targets.filter(KINDS[kindOf]).length;
    box("counts").textContent = `${state.targets.length} in all, ${count("visited")} visited, `
      + `${count("required")} required, ${count("excluded")} excluded`;
  }

  // ---- The run ----------------------------------------------------------------------------------

  const SVG = "http://www.w3.org/2000/svg";
  function drawn(tag, attributes, content = "") {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = content;
    return made;
  }

  // Round numbers that divide a range into about so many parts.
  function ticks(low, high, parts) {
    const each = step(((high - low) / parts) * 100);
    const found = [];
    for (let at = Math.ceil(low / each - 1e-9); at * each <= high + 1e-9 * each; at += 1) {
      found.push(Number((at * each).toPrecision(12)));
    }
    return found;
  }

  function drawChart() {
    const chart = box("chart");
    const width = chart.clientWidth || 360;
    const height = 150;
    chart.setAttribute("viewBox", `0 0 ${width} ${height}`);
    chart.replaceChildren();
    if (!work || !work.points.length) {
      chart.append(drawn("text", { x: width / 2, y: height / 2, "text-anchor": "middle" },
        "incumbent and bound come here"));
      return;
    }
    const lines = ["incumbent", "bound"].map((name, at) => ({
      name, points: work.points.map((point) => [point[0], point[at + 1]])
        .filter((point) => point[1] !== null),
    }));
    const values = lines.flatMap((line) => line.points.map((point) => point[1]));
    if (!values.length) return;
    const end = Math.max(work.elapsed_s, 1e-3);
    let low = Math.min(...values);
    let high = Math.max(...values);
    const room = (high - low) * 0.12 || Math.abs(high) * 0.05 || 1;
    [low, high] = [Math.max(low - room, Math.min(low, 0)), high + room];
    const left = 44;
    const right = width - 8;
    const [top, bottom] = [16, height - 20];
    const x = (at) => left + ((right - left) * at) / end;
    const y = (value) => bottom - ((bottom - top) * (value - low)) / (high - low);
    for (const value of ticks(low, high, 4)) {
      chart.append(
        drawn("line", { class: "grid", x1: left, x2: right, y1: y(value), y2: y(value) }),
        drawn("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, text(value, 5)),
      );
    }
    for (const at of ticks(0, end, 4)) {
      chart.append(drawn("text", { x: Math.min(x(at), right - 8), y: height - 5, "text-anchor": "middle" },
        `${text(at, 4)} s`));
    }
    // Each value holds until the next one.
    const stairs = (points) => {
      const corners = points.flatMap(([at, value], number) => {
        const next = number + 1 < points.length ? points[number + 1][0] : end;
        return [[at, value], [Math.max(next, at), value]];
      });
      return corners.map(([at, value]) => `${x(at).toFixed(1)},${y(value).toFixed(1)}`);
    };
    const both = work.points.filter((point) => point[1] !== null && point[2] !== null);
    if (both.length) {
      const under = stairs(both.map((point) => [point[0], point[1]]));
      const over = stairs(both.map((point) => [point[0], point[2]]));
      chart.append(drawn("polygon", { class: "between", points: [...over, ...under.reverse()].join(" ") }));
    }
    for (const { name, points } of lines) {
      if (!points.length) continue;
      chart.append(drawn("polyline", { class: name, points: stairs(points).join(" ") }));
    }
    const names = drawn("text", { x: right, y: 11, "text-anchor": "end" });
    names.append(
      drawn("tspan", { class: "name-incumbent" }, "incumbent"), "\u2003",
      drawn("tspan", { class: "name-bound" }, "bound (dashed)"),
    );
    chart.append(names);
  }

  function put(name, said) {
    if (box(name).textContent !== said) box(name).textContent = said; // or it is read out again
  }

  function showWork() {
    const { phase, stopping, runs } = work;
    // While nothing runs: the figures of the plan that is shown, as its report has them.
    const settled = !runs && state?.plan;
    const known = settled
      ? { ...settled, incumbent: settled.objective, bound: settled.upper_bound } : work;
    let line = PHASES[phase];
    if (settled && phase === "idle") line = "The plan that was given";
    if (runs && stopping) line = "Stopping: the best plan so far is on its way";
    put("phase", line);
    put("incumbent", text(known.incumbent));
    put("bound-now", text(known.bound));
    put("gap", known.gap_words);
    const built = phase === "timetable" ? `${Math.round(100 * work.built)} %` : null;
    put("elapsed", phase === "idle" ? NOTHING : built ?? `${work.elapsed_s.toFixed(1)} s`);
    put("said", phase === "failed" ? "" : work.said);
    box("plan").textContent = runs ? "Plan anew" : "Plan";
    box("stop").disabled = !runs || stopping;
    document.documentElement.dataset.phase = phase;
    drawChart();
  }

  // ---- All of it --------------------------------------------------------------------------------

  function showReport() {
    const number = state.plan?.number ?? 0;
    if (number === reported) return;
    reported = number;
    // Another frame each time, so that the way back in the browser leads out of the page. It runs
    // scripts of its own, and has no way to those of this page.
    const frame = document.createElement("iframe");
    frame.title = "Report of the plan";
    frame.setAttribute("sandbox", "allow-scripts allow-downloads");
    frame.src = `/report?plan=${number}`;
    frame.addEventListener("load", () => {
      document.documentElement.dataset.reported = String(number);
    });
    box("view").replaceChildren(frame);
  }

  function show() {
    if (!state) return;
    document.title = `${state.name} · adr-opt`;
    put("name", state.name);
    put("folder", `Kept in ${state.folder}`);
    if (state.trouble) complain(state.trouble);
    for (const [name, what] of [["undo", state.undoes], ["redo", state.redoes]]) {
      const word = name === "undo" ? "Undo" : "Redo";
      box(name).disabled = what === null;
      box(name).title = what === null ? "" : `${word}: ${what}`;
      box(name).setAttribute("aria-label", what === null ? word : `${word}: ${what}`);
    }
    const stale = Boolean(state.plan) && !state.plan.fits;
    box("stale").hidden = !stale;
    put("stale", stale ? "Edited since: the report is of the plan before the edits." : "");
    showLimits();
    showTargets();
    showReport();
    if (work) showWork();
    document.documentElement.dataset.revision = String(state.revision);
  }

  function listen() {
    const told = new EventSource("/events");
    let lost = false;
    told.addEventListener("state", (event) => {
      state = JSON.parse(event.data);
      show();
    });
    told.addEventListener("work", (event) => {
      const before = work;
      work = JSON.parse(event.data);
      showWork();
      if (work.phase === "failed" && before && before.phase !== "failed") complain(work.said);
    });
    told.addEventListener("open", () => {
      if (lost) complain("");
      lost = false;
    });
    told.addEventListener("error", () => {
      lost = true;
      complain("adr-opt serve does not answer; is it still running?");
    });

    box("plan").addEventListener("click", plan);
    for (const name of ["stop", "undo", "redo"]) {
      box(name).addEventListener("click", () => send(`/${name}`));
    }
    box("filter").addEventListener("input", () => state && showTargets());
    box("kind").addEventListener("change", () => state && showTargets());
    const all = (changes) => edit({ targets: { names: shown, ...changes } });
    box("exclude-shown").addEventListener("click", () => all({ excluded: true }));
    box("include-shown").addEventListener("click", () => all({ excluded: false }));
    box("set-shown").addEventListener("click", () => {
      if (box("prize-shown").value !== "") all({ prize: Number(box("prize-shown").value) });
      else complain("a prize of all shown: give a number first");
    });
    for (const name of ["desk", "report"]) {
      box(`to-${name}`).addEventListener("click", () => {
        document.body.classList.toggle("at-report", name === "report");
        for (const other of ["desk", "report"]) {
          box(`to-${other}`).setAttribute("aria-pressed", String(other === name));
        }
        drawChart();
      });
    }
    addEventListener("resize", drawChart);
    document.addEventListener("keydown", (event) => {
      const command = event.ctrlKey || event.metaKey;
      const key = event.key.toLowerCase();
      // What is being typed has an undo of its own.
      const typing = event.target.matches?.("input:not([type=checkbox], [type=range])");
      if (command && key === "enter") {
        event.target.blur(); // what is typed counts
        setTimeout(() => box("plan").click(), 50);
      } else if (key === "escape" && !box("stop").disabled) box("stop").click();
      else if (command && !typing && key === "z") box(event.shiftKey ? "redo" : "undo").click();
      else if (command && !typing && key === "y") box("redo").click();
      else return;
      event.preventDefault();
    });
  }

  (async () => {
    try {
      const offered = await (await fetch("/choices")).json();
      box("method").append(...offered.methods.map((each) => new Option(each, each)));
      box("method").value = offered.method;
      box("bound").append(new Option("none", ""),
        ...offered.bounds.map((each) => new Option(each, each)));
      box("limit").value = text(offered.time_limit_s);
    } catch {
      complain("adr-opt serve does not answer; is it still running?");
    }
    listen();
  })();
})();
