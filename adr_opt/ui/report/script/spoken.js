// The moment as a text that is spoken: once the slider rests, and while time is played when a leg or
// a phase begins, but not more often than a listener can follow.
const RESTS_MS = 800;
const PLAYED_MS = 10000;
const tellers = []; // what else is said of the moment: functions that give a sentence
const stages = []; // what must change for it to be said while time is played
let spoken = { at: 0, stage: "" };
let resting = null;

function speak() {
  const legs = legsAt(time).map(called).join("; ");
  const sentences = [`${clock(time)}, ${calendar(time)}`, legs ? `leg ${legs}` : "no leg is flown"];
  spoken = { at: performance.now(), stage: stages.map((stage) => stage()).join() };
  box("spoken").textContent = `${[...sentences, ...tellers.map((tell) => tell())].join(". ")}.`;
}

function speakLater() {
  clearTimeout(resting);
  if (playing === null) {
    resting = setTimeout(speak, RESTS_MS);
    return;
  }
  if (performance.now() - spoken.at < PLAYED_MS) return;
  if (stages.map((stage) => stage()).join() !== spoken.stage) speak();
}

stages.push(() => legsAt(time).join("+"));
