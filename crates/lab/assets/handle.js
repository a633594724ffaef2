// The handle on its stroke. On the virtual device a hand follows mouse, finger or arrow keys.

import { css } from "./scope.js";
import { wire } from "./wire.js";

/** m of an arrow key. */
const KEY_STEP = 0.5e-3;

export class Handle {
  constructor(ring, box) {
    Object.assign(this, { ring, box, canvas: box.querySelector("canvas"), reach: 0.016, sim: false, target: null, sent: null, drawn: null });
    const at = (event) => {
      const { left, width } = this.canvas.getBoundingClientRect();
      return this.clamp(((event.clientX - left) / width - 0.5) * 2.2 * this.reach);
    };
    box.addEventListener("pointerdown", (event) => {
      if (!this.sim || event.button !== 0) return;
      box.setPointerCapture(event.pointerId);
      box.classList.add("held");
      this.target = at(event);
    });
    box.addEventListener("pointermove", (event) => { if (box.hasPointerCapture(event.pointerId)) this.target = at(event); });
    for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, () => this.letGo());
    box.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[event.key];
      if (!this.sim || (!step && event.key !== "Enter")) return;
      event.preventDefault();
      if (event.key === "Enter") return this.letGo();
      const from = this.target ?? this.ring.at("position", this.ring.end - 1) ?? 0;
      this.target = this.clamp(from + step * KEY_STEP);
    });
    box.addEventListener("blur", () => this.letGo());
  }

  clamp(x) { const most = this.reach - 0.5e-3; return Math.max(-most, Math.min(most, x)); }

  letGo() {
    this.box.classList.remove("held");
    if (this.target !== null) wire.ask({ do: "hand", at: null });
    this.target = this.sent = null;
  }

  state({ sim, reach }) {
    Object.assign(this, { sim, reach });
    this.box.classList.toggle("sim", sim);
    this.box.setAttribute("aria-valuemin", -1e3 * reach);
    this.box.setAttribute("aria-valuemax", 1e3 * reach);
  }

  /** Once a frame: the newest place of the pointer goes out, the newest place of the handle is drawn. */
  draw() {
    if (this.target !== null && this.target !== this.sent && wire.ask({ do: "hand", at: this.target })) this.sent = this.target;
    const { canvas, ring, reach } = this;
    const now = ring.end ? ring.at("position", ring.end - 1) : 0;
    const key = `${now}${this.target}${canvas.clientWidth}`;
    if (key === this.drawn) return;
    this.drawn = key;
    if (Math.round(now * 1e4) !== this.told) this.box.setAttribute("aria-valuenow", (now * 1e3).toFixed(1));
    this.told = Math.round(now * 1e4);
    const ratio = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const x = (m) => (0.5 + m / (2.2 * reach)) * width;
    const rail = 32;
    pen.fillStyle = css("soft");
    pen.fillRect(x(-reach), rail - 4, x(reach) - x(-reach), 8);
    pen.strokeStyle = pen.fillStyle = css("quiet");
    pen.lineWidth = 1;
    pen.font = "12px system-ui";
    pen.textAlign = "center";
    pen.beginPath();
    const step = width < 500 ? 8 : 4, most = Math.floor(1e3 * reach);
    for (let mm = -most; mm <= most; mm++) {
      const long = mm % step === 0;
      pen.moveTo(x(mm / 1e3), rail + 14); pen.lineTo(x(mm / 1e3), rail + (long ? 22 : 17));
      if (long) pen.fillText(`${mm}${mm === 0 ? " mm" : ""}`, x(mm / 1e3), rail + 36);
    }
    pen.stroke();
    pen.fillStyle = css("ink");
    for (const end of [-1, 1]) pen.fillRect(x(end * reach) - (end < 0 ? 4 : 0), rail - 14, 4, 28);
    if (this.target !== null) { // the hand pulls through a spring
      pen.strokeStyle = css("command");
      pen.lineWidth = 2;
      pen.setLineDash([4, 3]);
      pen.beginPath(); pen.moveTo(x(now), rail); pen.lineTo(x(this.target), rail); pen.stroke();
      pen.setLineDash([]);
      pen.beginPath(); pen.arc(x(this.target), rail, 6, 0, 7); pen.stroke();
    }
    pen.fillStyle = css("position");
    pen.beginPath(); pen.roundRect(x(now) - 13, rail - 20, 26, 40, 7); pen.fill();
    pen.fillStyle = css("sheet");
    for (const d of [-4, 0, 4]) pen.fillRect(x(now) + d - 0.75, rail - 9, 1.5, 18);
  }
}
