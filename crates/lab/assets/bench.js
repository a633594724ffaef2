// Moves, recordings and their results.

import { fill } from "./controls.js";
import { wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
let chosen = new Set();
let listed = "";
let reported = null;

/** Opens a report beside the scope. */
export function beside(name) {
  const address = `/reports/${encodeURIComponent(name)}`;
  $("beside").querySelector("h2").textContent = name;
  $("beside").querySelector("a").href = address;
  $("beside").querySelector("iframe").src = address;
  $("beside").hidden = false;
}

function link(name, says) {
  const a = document.createElement("a");
  a.href = `/recordings/${encodeURIComponent(name)}`;
  a.download = name;
  a.textContent = says;
  return a;
}

function cell(content, number) {
  const td = document.createElement("td");
  if (number) td.className = "n";
  td.append(content);
  return td;
}

function recordings(list) {
  const text = JSON.stringify(list);
  if (text === listed) return;
  // the newest recording is the default
  if (list.length && !listed.includes(list[0].name)) chosen = new Set([list[0].name]);
  listed = text;
  $("recordings").tBodies[0].replaceChildren(...list.map(({ name, seconds, lost }) => {
    const tr = document.createElement("tr");
    const box = document.createElement("input");
    Object.assign(box, { type: "checkbox", checked: chosen.has(name), name });
    box.setAttribute("aria-label", `use ${name}`);
    box.addEventListener("change", () => { if (box.checked) chosen.add(name); else chosen.delete(name); buttons(); });
    const links = document.createElement("span");
    links.append(link(name, "CSV"), " ", link(name.replace(".csv", ".mcap"), "MCAP"));
    tr.append(cell(box), cell(name), cell(seconds.toFixed(2), true), cell(`${lost}`, true), cell(links));
    return tr;
  }));
  buttons();
}

let busy = false;
function buttons() {
  $("identify").disabled = $("diagnose").disabled = busy || !chosen.size;
}

function done(result) {
  $("done").hidden = !result;
  if (!result) return;
  $("done").querySelector("h3").textContent = result.failed ? `${result.kind}: not done` : `${result.kind} ${result.of}`;
  $("done").querySelector("pre").textContent = result.text;
  const bar = $("done").querySelector(".bar");
  const key = JSON.stringify(result);
  if (bar.dataset.key === key) return;
  bar.dataset.key = key;
  bar.replaceChildren();
  const button = (says, then) => {
    const b = document.createElement("button");
    b.type = "button";
    b.textContent = says;
    b.addEventListener("click", then);
    bar.append(b);
  };
  if (result.report) button("Open the report", () => beside(result.report));
  for (const table of result.tables) bar.append(link(table, table.replace(/^.*?-(?=[a-z_]+\.csv$)/, "")));
  if (result.preset.length) button("Render the result", () => fill(result.preset));
}

export function state(known) {
  busy = Boolean(known.job);
  $("record").setAttribute("aria-pressed", known.recording !== null);
  $("record").querySelector("span").textContent = known.recording === null ? "Record" : `End (${(known.recording * known.period).toFixed(1)} s)`;
  recordings(known.recordings);
  buttons();
  $("results").hidden = !known.job && !known.done;
  $("job").hidden = !known.job;
  if (known.job) {
    $("job").querySelector("progress").value = known.job.share;
    $("job").querySelector("span").textContent = `${known.job.kind} ${known.job.of}: ${known.job.says}`;
  }
  done(known.done);
  // a report that arrives while this page is open is shown once; that of a handover would lie on its next button
  const report = known.done?.report ?? null;
  const handed = report !== null && report === known.handover.report;
  if (reported !== null && report && !handed && report + known.done.text !== reported) beside(report);
  reported = report ? report + known.done.text : "";
  $("block").hidden = $("hand-bar").hidden = !known.sim;
  const material = $("block").querySelector("select");
  if (material !== document.activeElement) material.value = known.block;
}

export function start() {
  $("record").addEventListener("click", () => wire.ask({ do: $("record").getAttribute("aria-pressed") === "true" ? "record_end" : "record" }));
  for (const kind of ["identify", "diagnose"]) $(kind).addEventListener("click", () => wire.ask({ do: kind, recordings: [...chosen] }));
  $("excite").addEventListener("submit", (event) => {
    event.preventDefault();
    const { wave, amplitude, frequency, seconds } = event.target.elements;
    const how = event.submitter?.value ?? "drive";
    const number = (field, scale) => +(Number(field.value.replace(",", ".")) * scale).toPrecision(9);
    const ask = { do: "move", wave: wave.value, amplitude: number(amplitude, 1e-3), frequency: number(frequency, 1), seconds: number(seconds, 1), record: how !== "drive", identify: how === "identify" };
    if ([ask.amplitude, ask.frequency, ask.seconds].every(Number.isFinite)) wire.ask(ask);
    else [amplitude, frequency, seconds].find((field) => !Number.isFinite(number(field, 1)))?.focus();
  });
  $("block").querySelector("select").addEventListener("change", (event) => wire.ask({ do: "block", name: event.target.value }));
  $("hand-sine").addEventListener("click", (event) => {
    const on = event.target.getAttribute("aria-pressed") !== "true";
    event.target.setAttribute("aria-pressed", on);
    event.target.textContent = on ? "Hand off" : "Move by a simulated hand";
    wire.ask(on ? { do: "hand_sine", amplitude: 0.008, frequency: 0.5 } : { do: "hand", at: null });
  });
  $("beside").querySelector("button").addEventListener("click", () => { $("beside").hidden = true; $("beside").querySelector("iframe").src = "about:blank"; });
}
