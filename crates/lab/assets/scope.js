// Position, velocity, force and state over time. Follows the newest sample, or stops when paused.

/* global uPlot */

export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** Half the height of an axis: 1, 2 or 5 times a power of ten; it grows at once and shrinks only when it is far too large. */
export function steady(least) {
  let now = least;
  return (largest) => {
    const wanted = Math.max(least, 1.08 * largest);
    if (wanted > now || wanted < 0.35 * now) {
      const power = 10 ** Math.floor(Math.log10(wanted));
      now = [1, 2, 3, 5, 8, 10].map((k) => k * power).find((k) => k >= wanted * (1 - 1e-9)) ?? wanted;
    }
    return now;
  };
}

const PLOTS = [
  { title: "Position", unit: "mm", scale: 1e3, least: 1, digits: 3, channels: [["position", "position", "measured"], ["reference", "command", "reference"]] },
  { title: "Velocity", unit: "mm/s", scale: 1e3, least: 5, digits: 1, channels: [["velocity", "velocity", "measured"]] },
  { title: "Force", unit: "N", scale: 1, least: 1, digits: 2, channels: [["force", "force", "load cell"], ["command", "command", "commanded"]] },
];
/** Shares of the height there is. */
const SHARES = [0.36, 0.28, 0.36];

/** What the window leaves for the plots, px. */
const room = () => Math.max(innerWidth < 820 ? 340 : 420, innerHeight - 390);

export const STATES = { idle: 0, rendering: 1, exciting: 2, identifying: 3, fault: 4, homing: 5 };
const STATE_NAMES = ["idle, force off", "rendering", "driven", "identifying", "fault, force off", "searching the stops"];
const STATE_COLOURS = ["line", "velocity", "position", "command", "bad", "position"];

export class Scope {
  constructor(ring, box, reading) {
    Object.assign(this, { ring, box, reading, window: 10, paused: false, view: null, cursor: null, dirty: true, drawn: 0, cost: 0, newestDrawn: 0 });
    this.sync = uPlot.sync("scope");
    this.build();
    new ResizeObserver(() => this.resize()).observe(box);
    addEventListener("resize", () => this.resize());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    box.addEventListener("keydown", (event) => this.key(event));
  }

  build() {
    this.plots?.forEach((plot) => plot.u.destroy());
    this.box.replaceChildren();
    const axis = { stroke: css("quiet"), grid: { stroke: css("soft"), width: 1 }, ticks: { stroke: css("line"), width: 1 }, font: "12px system-ui" };
    this.plots = PLOTS.map((spec, k) => {
      const div = document.createElement("div");
      div.className = "plot";
      const head = document.createElement("h2");
      head.append(`${spec.title}, ${spec.unit}`);
      const outputs = spec.channels.map(([name, colour, says], c) => {
        const mark = document.createElement("b");
        mark.style.color = css(colour);
        mark.className = c ? "dashed" : "";
        const output = document.createElement("output");
        mark.append(says);
        head.append(mark, output);
        mark.hidden = output.hidden = name === "reference";
        return { name, mark, output };
      });
      div.append(head);
      this.box.append(div);
      const reach = steady(spec.least);
      const u = new uPlot({
        width: this.width(), height: Math.round(room() * SHARES[k]),
        legend: { show: false },
        cursor: { sync: { key: "scope", setSeries: false }, points: { show: false }, drag: { x: true, y: false, setScale: false } },
        scales: {
          x: { time: false },
          y: { range: (_, low, high) => { const r = reach(Math.max(Math.abs(low ?? 0), Math.abs(high ?? 0))); return [-r, r]; } },
        },
        axes: [
          { ...axis, size: 26, values: (_, ticks) => ticks.map((t) => `${+t.toFixed(4)} s`) },
          { ...axis, size: 52, values: (_, ticks) => ticks.map((y) => `${+y.toFixed(4)}`) },
        ],
        series: [{}, ...spec.channels.map(([, colour], c) => ({
          stroke: css(colour), width: c ? 1.5 : 1.25, dash: c ? [5, 4] : undefined, points: { show: false }, scale: "y",
        }))],
        hooks: {
          setCursor: [(plot) => { this.cursor = plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : null; this.dirty = true; }],
          setSelect: [(plot) => this.select(plot)],
          ready: [(plot) => plot.over.addEventListener("dblclick", () => { this.view = null; this.dirty = true; })],
        },
      }, [[], ...spec.channels.map(() => [])], div);
      this.sync.sub(u);
      return { u, spec, outputs };
    });
    this.states = document.createElement("canvas");
    this.states.id = "states";
    this.states.setAttribute("role", "img");
    this.states.setAttribute("aria-label", "State of the device over time");
    this.box.append(this.states);
    this.dirty = true;
  }

  width() { return Math.max(200, this.box.clientWidth); }

  resize() {
    const width = this.width();
    this.plots.forEach(({ u }, k) => {
      const height = Math.round(room() * SHARES[k]);
      if (u.width !== width || u.height !== height) u.setSize({ width, height });
    });
    this.dirty = true;
  }

  pause(on) {
    this.paused = on;
    this.view = on ? [this.ring.newest - this.window, this.ring.newest] : null;
    this.dirty = true;
  }

  select(plot) {
    const { left, width } = plot.select;
    if (width < 4 || !this.paused) return;
    this.view = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    for (const { u } of this.plots) u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.dirty = true;
  }

  key(event) {
    if (!this.paused) return;
    const [from, to] = this.range();
    const span = to - from;
    const moved = { ArrowLeft: [-0.2, -0.2], ArrowRight: [0.2, 0.2], "+": [0.25, -0.25], "-": [-0.5, 0.5] }[event.key];
    if (!moved) return;
    event.preventDefault();
    this.view = [from + moved[0] * span, to + moved[1] * span];
    this.dirty = true;
  }

  range() {
    if (this.paused && this.view) return this.view;
    const now = Math.max(this.ring.newest, this.window);
    return [now - this.window, now];
  }

  /** Draws what is new; a page nobody sees draws nothing. */
  draw() {
    const fresh = this.ring.received !== this.drawn && !this.paused;
    if (!fresh && !this.dirty) return;
    const began = performance.now();
    this.dirty = false;
    this.drawn = this.ring.received;
    const [from, to] = this.range();
    for (const { u, spec } of this.plots) {
      const names = spec.channels.map(([name]) => name);
      const columns = Math.max(50, Math.round(u.bbox.width / devicePixelRatio));
      const data = this.ring.picture(names, from, to, columns);
      for (let c = 1; c < data.length; c++) {
        const values = data[c];
        for (let k = 0; k < values.length; k++) values[k] = values[k] === null || Number.isNaN(values[k]) ? null : values[k] * spec.scale;
      }
      u.batch(() => { u.setData(data, false); u.setScale("x", { min: from, max: to }); });
    }
    this.readings();
    this.strip(from, to);
    this.newestDrawn = this.ring.newest;
    this.cost = 0.9 * this.cost + 0.1 * (performance.now() - began);
  }

  /** The sample under the cursor, itself and not the picture of it; else the newest. */
  readings() {
    const { ring } = this;
    const i = this.cursor === null ? ring.end - 1 : ring.nearest(this.cursor);
    for (const { spec, outputs } of this.plots) {
      for (const { name, output } of outputs) {
        const value = i < 0 ? NaN : ring.at(name, i) * spec.scale;
        if (name === "reference") output.hidden = output.previousElementSibling.hidden = !Number.isFinite(value);
        output.value = Number.isFinite(value) ? `${value >= 0 ? "+" : "−"}${Math.abs(value).toFixed(spec.digits)}` : "–";
      }
    }
    this.reading.value = i < 0 ? "" : `${this.cursor === null ? "now" : "at cursor"} ${ring.at("time", i).toFixed(3)} s`;
  }

  strip(from, to) {
    const { ring, states } = this;
    const width = states.clientWidth, height = states.clientHeight, ratio = devicePixelRatio;
    if (states.width !== Math.round(width * ratio)) { states.width = Math.round(width * ratio); states.height = Math.round(height * ratio); }
    const pen = states.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    // below the plots
    const { bbox } = this.plots[0].u;
    const left = bbox.left / ratio, span = bbox.width / ratio;
    const x = (t) => left + Math.max(0, Math.min(1, (t - from) / (to - from))) * span;
    const last = Math.min(ring.end, ring.find(to) + 1);
    pen.font = "12px system-ui";
    pen.textBaseline = "middle";
    pen.fillStyle = css("quiet");
    pen.fillText("state", 4, 11);
    for (let i = ring.find(from); i < last;) {
      const mode = ring.at("mode", i), begin = i;
      while (i < last && ring.at("mode", i) === mode) i++;
      const [a, b] = [x(ring.at("time", begin)), x(ring.at("time", Math.min(i, last - 1)))];
      pen.globalAlpha = mode === 0 ? 0.6 : 1;
      pen.fillStyle = css(STATE_COLOURS[mode] ?? "line");
      pen.fillRect(a, 3, Math.max(1, b - a), 15);
      pen.globalAlpha = 1;
      const says = STATE_NAMES[mode] ?? "unknown";
      if (b - a > pen.measureText(says).width + 10) { pen.fillStyle = mode === 0 ? css("ink") : css("sheet"); pen.fillText(says, a + 5, 11); }
    }
  }
}
