// The experiments in full screen. The server decides the next trial and its stimulus.

import { resume } from "./plane.js";
import { css } from "./scope.js";
import { wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
const OWN = `[[batch]]
name = "my batch"
[batch.reference]
f_static = 2.0
f_dynamic = 2.0
damping = 20.0
dv = 0.001
mass = 0.5
k_vc = 25000
b_vc = 10
[batch.procedure]
procedure = "adaptive"   # or "constant", with comparisons = [ … ] and rounds
varied = "both_up"       # static_up, both_down
range_n = [0.02, 4.0]
trials = 40
enough = 2.0
`;

let now = null;
let known = null;
let ring = null;
let drawn = "";
let target = null;
let sent = null;
let thesis = false;
/** Newest sample when something was pressed: from motion to pixel, for whoever measures. */
export const stage = { frames: 0 };

function sessions(list) {
  const table = $("sessions");
  const key = JSON.stringify(list);
  if (table.dataset.key === key) return;
  table.dataset.key = key;
  table.hidden = !list.length;
  table.tBodies[0].replaceChildren(...list.map(({ name, kind, subject, done, of }) => {
    const tr = document.createElement("tr");
    const a = document.createElement("a");
    a.href = `/recordings/${encodeURIComponent(name)}`;
    a.download = name;
    a.textContent = name.replace(".jsonl", "");
    const box = document.createElement("input");
    Object.assign(box, { type: "checkbox", checked: done > 0, value: name });
    box.setAttribute("aria-label", `analyse ${name}`);
    box.addEventListener("change", chosen);
    const cells = [box, a, subject, `${done} of ${of}`].map((content, k) => {
      const td = document.createElement("td");
      if (k === 3) td.className = "n";
      td.append(content);
      return td;
    });
    const last = document.createElement("td");
    if (done < of) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = "Go on";
      button.addEventListener("click", () => { if (kind === "plane") return resume(name); fullScreen(); wire.ask({ do: "resume", name }); });
      last.append(button);
    }
    tr.append(...cells, last);
    return tr;
  }));
  chosen();
}

/** Sessions that are to be analysed. */
function chosen() {
  const names = [...$("sessions").querySelectorAll("input:checked")].map((box) => box.value);
  $("analyse").disabled = !names.length || Boolean(known?.job);
  return names;
}

function fullScreen() {
  // rejected without a gesture or in a frame; the stage still fills the window
  document.documentElement.requestFullscreen?.().catch(() => {});
}

function button(says, key, then, main) {
  const b = document.createElement("button");
  b.type = "button";
  b.dataset.key = key;
  b.className = main ? "main" : "";
  b.append(says, " ");
  const hint = document.createElement("kbd");
  hint.textContent = key;
  b.append(hint);
  b.addEventListener("click", then);
  return b;
}

/** What can be done now; the first is what Enter does. */
function actions() {
  if (!now || now.complete) return [["Close", "Enter", leave]];
  if (!known.connected || known.fault) return known.fault ? [["Clear the fault", "Enter", () => wire.ask({ do: "clear" })]] : [];
  const ready = () => wire.ask({ do: "ready" });
  if (!now.armed) return [["Arm the handle", "Enter", ready]];
  if (!now.running) return [["Start", "Enter", ready]];
  if (now.targets) return [["Click", "Enter", click]];
  const next = ["Next", "Enter", () => wire.ask({ do: "advance" })];
  if (!now.cases.may_answer) return [next];
  return [next, ["A differs", "A", () => answer("A")], ["B differs", "B", () => answer("B")]];
}

function click() { wire.ask({ do: "click" }); }
function answer(which) { wire.ask({ do: "answer", answer: which }); }
function leave() {
  wire.ask({ do: "leave" });
  if (document.fullscreenElement) document.exitFullscreen();
}

export function state(next) {
  known = next;
  const opened = next.experiment && !now;
  now = next.experiment;
  sessions(next.sessions);
  chosen();
  $("stage").hidden = !now;
  // the page behind cannot be reached by tab
  for (const behind of document.querySelectorAll("body > header, body > main")) behind.inert = Boolean(now);
  if (!now) { target = sent = null; return; }
  $("stage-title").textContent = now.targets ? (now.targets.practice ? "Targeting, practice" : "Targeting") : now.cases ? "Which one differs from the baseline?" : "Done";
  $("stage-progress").textContent = `${Math.min(now.done + 1, now.of)} of ${now.of}`;
  $("stage-last").textContent = now.last;
  $("stage-waits").textContent = known.connected ? now.waits : `${known.unheard ? "The lab does not answer" : `The device is gone: ${known.absent}`}. Finished trials are kept; this one starts again.`;
  $("stage-fault").hidden = !known.fault;
  if (known.fault) $("stage-fault").textContent = `Force is off. ${known.fault.says}.`;
  const cases = $("stage-cases");
  cases.hidden = !now.cases || now.complete;
  for (const box of cases.children) {
    const on = now.running && box.dataset.case === now.cases?.case;
    box.classList.toggle("now", on);
    if (on) box.setAttribute("aria-current", "true"); else box.removeAttribute("aria-current");
  }
  const list = actions();
  const key = list.map(([says]) => says).join();
  if ($("stage-buttons").dataset.key !== key) {
    $("stage-buttons").dataset.key = key;
    $("stage-buttons").replaceChildren(...list.map(([says, key_, then], k) => button(says, key_, then, k === 0)));
  }
  drawn = "";
  if (opened) $("stage-canvas").focus();
}

/** Once a frame. */
export function draw() {
  if (!now) return;
  if (target !== null && target !== sent && wire.ask({ do: "hand", at: target })) sent = target;
  const canvas = $("stage-canvas");
  const at = ring.end ? ring.at("position", ring.end - 1) : 0;
  const width = canvas.clientWidth, height = canvas.clientHeight, ratio = devicePixelRatio;
  const key = `${at},${width},${height}`;
  if (key === drawn) return;
  drawn = key;
  stage.frames++;
  stage.newest = ring.newest;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const per = metre(width);
  const x = (m) => 0.5 * width + m / per;
  const middle = 0.5 * height;
  pen.strokeStyle = css("line");
  pen.lineWidth = 1;
  pen.beginPath(); pen.moveTo(x(-known.reach), middle); pen.lineTo(x(known.reach), middle); pen.stroke();
  if (now.targets) {
    const { distance_px, width_px, cursor_px, metre_per_px, side } = now.targets;
    const wide = ((width_px + cursor_px) * metre_per_px) / per, tall = Math.min(0.7 * height, 300);
    for (const end of [-1, 1]) {
      const centre = x(0.5 * end * distance_px * metre_per_px), next = end === side;
      const colour = thesis ? (next ? "#1a9641" : "#d7191c") : css(next ? "accent" : "quiet");
      pen.fillStyle = pen.strokeStyle = colour;
      pen.lineWidth = 2;
      if (next || thesis) { pen.globalAlpha = next ? 1 : 0.55; pen.fillRect(centre - wide / 2, middle - tall / 2, wide, tall); pen.globalAlpha = 1; }
      else pen.strokeRect(centre - wide / 2 + 1, middle - tall / 2 + 1, Math.max(1, wide - 2), tall - 2);
    }
    // the cursor has the width of the task, and is easy to see
    const half = (0.5 * cursor_px * metre_per_px) / per;
    pen.fillStyle = css("force");
    pen.strokeStyle = css("sheet");
    pen.lineWidth = 1.5;
    pen.beginPath(); pen.arc(x(at), middle, Math.max(2, half), 0, 7); pen.fill(); pen.stroke();
    pen.fillStyle = css("force");
    pen.beginPath(); pen.moveTo(x(at), middle + half + 6); pen.lineTo(x(at) - 6, middle + half + 18); pen.lineTo(x(at) + 6, middle + half + 18); pen.fill();
    pen.fillStyle = css("quiet");
    pen.font = "15px system-ui";
    pen.textAlign = "center";
    if (now.running) pen.fillText(`${now.targets.valid} of ${now.targets.clicks}`, 0.5 * width, 28);
  } else if (now.cases) {
    pen.fillStyle = css("force");
    pen.beginPath(); pen.arc(x(at), middle, 12, 0, 7); pen.fill();
  }
}

/** m of a CSS pixel: the whole stroke is on the screen. */
function metre(width) { return (2.1 * known.reach) / width; }

/** Enter is the button; A and B name a case. Escape and space have stopped everything before. */
function key(event) {
  if (!now || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  const wanted = event.key === "Enter" ? "Enter" : event.key.toUpperCase();
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (step && known.sim) {
    target = hand((target ?? ring.at("position", ring.end - 1)) + step * 0.5e-3);
    return event.preventDefault();
  }
  if (event.target instanceof HTMLButtonElement && event.key === "Enter") return; // the button handles it
  const action = actions().find(([, k]) => k === wanted);
  if (!action) return;
  event.preventDefault();
  action[2]();
}

const hand = (m) => Math.max(-known.reach + 0.5e-3, Math.min(known.reach - 0.5e-3, m));

export function start(samples) {
  ring = samples;
  const canvas = $("stage-canvas");
  canvas.tabIndex = -1;
  // on the virtual device the pointer is the hand; a press is always the button
  canvas.addEventListener("pointermove", (event) => {
    if (!known?.sim || !now?.armed) return;
    const { left, width } = canvas.getBoundingClientRect();
    target = hand((event.clientX - left - 0.5 * width) * metre(width));
  });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button === 0 && event.pointerType !== "touch" && now?.running && now.targets) click();
  });
  addEventListener("keydown", key);
  $("leave").addEventListener("click", leave);
  $("analyse").addEventListener("click", () => wire.ask({ do: "analyse", sessions: chosen() }));
  $("begin").elements.batches.addEventListener("change", (event) => {
    const own = $("begin").elements.own;
    own.hidden = event.target.value !== "own";
    own.value ||= OWN;
  });
  $("begin").addEventListener("submit", (event) => {
    event.preventDefault();
    const { subject, seed, practice, batches, own } = event.target.elements;
    thesis = event.target.elements["thesis-colours"].checked;
    const ask = { subject: subject.value.trim(), seed: Number(seed.value) };
    fullScreen();
    if (event.submitter?.value === "choice") wire.ask({ do: "begin_choice", ...ask, batches: batches.value === "own" ? own.value : batches.value });
    else wire.ask({ do: "begin_targeting", ...ask, practice: practice.checked });
  });
}
