// All charts as pictures for slides, in one file.
const SLIDE = { format: "png", width: 960, scale: 2 }; // 1920 pixels wide
const HEIGHT = 540;
const MARGIN = { l: 24, r: 24, t: 24, b: 16 };

// The phases, which the page names with its buttons, are in the legend of the picture.
function legended(data) {
  const named = new Set();
  return data.map((trace) => {
    const phase = trace.meta?.phase;
    const button = phase && document.querySelector(`button[data-phase="${phase}"]`);
    if (!button || button.textContent !== trace.name || trace.visible === false) return trace;
    const first = !named.has(phase);
    named.add(phase);
    return { ...trace, showlegend: first, legendgroup: phase };
  });
}

async function picture(name) {
  if (name === "orbits") return globePicture(SLIDE.width, HEIGHT);
  const { data, layout: shown } = box(name);
  const traced = legended(data);
  const taken = {
    ...shown, paper_bgcolor: colour("card"), width: undefined, height: undefined,
    margin: shown.scene ? shown.margin : MARGIN,
    xaxis: { ...shown.xaxis, title: { ...shown.xaxis.title, text: figures[name].layout.xaxis.title?.text } },
    showlegend: shown.showlegend || traced.some(({ legendgroup }) => legendgroup),
  };
  const height = name === "ground" ? SLIDE.width / 2 : Math.max(HEIGHT, shown.height ?? 0);
  const address = await Plotly.toImage({ data: traced, layout: taken }, { ...SLIDE, height });
  return Uint8Array.from(atob(address.split(",")[1]), (letter) => letter.charCodeAt(0));
}

async function pictureFiles(told) {
  for (const { chart, show: view } of views) if (chart) await view();
  const names = [...document.querySelectorAll(".chart")].map(({ id }) => id)
    .filter((name) => name === "orbits" || box(name).data?.length);
  const files = [];
  for (const name of names) {
    told(files.length + 1, names.length);
    files.push({
      name: `${String(files.length + 1).padStart(2, "0")}-${name}.png`, bytes: await picture(name),
    });
    await pause();
  }
  return files;
}

function listenToPictures() {
  const button = box("pictures");
  const title = button.textContent;
  button.addEventListener("click", async () => {
    button.disabled = true;
    try {
      const files = await pictureFiles((at, count) => {
        button.textContent = `Drawing ${at} of ${count} …`;
      });
      offer(archive(files), "application/zip", "pictures.zip");
    } finally {
      button.textContent = title;
      button.disabled = false;
    }
  });
}
