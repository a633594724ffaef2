// Presets and parameters. The device's own validation checks every change before it is sent.

import { wire } from "./wire.js";

const $ = (id) => document.getElementById(id);
const LEVELS = { stable: "✓ Stable", unfaithful: "! Stable, but not faithful", refused: "✕ The device would refuse this" };

let known = null;
let pending = new Map();
let asked = 0;
let timer = 0;
let judged = null;

const changes = () => [...pending];
const short = (x) => (Math.abs(x) >= 1e5 || (x !== 0 && Math.abs(x) < 1e-3) ? x.toExponential(1) : +x.toPrecision(5)).toString();

function limits(p) {
  if (p.choices.length) return p.what;
  const unit = p.unit ? ` ${p.unit}` : "";
  if (p.low !== null && p.high !== null) return `${p.what}: ${short(p.low)} … ${short(p.high)}${unit}`;
  if (p.high !== null) return `${p.what}: up to ${short(p.high)}${unit}`;
  return p.low !== null ? `${p.what}: from ${short(p.low)}${unit}` : p.what;
}

function row(p) {
  const label = document.createElement("label");
  label.dataset.name = p.name;
  label.title = p.what;
  const name = document.createElement("span");
  name.textContent = p.name;
  let field;
  if (p.choices.length) {
    field = document.createElement("select");
    field.append(...p.choices.map((choice) => new Option(choice, choice)));
  } else {
    field = document.createElement("input");
    field.inputMode = "decimal";
    field.maxLength = 24;
  }
  field.name = p.name;
  const unit = document.createElement("i");
  unit.textContent = p.unit;
  const small = document.createElement("small");
  small.id = `limits-${p.name}`;
  field.setAttribute("aria-describedby", small.id);
  field.addEventListener("input", () => {
    const value = field.value.trim();
    if (value === label.dataset.value) pending.delete(p.name); else pending.set(p.name, value);
    show();
    clearTimeout(timer);
    timer = setTimeout(propose, 60);
  });
  label.append(name, field, ...(p.choices.length ? [] : [unit]), small);
  return label;
}

function propose() {
  if (pending.size) wire.ask({ do: "propose", id: ++asked, changes: changes() });
  else { judged = null; show(); }
}

function show() {
  const verdict = judged ?? known.verdict;
  const form = $("parameters");
  const shown = verdict.parameters.filter((p) => p.used);
  const names = shown.map((p) => p.name).join();
  if (form.dataset.names !== names) {
    form.dataset.names = names;
    const held = document.activeElement?.name;
    form.replaceChildren(...shown.map(row));
    form.elements[held]?.focus();
  }
  for (const p of shown) {
    const label = form.querySelector(`[data-name="${CSS.escape(p.name)}"]`);
    const field = label.querySelector("input, select");
    const active = known.verdict.parameters.find((q) => q.name === p.name)?.value ?? p.value;
    label.dataset.value = active;
    if (!pending.has(p.name) && field !== document.activeElement) field.value = active;
    if (!pending.has(p.name) && field === document.activeElement && label.dataset.shown !== active) field.value = active;
    label.dataset.shown = active;
    label.classList.toggle("pending", pending.has(p.name));
    label.classList.toggle("wrong", verdict.level === "refused" && verdict.about === p.name);
    field.setAttribute("aria-invalid", verdict.level === "refused" && verdict.about === p.name);
    label.querySelector("small").textContent = limits(p);
  }
  const box = $("verdict");
  box.className = verdict.level;
  box.querySelector("strong").textContent = LEVELS[verdict.level];
  box.querySelector("p").textContent = verdict.level === "stable" ? "" : verdict.says;
  box.querySelector("ul").replaceChildren(...verdict.bounds.map(bound));
  $("apply").disabled = !pending.size || verdict.level === "refused" || !known.connected;
  $("apply").textContent = pending.size > 1 ? `Apply ${pending.size} changes` : "Apply";
  $("revert").disabled = !pending.size;
}

function bound({ name, value, limit, unit, below, says }) {
  const item = document.createElement("li");
  const meter = document.createElement("meter");
  const share = below ? value / limit : limit / value;
  Object.assign(meter, { min: 0, max: 1, low: 0.9, high: 0.999, optimum: 0 });
  meter.value = Number.isFinite(share) ? Math.min(1, share) : 1;
  const label = document.createElement("span");
  label.textContent = name;
  const figures = document.createElement("span");
  figures.textContent = `${short(value)} ${below ? "of" : "above"} ${short(limit)} ${unit}`;
  if (share > 1) figures.textContent = `${short(value)}, ${below ? "beyond" : "below"} ${short(limit)} ${unit}`;
  const small = document.createElement("small");
  small.textContent = says;
  item.append(label, meter, figures, small);
  return item;
}

function apply() {
  if ($("apply").disabled) return;
  wire.ask({ do: "set", changes: changes() });
  pending.clear();
  judged = null;
  show();
}

function presets() {
  $("presets").replaceChildren(...known.presets.map((name) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.preset = name;
    button.textContent = name === known.preset && known.changed ? `${name} (changed)` : name;
    button.setAttribute("aria-pressed", name === known.preset);
    button.addEventListener("click", () => {
      pending.clear();
      judged = null;
      wire.ask({ do: "use", name });
    });
    return button;
  }));
}

/** Values to be looked at and applied, such as what was identified. */
export function fill(values) {
  for (const [name, value] of values) pending.set(name, value);
  $("tab-feel").click();
  show();
  for (const [name, value] of pending) {
    const field = $("parameters").elements[name];
    if (field) field.value = value;
  }
  propose();
}

export function state(now) {
  const list = known && known.presets.join() + known.preset + known.changed;
  known = now;
  if (list !== now.presets.join() + now.preset + now.changed) presets();
  show();
}

export function start() {
  wire.on("proposed", ({ id, verdict }) => {
    if (id !== asked || !pending.size) return;
    judged = verdict;
    show();
  });
  $("parameters").addEventListener("submit", (event) => { event.preventDefault(); apply(); });
  $("parameters").addEventListener("keydown", (event) => { if (event.key === "Enter") { event.preventDefault(); apply(); } });
  $("apply").addEventListener("click", apply);
  $("revert").addEventListener("click", () => { pending.clear(); judged = null; delete $("parameters").dataset.names; show(); });
  $("save").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = event.target.elements.name.value.trim();
    if (name) wire.ask({ do: "save", name });
  });
}
