// The stream of events, one for all tabs: a browser opens six connections to a host at most, and a
// stream keeps one. A shared worker, named after the server, so that a restarted one has another.
// Tabs that nobody sees are told nothing; while all are hidden, no stream is open.
const PAUSES_MS = [250, 500, 1000]; // before the server is asked once more
const CALM_MS = 60000; // a stream that has lasted so long had begun well
const REFUSED = [403, 409]; // by a server that was started since

const tabs = new Set(); // ports of those that listen
const latest = new Map(); // what was told last of each kind, for tabs that come later
let stream = null; // ends the stream that is open

function tell(kind, content) {
  if (kind !== "work") latest.delete("trouble");
  latest.set(kind, content);
  for (const port of tabs) port.postMessage([kind, content]);
}

async function read(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const blocks = (rest + value).split("\n\n");
    rest = blocks.pop();
    for (const block of blocks) {
      const event = /^event: (\w+)\ndata: (.*)$/.exec(block); // or a sign of life
      if (event) tell(event[1], event[2]);
    }
  }
}

// Why the stream has ended for good; empty where nobody listens any more.
async function ending(signal) {
  for (let tries = 0; ; tries += 1) {
    const began = Date.now();
    try {
      const answer = await fetch("/events", { headers: { "Adr-Opt-Server": self.name }, signal });
      if (REFUSED.includes(answer.status)) return "restarted";
      if (answer.ok) await read(answer.body);
    } catch {
      // Broken off, or not reached: counted below.
    }
    if (signal.aborted) return "";
    if (Date.now() - began > CALM_MS) tries = 0;
    if (tries === PAUSES_MS.length) return "lost";
    await new Promise((done) => { setTimeout(done, PAUSES_MS[tries]); });
    if (signal.aborted) return "";
  }
}

function close() {
  stream.abort();
  stream = null;
  latest.clear();
}

async function open() {
  stream = new AbortController();
  const why = await ending(stream.signal);
  if (!why) return;
  for (const port of tabs) port.postMessage(["over", why]);
  tabs.clear();
  close();
}

self.onconnect = ({ ports: [port] }) => {
  port.onmessage = ({ data: listens }) => {
    if (!listens) tabs.delete(port);
    else if (!tabs.has(port)) {
      tabs.add(port);
      for (const each of latest) port.postMessage(each);
    }
    if (tabs.size && !stream) open();
    if (!tabs.size && stream) close();
  };
};
