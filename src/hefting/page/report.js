"use strict";
// Unpacks plotly, draws the figures in the reader's colour scheme, and lets a controller
// be chosen and texts be copied. Nothing is asked of a network.
const read = (id) => JSON.parse(document.getElementById(id).textContent);
const palettes = read("palettes");
const dark = window.matchMedia("(prefers-color-scheme: dark)");

// "@name" becomes the colour of that name.
function coloured(value, palette) {
  if (typeof value === "string") return value[0] === "@" ? palette[value.slice(1)] : value;
  if (Array.isArray(value)) return value.map((each) => coloured(each, palette));
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, coloured(v, palette)]));
  return value;
}

async function unpack(id) {
  const packed = atob(document.getElementById(id).textContent.trim());
  const bytes = Uint8Array.from(packed, (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

function run(source) {
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
}

const base = {
  paper_bgcolor: "@paper", plot_bgcolor: "@paper", font: { color: "@ink", size: 13, family: "system-ui, sans-serif" },
  margin: { l: 8, r: 12, t: 8, b: 8 }, hoverlabel: { bgcolor: "@soft", font: { color: "@ink" } },
};
// no bar of buttons: it covers legends, and one of them leads to a network
const config = { displayModeBar: false, responsive: true };
// a finger on a curve scrolls the page
const touched = window.matchMedia("(pointer: coarse)").matches;

// A narrow screen sees the whole scene from farther away.
function stepBack(eye, width) {
  const times = Math.min(Math.max(600 / width, 1), 1.8);
  for (const name of ["x", "y", "z"]) eye[name] *= times;
}

function draw(figures) {
  const palette = dark.matches ? palettes.dark : palettes.light;
  return Promise.all(figures.map((figure) => {
    const place = document.getElementById("figure-" + figure.name);
    const layout = coloured({ ...base, ...figure.layout, height: figure.height }, palette);
    if (touched && !layout.scene) layout.dragmode = false;
    const seen = place.layout && place.layout.scene && place.layout.scene.camera;
    if (seen) layout.scene.camera = seen;
    else if (layout.scene) stepBack(layout.scene.camera.eye, place.clientWidth);
    return Plotly.react(place, coloured(figure.traces, palette), layout, config);
  }));
}

function copy(button) {
  const source = document.getElementById(button.dataset.copy);
  const shown = source.querySelector("div:not([hidden]) > pre") || source;
  const done = () => { button.textContent = "Copied"; setTimeout(() => { button.textContent = "Copy"; }, 1500); };
  const select = () => { getSelection().selectAllChildren(shown); };
  if (navigator.clipboard) navigator.clipboard.writeText(shown.textContent).then(done, select);
  else select();
}

function choose(select) {
  for (const each of document.querySelectorAll("#controller-texts > div"))
    each.hidden = each.dataset.target !== select.value;
}

for (const button of document.querySelectorAll("button[data-copy]")) button.addEventListener("click", () => copy(button));
const select = document.getElementById("controller");
if (select) { select.addEventListener("change", () => choose(select)); choose(select); }

async function main() {
  const figures = read("figures");
  if (figures.length) {
    run(await unpack("plotly"));
    await draw(figures);
    dark.addEventListener("change", () => draw(figures));
  }
  document.body.dataset.drawn = figures.length;
}
main();
