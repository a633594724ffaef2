// Record, diagnose, feel: from a recording to the handle in three presses, and the force before and after.

import { beside } from "./bench.js";
import { css } from "./scope.js";
import { wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
/** Length of the recording, s, as in crates/lab/src/bench/handover.rs. */
const SECONDS = 10;
const SERIES = [
  { key: "before", colour: "quiet", dash: [5, 4], width: 2 },
  { key: "after", colour: "accent", width: 2.5 },
  { key: "felt_before", colour: "quiet", points: true },
  { key: "recorded", colour: "force", points: true },
  { key: "felt", colour: "good", points: true },
];
let known = null;
let drawn = "";
let sending = false;

const newton = (x) => `${x < 0 ? "−" : ""}${Math.abs(x).toFixed(2)} N`;
const short = (text) => (text === "" || Number.isNaN(Number(text)) ? text : `${+Number(text).toPrecision(4)}`);

function element(kind, text, title) {
  const made = document.createElement(kind);
  made.textContent = text;
  if (title) made.title = title;
  return made;
}

function sentence({ handover, job, recording, period }) {
  const { step, summary, refused, before_name } = handover;
  if (recording !== null) return `Recording: ${(recording * period).toFixed(1)} of ${SECONDS} s.`;
  if (job?.kind === "diagnose") return `Diagnosing ${job.of}: ${job.says}.`;
  return {
    record: `Mount a body on the handle. The device drives it for ${SECONDS} s: hands off.`,
    diagnose: `${handover.recording} is recorded. What friction does the body have, and what would a simulation leave out?`,
    send: summary,
    refused: `Nothing was sent. ${refused[0]?.toUpperCase()}${refused.slice(1)}.`,
    sending: "Sent; waiting for the device.",
    sent: `On the handle, in place of ${before_name}, which its button in Feel brings back. ${known.sim ? "A simulated hand moves it; drag the handle to feel it yourself." : "Take the body off, and move the handle."}`,
  }[step];
}

/** What the sentence of the felt force is made of: N at the speed compared. */
export function felt({ before, after, recorded, felt: now, speeds, compared }) {
  const at = (curve) => curve?.over_speed?.[compared] ?? null;
  return { speed: speeds[compared], before: at(before), after: at(after), recorded: at(recorded), now: at(now) };
}

function difference(handover) {
  const { speed, before, after, recorded, now } = felt(handover);
  if (before === null || after === null) return "";
  const change = after - before;
  const live = now === null ? "" : `, ${newton(now)} measured now`;
  const body = recorded === null ? "" : `; the recorded body has ${newton(recorded)}`;
  const more = Math.abs(change) < 0.005 ? "no difference" : `${newton(Math.abs(change))} ${change > 0 ? "more" : "less"}`;
  return `At ${(1e3 * speed).toFixed(0)} mm/s: ${newton(before)} before, ${newton(after)} ${handover.step === "sent" ? "after" : "if sent"}${live}: ${more}${body}.`;
}

/** Forces over places, as lines and points. */
function plot(canvas, places, says, curves) {
  const ratio = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width) return;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const all = curves.flatMap(({ values }) => values).filter((y) => y !== null);
  const most = Math.max(0.1, ...all.map(Math.abs)) * 1.1;
  // the end of the outermost bin
  const xmax = places.at(-1) + 0.5 * (places[1] - places[0]);
  const low = all.every((y) => y >= 0) ? 0 : -most, [left, top, right, bottom] = [44, 8, width - 8, height - 32];
  const x = (p) => left + (0.5 + (0.5 * p) / xmax) * (right - left);
  const y = (n) => bottom - ((n - low) / (most - low)) * (bottom - top);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui";
  pen.fillStyle = css("quiet");
  for (const share of [-1, -0.5, 0, 0.5, 1]) {
    pen.strokeStyle = share === 0 ? css("line") : css("soft");
    pen.beginPath(); pen.moveTo(x(share * xmax), top); pen.lineTo(x(share * xmax), bottom); pen.stroke();
    pen.textAlign = share === -1 ? "left" : share === 1 ? "right" : "center";
    pen.textBaseline = "top";
    pen.fillText(`${+(1e3 * share * xmax).toPrecision(3)}`, x(share * xmax), bottom + 3);
  }
  const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].map((s) => s * 1).find((s) => (most - low) / s <= 6) ?? most;
  for (let n = Math.ceil(low / step) * step; n <= most; n += step) {
    pen.strokeStyle = Math.abs(n) < 1e-9 ? css("line") : css("soft");
    pen.beginPath(); pen.moveTo(left, y(n)); pen.lineTo(right, y(n)); pen.stroke();
    pen.textAlign = "right"; pen.textBaseline = "middle";
    pen.fillText(`${+n.toFixed(2)}`, left - 5, y(n));
  }
  pen.textAlign = "left"; pen.textBaseline = "alphabetic";
  pen.fillText(says, left, height - 3);
  for (const { values, colour, dash, width: thick, points } of curves) {
    pen.strokeStyle = pen.fillStyle = css(colour);
    if (points) {
      values.forEach((n, k) => { if (n !== null) { pen.beginPath(); pen.arc(x(places[k]), y(n), 2.4, 0, 7); pen.fill(); } });
      continue;
    }
    pen.lineWidth = thick;
    pen.setLineDash(dash ?? []);
    pen.beginPath();
    let on = false;
    values.forEach((n, k) => { if (n === null) on = false; else { if (on) pen.lineTo(x(places[k]), y(n)); else pen.moveTo(x(places[k]), y(n)); on = true; } });
    pen.stroke();
    pen.setLineDash([]);
  }
}

/** Whether a force depends on the place enough to be seen. */
function varies(values) {
  const there = values.filter((y) => y !== null);
  return there.length > 0 && Math.max(...there) - Math.min(...there) > 0.01 * known.force_max;
}

function plots({ handover, preset }) {
  const shows = ["send", "sending", "sent"].includes(handover.step);
  $("ho-felt").hidden = !shows;
  if (!shows) { drawn = ""; return; }
  const says = difference(handover);
  $("ho-difference").textContent = says;
  const sent = handover.step === "sent";
  const names = {
    before: `${sent ? handover.before_name : preset}, before`, after: sent ? "what was found, sent" : "what was found",
    felt_before: "before, measured", recorded: "recorded body, measured", felt: "handle, measured now",
  };
  const key = JSON.stringify([handover, names, innerWidth, matchMedia("(prefers-color-scheme: dark)").matches]);
  if (key === drawn) return;
  drawn = key;
  const there = SERIES.filter(({ key: k }) => handover[k].over_speed.some((n) => n !== null));
  $("ho-legend").replaceChildren(...there.map(({ key: k, colour, points, dash }) => {
    const mark = element("b", names[k]);
    mark.style.color = css(colour);
    mark.className = points ? "points" : dash ? "dashed" : "";
    return mark;
  }));
  plot($("ho-speed"), handover.speeds, "mm/s across, friction force in N up", there.map((s) => ({ ...s, values: handover[s.key].over_speed })));
  const place = varies(handover.before.over_position) || varies(handover.after.over_position);
  $("ho-position").hidden = !place;
  if (place) plot($("ho-position"), handover.positions, "mm of the stroke across, moving to the right, N up", there.map((s) => ({ ...s, values: handover[s.key].over_position })));
  $("ho-speed").setAttribute("aria-label", `Friction force over speed, before and after. ${says}`);
}

function plan({ handover }) {
  const { step, differences, moved, left_out, warning } = handover;
  const planned = ["send", "sending", "sent", "refused"].includes(step);
  $("ho-plan").hidden = !planned || !differences.length;
  const bound = (name) => moved.find((m) => m.name === name);
  $("ho-table").tBodies[0].replaceChildren(...differences.map(({ name, unit, before, after }) => {
    const tr = document.createElement("tr");
    const at = bound(name);
    const cells = [element("td", name), element("td", short(before)), element("td", at ? `${+at.found.toPrecision(4)}` : short(after)), element("td", short(after)), element("td", unit)];
    cells.slice(1, 4).forEach((td) => { td.className = "n"; });
    if (at) cells[3].classList.add("moved");
    tr.append(...cells);
    return tr;
  }));
  const notes = !planned ? [] : [
    ...moved.map((m) => ["At its limit", `${m.name}: ${+m.found.toPrecision(4)} was found, ${+m.sent.toPrecision(4)} ${m.unit} is sent; ${m.why}`]),
    ...left_out.map((l) => ["Not sent", `${l.name}: ${l.why}`]),
    ...(warning ? [["Warning", warning]] : []),
  ];
  $("ho-notes").replaceChildren(...notes.map(([tone, text]) => {
    const li = document.createElement("li");
    li.append(element("strong", `${tone}: `), text);
    return li;
  }));
}

export function state(now) {
  known = now;
  const { handover, job, recording, connected } = now;
  const { step } = handover;
  const busy = Boolean(job), recorded = recording !== null;
  $("ho-says").textContent = sentence(now);
  $("ho-says").className = step === "refused" && !recorded && !busy ? "refused" : "";
  $("ho-record").disabled = !connected || busy;
  $("ho-record").setAttribute("aria-pressed", recorded);
  $("ho-record").textContent = recorded ? "1 End" : "1 Record";
  $("ho-diagnose").disabled = busy || recorded || !handover.recording;
  $("ho-send").disabled = !connected || busy || recorded || step !== "send";
  const next = recorded || busy ? "" : { record: "ho-record", diagnose: "ho-diagnose", send: "ho-send" }[step];
  for (const id of ["ho-record", "ho-diagnose", "ho-send"]) $(id).classList.toggle("next", id === next);
  const diagnosing = job?.kind === "diagnose";
  $("ho-progress").hidden = !recorded && !diagnosing;
  $("ho-progress").querySelector("progress").value = recorded ? Math.min(1, (recording * now.period) / SECONDS) : job?.share ?? 0;
  $("ho-cancel").hidden = !diagnosing;
  $("ho-report").hidden = !handover.report || recorded;
  // what was sent is felt by the simulated hand, which its own button ends
  if (sending && step === "sent" && now.sim) {
    $("hand-sine").setAttribute("aria-pressed", true);
    $("hand-sine").textContent = "Hand off";
  }
  sending = step === "sending";
  plan(now);
  plots(now);
}

export function start() {
  $("ho-record").addEventListener("click", () => wire.ask(known?.recording === null ? { do: "handover_record", by_hand: $("ho-by").value === "hand" } : { do: "record_end" }));
  $("ho-diagnose").addEventListener("click", () => wire.ask({ do: "handover_diagnose" }));
  $("ho-send").addEventListener("click", () => wire.ask({ do: "handover_send" }));
  $("ho-cancel").addEventListener("click", () => wire.ask({ do: "cancel" }));
  $("ho-report").addEventListener("click", () => beside(known.handover.report));
}
