// Force against velocity: the friction loop.

import { css, steady } from "./scope.js";

/** Seconds shown. */
const SPAN = 4;

export class Loop {
  constructor(ring, canvas) {
    Object.assign(this, { ring, canvas, speed: steady(5), force: steady(1), drawn: -1 });
  }

  draw(range) {
    const { ring, canvas } = this;
    if (ring.received === this.drawn) return;
    this.drawn = ring.received;
    const ratio = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
    const to = Math.min(range[1], ring.newest + ring.period), first = ring.find(Math.max(range[0], to - SPAN)), last = ring.find(to);
    let [v, f] = [0, 0];
    for (let i = first; i < last; i++) {
      v = Math.max(v, Math.abs(ring.at("velocity", i)));
      f = Math.max(f, Math.abs(ring.at("command", i)), Math.abs(ring.at("force", i)));
    }
    const [vmax, fmax] = [this.speed(1e3 * v), this.force(f)];
    const [left, top, right, bottom] = [38, 8, width - 8, height - 30];
    const x = (mm) => left + (0.5 + (0.5 * mm) / vmax) * (right - left);
    const y = (n) => bottom - (0.5 + (0.5 * n) / fmax) * (bottom - top);
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "12px system-ui";
    pen.lineWidth = 1;
    for (const share of [-1, -0.5, 0, 0.5, 1]) {
      pen.strokeStyle = share === 0 ? css("line") : css("soft");
      pen.beginPath();
      pen.moveTo(x(share * vmax), top); pen.lineTo(x(share * vmax), bottom);
      pen.moveTo(left, y(share * fmax)); pen.lineTo(right, y(share * fmax));
      pen.stroke();
      pen.fillStyle = css("quiet");
      pen.textAlign = share === -1 ? "left" : share === 1 ? "right" : "center";
      pen.textBaseline = "top";
      pen.fillText(`${+(share * vmax).toPrecision(3)}`, x(share * vmax), bottom + 3);
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      pen.fillText(`${+(share * fmax).toPrecision(3)}`, left - 4, Math.min(bottom - 4, Math.max(top + 5, y(share * fmax))));
    }
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    pen.fillText("mm/s across, N up", left, height - 3);
    pen.textAlign = "right";
    for (const [name, colour, says, from] of [["force", "force", "load cell", right - 78], ["command", "command", "commanded", right]]) {
      pen.strokeStyle = css(colour);
      pen.fillStyle = css(colour);
      pen.fillText(says, from, height - 3);
      pen.lineWidth = name === "command" ? 2 : 1;
      // older strokes fade
      const slices = 4, step = Math.ceil((last - first) / slices);
      for (let s = 0; s < slices; s++) {
        pen.globalAlpha = 0.25 + (0.75 * (s + 1)) / slices;
        pen.beginPath();
        for (let i = first + s * step; i < Math.min(last, first + (s + 1) * step + 1); i++) pen.lineTo(x(1e3 * ring.at("velocity", i)), y(ring.at(name, i)));
        pen.stroke();
      }
      pen.globalAlpha = 1;
    }
  }
}
