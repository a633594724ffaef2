// The planar handle: a puck that the pointer pulls over a surface, and the targeting task on a circle. Every force is the server's.

import { css } from "./scope.js";
import { wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
/** m of an arrow key; with Shift five times as much. */
const KEY_STEP = 1e-3;
/** Steps kept: half a minute. */
const KEPT = 30_000;
/** Steps of the trail that is drawn: two seconds. */
const TRAIL = 2000;
/** Stick spots that are drawn. */
const SPOTS = 60;

/** What the server said, and every step of the puck: [time, [hand, puck, pull, friction], stuck]. */
export const plane = { shown: null, rows: [], work: null, spots: [], target: null };
let sent = null;
let visible = false;
let dirty = true;

const ask = (what, more = {}) => wire.ask({ do: "plane", ask: { what, ...more } });
const surface = () => plane.shown?.surfaces.find(({ name }) => name === plane.shown.surface);

/** CSS pixels of a metre, and the middle of the canvas. */
function scale() {
  const { clientWidth: width, clientHeight: height } = $("plane-canvas");
  const [x, y] = plane.shown.reach;
  const per = Math.min(width / (2.12 * x), height / (2.16 * y));
  return { per, x: (m) => 0.5 * width + m * per, y: (m) => 0.5 * height - m * per, width, height };
}

/** Place of an event, m. */
function place(event) {
  const { left, top } = $("plane-canvas").getBoundingClientRect();
  const { per, width, height } = scale();
  return inside([(event.clientX - left - 0.5 * width) / per, (0.5 * height - event.clientY + top) / per]);
}

function inside([x, y]) {
  const [most, tall] = plane.shown.reach;
  return [Math.max(-most, Math.min(most, x)), Math.max(-tall, Math.min(tall, y))];
}

function letGo() {
  if (plane.target) ask("hand", { at: null });
  plane.target = sent = null;
  dirty = true;
}

/** The plane is shown instead of the scope, or hidden. */
export function show(on) {
  if (on === visible) return;
  visible = on;
  $("plane").hidden = !on;
  $("scope").hidden = on;
  letGo();
  ask(on ? "open" : "close");
}

function shown(now) {
  const before = plane.shown;
  plane.shown = now;
  dirty = true;
  if (before?.surface !== now.surface) plane.spots = [];
  const list = $("surfaces");
  if (!list.childElementCount) {
    list.replaceChildren(...now.surfaces.map(({ name }) => {
      const button = document.createElement("button");
      Object.assign(button, { type: "button", textContent: name });
      button.dataset.name = name;
      button.addEventListener("click", () => ask("surface", { name }));
      return button;
    }));
  }
  for (const button of list.children) {
    button.setAttribute("aria-pressed", button.dataset.name === now.surface);
    button.disabled = Boolean(now.circle) && button.dataset.name !== now.surface;
  }
  $("surface-says").textContent = `${surface().says}.`;
  task(now);
}

function task({ circle, scores }) {
  $("ring-begin").hidden = Boolean(circle);
  $("ring-now").hidden = !circle;
  if (circle) {
    const over = circle.done === circle.of;
    $("ring-progress").textContent = over ? "That was the last circle. Thank you." : `Circle ${circle.done + 1} of ${circle.of}`;
    $("ring-last").textContent = over ? "" : circle.selections ? `${circle.selections} of ${circle.targets.length + 1}: ${circle.last}` : "Select the marked target to begin.";
    $("ring-file").href = `/recordings/${encodeURIComponent(circle.name)}.jsonl`;
    $("ring-file").download = `${circle.name}.jsonl`;
    $("ring-leave").textContent = over ? "Close" : "Leave";
  }
  $("ring-scores").hidden = !scores.length;
  const number = (value, digits) => (value === null ? "–" : value.toFixed(digits));
  $("ring-scores").tBodies[0].replaceChildren(...scores.map((score) => {
    const tr = document.createElement("tr");
    const cells = [score.surface, score.id_bits.toFixed(2), score.errors, number(score.movement_s, 2), number(score.effective_width_mm, 1), number(score.bits_per_s, 2)];
    tr.append(...cells.map((text, k) => {
      const td = document.createElement("td");
      if (k) td.className = "n";
      td.textContent = text;
      return td;
    }));
    return tr;
  }));
}

function stepped({ rows, work }) {
  plane.work = work;
  for (const row of rows) {
    const stuck = row[2] && plane.rows.length && !plane.rows.at(-1)[2];
    const [, , x, y, fx, fy] = row[1];
    const last = plane.spots.at(-1);
    // it came to rest while it was pulled
    if (stuck && Math.hypot(fx, fy) > 0.05 && !(last && Math.hypot(x - last[0], y - last[1]) < 5e-4)) plane.spots.push([x, y]);
    plane.rows.push(row);
  }
  if (plane.spots.length > SPOTS) plane.spots.splice(0, plane.spots.length - SPOTS);
  if (plane.rows.length > KEPT + 2000) plane.rows.splice(0, plane.rows.length - KEPT);
  dirty = true;
}

function reading([, [, , , , fx, fy, qx, qy], stuck]) {
  const newton = (x, y) => `${Math.hypot(x, y).toFixed(2)} N`;
  $("plane-pull").textContent = newton(fx, fy);
  $("plane-friction").textContent = newton(qx, qy);
  $("plane-state").textContent = !plane.target ? "released" : surface().edge.length ? (stuck ? "sticks" : "slides") : "no friction";
  const mj = (joule) => `${(1e3 * joule).toFixed(1)} mJ`;
  $("plane-work").textContent = mj(plane.work.hand);
  $("plane-lost").textContent = mj(plane.work.friction);
  $("plane-field").textContent = mj(plane.work.field);
  $("plane-rest").textContent = mj(plane.work.coupling);
}

function arrow(pen, [x, y], [dx, dy]) {
  const length = Math.hypot(dx, dy);
  if (length < 2) return;
  const [a, b] = [dx / length, dy / length];
  pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x + dx - 6 * a, y + dy - 6 * b); pen.stroke();
  pen.beginPath(); pen.moveTo(x + dx, y + dy);
  pen.lineTo(x + dx - 11 * a - 5 * b, y + dy - 11 * b + 5 * a); pen.lineTo(x + dx - 11 * a + 5 * b, y + dy - 11 * b - 5 * a);
  pen.fill();
}

function ground(pen, s) {
  const { grain, pitch } = surface();
  const [w, h] = plane.shown.reach;
  const [left, top, width, height] = [s.x(-w), s.y(h), 2 * w * s.per, 2 * h * s.per];
  pen.fillStyle = css("soft");
  pen.fillRect(left, top, width, height);
  pen.save();
  pen.beginPath(); pen.rect(left, top, width, height); pen.clip();
  pen.strokeStyle = pen.fillStyle = css("line");
  pen.lineWidth = 1;
  if (grain !== null) {
    // lines along the grain, 3 mm apart
    const [a, b] = [Math.cos(grain), Math.sin(grain)];
    pen.beginPath();
    for (let d = -0.08; d <= 0.08; d += 0.003) {
      pen.moveTo(s.x(-b * d - 0.1 * a), s.y(a * d - 0.1 * b));
      pen.lineTo(s.x(-b * d + 0.1 * a), s.y(a * d + 0.1 * b));
    }
    pen.stroke();
  }
  if (pitch !== null) {
    const wells = (most) => { const n = Math.floor(most / pitch); return Array.from({ length: 2 * n + 1 }, (_, k) => (k - n) * pitch); };
    for (const x of wells(w)) for (const y of wells(h)) { pen.beginPath(); pen.arc(s.x(x), s.y(y), 0.0015 * s.per, 0, 7); pen.fill(); }
  }
  pen.restore();
}

function targets(pen, s, circle) {
  const at = ([x, y]) => [s.x(x), s.y(y)];
  for (const centre of circle.targets) {
    const next = circle.target && Math.hypot(centre[0] - circle.target[0], centre[1] - circle.target[1]) < 1e-9;
    pen.lineWidth = next ? 3 : 1.5;
    pen.strokeStyle = css(next ? "accent" : "quiet");
    pen.beginPath(); pen.arc(...at(centre), 0.5 * circle.width * s.per, 0, 7); pen.stroke();
    if (next) { pen.globalAlpha = 0.3; pen.fillStyle = css("accent"); pen.fill(); pen.globalAlpha = 1; }
  }
}

/** Once a frame: the newest place of the pointer goes out, the newest step of the puck is drawn. */
export function draw() {
  if (!visible || !plane.shown) return;
  if (plane.target && plane.target !== sent && ask("hand", { at: plane.target })) sent = plane.target;
  const canvas = $("plane-canvas");
  const ratio = devicePixelRatio, [width, height] = [canvas.clientWidth, canvas.clientHeight].map((px) => Math.round(px * ratio));
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; dirty = true; }
  const last = plane.rows.at(-1);
  if (!dirty || !last) return;
  dirty = false;
  const s = scale();
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, s.width, s.height);
  ground(pen, s);
  const [hx, hy, x, y, fx, fy] = last[1];
  const puck = [s.x(x), s.y(y)];
  pen.strokeStyle = css("position");
  pen.lineWidth = 1.5;
  pen.globalAlpha = 0.5;
  pen.beginPath();
  for (let k = Math.max(0, plane.rows.length - TRAIL); k < plane.rows.length; k += 8) pen.lineTo(s.x(plane.rows[k][1][2]), s.y(plane.rows[k][1][3]));
  pen.stroke();
  pen.globalAlpha = 1;
  // in the task what helps to feel would be in the way
  const task = Boolean(plane.shown.circle);
  pen.fillStyle = css("bad");
  if (!task) for (const [a, b] of plane.spots) { pen.beginPath(); pen.arc(s.x(a), s.y(b), 3, 0, 7); pen.fill(); }
  if (plane.shown.circle) targets(pen, s, plane.shown.circle);
  // forces: 4 N are as long as a third of the plane is high
  const newton = s.per * plane.shown.reach[1] / 6;
  const { edge } = surface();
  if (edge.length && !task) {
    pen.strokeStyle = css("ink");
    pen.lineWidth = 1;
    pen.setLineDash([5, 4]);
    pen.beginPath();
    for (const [a, b] of edge) pen.lineTo(puck[0] + a * newton, puck[1] - b * newton);
    pen.closePath(); pen.stroke();
    pen.setLineDash([]);
  }
  if (plane.target) { // the spring between hand and puck
    pen.strokeStyle = css("command");
    pen.lineWidth = 2;
    pen.setLineDash([4, 3]);
    pen.beginPath(); pen.moveTo(...puck); pen.lineTo(s.x(hx), s.y(hy)); pen.stroke();
    pen.setLineDash([]);
    pen.beginPath(); pen.arc(s.x(hx), s.y(hy), 6, 0, 7); pen.stroke();
  }
  pen.fillStyle = css(last[2] && edge.length && plane.target ? "bad" : "position");
  pen.strokeStyle = css("sheet");
  pen.lineWidth = 2;
  // in the task its middle counts
  pen.beginPath(); pen.arc(...puck, task ? 4 : 13, 0, 7); pen.fill(); pen.stroke();
  pen.strokeStyle = pen.fillStyle = css("force");
  pen.lineWidth = 3;
  if (!task) arrow(pen, puck, [fx * newton, -fy * newton]);
  reading(last);
}

function key(event) {
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (event.key === "Enter") { event.preventDefault(); if (!event.repeat) ask("select"); }
  if (event.key === "Home") { event.preventDefault(); letGo(); }
  if (!step || !plane.shown || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  const far = KEY_STEP * (event.shiftKey ? 5 : 1);
  const [x, y] = plane.target ?? plane.rows.at(-1)?.[1].slice(2, 4) ?? [0, 0];
  plane.target = inside([x + step[0] * far, y + step[1] * far]);
}

/** Goes on with a session of the folder. */
export function resume(name) {
  $("tab-plane").click();
  ask("resume", { name });
}

/** The page's state: a session that is open on the device hides the page. */
export function start() {
  const canvas = $("plane-canvas");
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !plane.shown) return;
    canvas.setPointerCapture(event.pointerId);
    // in the task a mouse leads without being pressed, and a press selects; a finger leads, and selects when lifted
    if (plane.shown.circle && event.pointerType !== "touch") return ask("select");
    plane.target = place(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!plane.shown) return;
    const leads = plane.shown.circle && event.pointerType !== "touch";
    if (leads || (plane.target && canvas.hasPointerCapture(event.pointerId))) plane.target = place(event);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!plane.shown?.circle) return letGo();
    if (event.pointerType === "touch") ask("select");
  });
  canvas.addEventListener("pointercancel", letGo);
  canvas.addEventListener("blur", letGo);
  canvas.addEventListener("keydown", key);
  $("ring-begin").addEventListener("submit", (event) => {
    event.preventDefault();
    const { subject, seed } = event.target.elements;
    ask("begin", { subject: subject.value.trim(), seed: Number(seed.value) });
    canvas.focus({ preventScroll: true });
  });
  $("ring-leave").addEventListener("click", () => { letGo(); ask("leave"); });
  wire.on("plane", shown);
  wire.on("puck", stepped);
  // a new socket has a new plane
  wire.on("open", () => { if (visible) ask("open"); });
}
