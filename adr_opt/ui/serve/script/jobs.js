// Jobs of the server: a bar for each, and a button that stops it.
import { box, button, counted, made, placed, put } from "./dom.js";
import { follow } from "./store.js";
import { complain, send } from "./talk.js";

const OVER = 3; // jobs that are over and still listed
const rows = new Map();

function rowOf(job) {
  if (rows.has(job.id)) return rows.get(job.id);
  const title = made("b", {}, job.label || job.verb);
  const bar = made("progress", { max: "1", "aria-label": `Progress of ${job.label || job.verb}` });
  const stop = button("Stop", () => send("/jobs/stop", { job: job.id }),
    { "aria-label": `Stop ${job.label || job.verb}` });
  const said = made("span", { class: "said" });
  const row = made("li", { class: "job" }, title, stop, bar, said);
  rows.set(job.id, { row, bar, stop, said });
  return rows.get(job.id);
}

const ends = ({ state }) => !["waiting", "running"].includes(state);

function show(jobs, before) {
  const over = jobs.filter(ends).slice(-OVER);
  const listed = jobs.filter((job) => !ends(job) || over.includes(job)).reverse();
  for (const job of listed) {
    const { row, bar, stop, said } = rowOf(job);
    row.dataset.state = job.state;
    row.classList.toggle("ended", ends(job));
    stop.hidden = bar.hidden = ends(job);
    if (job.share === null || job.state === "waiting") bar.removeAttribute("value");
    else bar.value = job.share;
    const time = job.elapsed_s ? `, ${job.elapsed_s.toFixed(job.elapsed_s < 10 ? 1 : 0)} s` : "";
    put(said, ends(job) && job.said ? `${job.state}: ${job.said}${time}`
      : `${job.state}${time}${job.said ? `: ${job.said}` : ""}`);
  }
  placed(box("jobs"), listed.map((job) => rowOf(job).row));
  const running = jobs.filter((job) => !ends(job)).length;
  box("with-jobs").hidden = !listed.length;
  put("jobs-said", running ? `${counted(running, "job")} at work` : "");
  document.documentElement.dataset.jobs = String(running);
  for (const job of jobs) {
    const was = before?.find(({ id }) => id === job.id);
    if (job.state === "failed" && was && !ends(was)) complain(`${job.label || job.verb}: ${job.said}`);
  }
}

export function start() {
  follow("jobs", show);
}
