// The page: state, drawing, and a stop that works everywhere.

import * as bench from "./bench.js";
import * as controls from "./controls.js";
import { Handle } from "./handle.js";
import * as handover from "./handover.js";
import { Loop } from "./loop.js";
import * as planar from "./plane.js";
import { Ring } from "./ring.js";
import { Scope } from "./scope.js";
import * as tests from "./try.js";
import { connect, wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
const ring = new Ring();
const scope = new Scope(ring, $("plots"), $("reading"));
const loop = new Loop(ring, $("loop"));
const handle = new Handle(ring, $("handle"));
let known = null;

/** A sentence for a while. */
function say(tone, text, about = "") {
  const last = $("said").lastElementChild;
  if (last?.textContent === text) last.remove();
  const p = document.createElement("p");
  p.className = tone;
  p.textContent = text;
  p.dataset.about = about;
  $("said").append(p);
  while ($("said").childElementCount > 4) $("said").firstElementChild.remove();
  setTimeout(() => p.remove(), tone === "done" ? 3500 : 9000);
}

function stop() {
  if (!wire.ask({ do: "stop" })) say("error", "the lab does not answer: use the emergency stop of the device");
  $("hand-sine").setAttribute("aria-pressed", false);
  $("hand-sine").textContent = "Move by a simulated hand";
}

function state(now) {
  known = now;
  if (now.epoch !== ring.epoch) ring.clear(now.epoch, now.period);
  ring.period = now.period;
  const device = $("device");
  device.className = `chip ${now.connected ? "good" : "bad"}`;
  device.textContent = now.connected ? `${now.sim ? "virtual device" : now.port}` : "no device";
  device.title = now.version;
  $("absent").hidden = now.connected || now.absent === "connecting";
  $("absent").textContent = now.unheard
    ? "The lab does not answer: `tribos lab` has ended, or its computer sleeps. This page reconnects by itself. Finished trials and recordings are kept."
    : `No device on ${now.port}: ${now.absent}. The lab retries every second. Finished trials and recordings are kept.`;
  const mode = $("mode");
  mode.textContent = now.connected ? `${now.mode}${now.mode === "rendering" ? ` ${now.preset}` : ""}` : "";
  mode.className = `chip ${now.mode === "fault" ? "bad" : now.mode === "idle" ? "" : "on"}`;
  const on = now.armed || now.mode === "rendering";
  $("arm").setAttribute("aria-pressed", on);
  $("arm").textContent = on ? "Disarm: force off" : "Arm: force on";
  $("arm").disabled = !now.connected || Boolean(now.fault);
  $("fault").hidden = !now.fault;
  if (now.fault) {
    $("fault").querySelector("strong").textContent = `Force is off. ${now.fault.id.replaceAll("_", " ")}:`;
    $("fault").querySelector("span").textContent = `${now.fault.says}. Then clear, hands off. `;
  }
  $("origin").hidden = !now.connected || !now.unreferenced;
  $("origin").querySelector("span").textContent =
    `The device does not know the middle of its stroke since it started: at most ${now.unreferenced_force.toFixed(1)} N, and no motion.`;
  for (const id of ["home", "zero"]) $(id).disabled = now.mode !== "idle";
  handle.state(now);
  controls.state(now);
  bench.state(now);
  handover.state(now);
  tests.state(now);
}

function tabs() {
  const all = [...document.querySelectorAll("[role=tab]")];
  const choose = (tab) => {
    for (const other of all) {
      const on = other === tab;
      other.setAttribute("aria-selected", on);
      other.tabIndex = on ? 0 : -1;
      $(other.getAttribute("aria-controls")).hidden = !on;
    }
    planar.show(tab.id === "tab-plane");
  };
  all.forEach((tab, k) => {
    tab.addEventListener("click", () => choose(tab));
    tab.addEventListener("keydown", ({ key }) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
      if (!step) return;
      const next = all[(k + step + all.length) % all.length];
      next.focus();
      choose(next);
    });
  });
}

function keys() {
  const typing = (target) => target.closest?.("input:not([type=checkbox]), select, textarea");
  // first listener: nothing on the page may intercept a stop
  addEventListener("keydown", (event) => {
    const space = event.key === " " && !typing(event.target);
    if (event.key !== "Escape" && !space) return;
    if (space) event.preventDefault();
    if (!event.repeat) stop();
  }, true);
  // a report in a frame would take the keys: it returns the focus, and is read by keyboard in its own tab
  addEventListener("blur", () => setTimeout(() => { if (document.activeElement?.tagName === "IFRAME") $("stop").focus({ preventScroll: true }); }));
  // in full screen the browser handles Escape itself
  document.addEventListener("fullscreenchange", () => { if (!document.fullscreenElement && known?.experiment?.armed) stop(); });
  // releasing a space on a button would press it
  addEventListener("keyup", (event) => { if (event.key === " " && !typing(event.target)) event.preventDefault(); }, true);
  addEventListener("keydown", (event) => {
    if (known?.experiment || typing(event.target) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "p") $("pause").click();
    if (event.key === "r") $("record").click();
  });
}

function health() {
  const jitter = ring.jitter(2000);
  $("rate").textContent = `${Math.round(1 / ring.period)} Hz`;
  $("jitter").textContent = jitter ? `${jitter.worst.toFixed(1)} µs` : "–";
  $("lost").textContent = ring.skipped ? `${ring.lost} + ${ring.skipped} batches` : `${ring.lost}`;
  $("lost").classList.toggle("bad", ring.lost > 0 || ring.skipped > 0);
}

let scoped = 0;
function frame(now) {
  // a column of the scope is wider than 30 ms; the handle is drawn at the rate of the screen
  if (now - scoped > 28) {
    scoped = now;
    scope.draw();
    loop.draw(scope.range());
  }
  handle.draw();
  planar.draw();
  tests.draw();
  requestAnimationFrame(frame);
}

wire.on("samples", (batch) => ring.push(batch));
wire.on("state", state);
wire.on("said", ({ tone, about, text }) => say(tone, text, about));
wire.on("closed", () => {
  say("error", "the lab is gone; this page reconnects by itself. Finished trials and recordings are kept.");
  if (known) state({ ...known, connected: false, armed: false, mode: "idle", unheard: true });
});
wire.on("open", () => { ring.next = null; });

for (const id of ["stop", "stage-stop"]) $(id).addEventListener("click", stop);
$("arm").addEventListener("click", () => wire.ask({ do: $("arm").getAttribute("aria-pressed") === "true" ? "disarm" : "arm" }));
$("clear").addEventListener("click", () => wire.ask({ do: "clear" }));
$("home").addEventListener("click", () => wire.ask({ do: "home" }));
$("zero").addEventListener("click", () => wire.ask({ do: "zero" }));
$("window").addEventListener("change", (event) => { scope.window = Number(event.target.value); if (scope.paused) scope.pause(true); scope.dirty = true; });
$("pause").addEventListener("click", () => {
  const on = !scope.paused;
  scope.pause(on);
  $("pause").setAttribute("aria-pressed", on);
  $("pause").textContent = on ? "Go on" : "Pause";
});
tabs();
keys();
controls.start();
bench.start();
handover.start();
planar.start();
tests.start(ring);
connect();
setInterval(health, 250);
requestAnimationFrame(frame);

// for tests, which check the drawing sample by sample
globalThis.lab = { ring, scope, wire, stage: tests.stage, plane: planar.plane, get known() { return known; } };
