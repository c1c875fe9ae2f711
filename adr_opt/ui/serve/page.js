// The page of `serve`: rooms that follow what the server tells, each in its part of the page.
import * as captures from "./script/captures.js";
import * as choose from "./script/choose.js";
import * as drop from "./script/drop.js";
import * as frame from "./script/frame.js";
import * as header from "./script/header.js";
import * as jobs from "./script/jobs.js";
import * as keys from "./script/keys.js";
import * as limits from "./script/limits.js";
import * as object from "./script/object.js";
import * as objects from "./script/objects.js";
import * as parts from "./script/parts.js";
import * as planning from "./script/planning.js";
import * as replan from "./script/replan.js";
import * as results from "./script/results.js";
import { follow } from "./script/store.js";
import { learn, listen } from "./script/talk.js";
import * as targets from "./script/targets.js";
import * as verbs from "./script/verbs.js";
import * as views from "./script/views.js";

// The token stands in a cookie now; an address that is copied or bookmarked need not have it.
if (location.search) history.replaceState(null, "", "/");

const rooms = [
  views, header, drop, choose, objects, limits, targets, parts, planning, replan, results, verbs, jobs,
  frame, keys, object, captures,
];
for (const room of rooms) room.start();
views.onView((view) => {
  if (view === "objects") objects.fitPlots();
});
follow("state", (state) => {
  document.documentElement.dataset.revision = String(state.revision);
});
await learn();
listen();
