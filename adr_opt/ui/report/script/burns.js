// The burns as a file for spreadsheets, made where it is asked for.
const quoted = (value) => {
  const text = value === null ? "" : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
};

function burnsFile() {
  const { columns, rows, legs } = mission.burns;
  const lines = rows.map(([of, leg, phase, seconds, x, y, z, ...local]) => [
    of, plain(legs[leg - 1][0]), leg, ...legs[leg - 1].slice(1).map(plain), phase, seconds,
    new Date(mission.epoch_ms + 1000 * seconds).toISOString(), Math.hypot(x, y, z), x, y, z,
    ...local,
  ]);
  return [columns, ...lines].map((line) => `${line.map(quoted).join(",")}\r\n`).join("");
}

function listenToBurns() {
  box("csv")?.addEventListener("click", () => offer(burnsFile(), "text/csv", "burns.csv"));
}
