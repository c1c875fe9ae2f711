function traces(name) {
  return figures[name].data.map((trace) => {
    const phase = trace.meta?.phase;
    let shown = trace;
    if (chosen && name === "planes" && trace.mode === "lines") {
      // from where the leg begins to where it ends
      const at = trace.customdata.indexOf(chosen);
      const keep = (values) => values.slice(Math.max(0, at - 1), at + 1);
      shown = {
        ...trace, x: at < 0 ? [] : keep(trace.x), y: at < 0 ? [] : keep(trace.y), opacity: 1,
        line: { ...trace.line, width: 3 },
      };
    }
    return hidden.has(phase) ? { ...shown, visible: false } : shown;
  });
}

function draw(name) {
  const made = layout(name);
  drawn.add(name);
  return Plotly.react(box(name), traces(name), made, config).then(madeReachable);
}

// What depends on the time is made anew where it is seen.
const drawAgain = (wanted = [...drawn]) =>
  Promise.all(wanted.filter((name) => drawn.has(name) && !derived.has(name)).map(draw)).then(show);

