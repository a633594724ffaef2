// Ring buffer of the last two minutes. Drawn as minimum and maximum of each column of pixels.

const CAPACITY = 1 << 17;
const MASK = CAPACITY - 1;

/** Channels in the order of a sample on the wire. */
export const CHANNELS = ["position", "velocity", "force", "command", "reference"];

export class Ring {
  constructor() {
    this.time = new Float64Array(CAPACITY);
    for (const name of CHANNELS) this[name] = new Float32Array(CAPACITY);
    this.mode = new Uint8Array(CAPACITY);
    this.received = 0; // number of samples received by this page
    this.clear(-1, 0.001);
  }

  /** Time begins anew. */
  clear(epoch, period) {
    this.epoch = epoch;
    this.period = period;
    this.end = 0; // number of samples since the start of the stream
    this.lost = 0; // lost on the line, counted by the server
    this.skipped = 0; // batches lost between server and page
    this.next = null;
  }

  get start() { return Math.max(0, this.end - CAPACITY); }
  get newest() { return this.end ? this.time[(this.end - 1) & MASK] : 0; }
  at(name, index) { return this[name][index & MASK]; }

  /** Puts a batch in. */
  push({ view, epoch, count, number, lost }) {
    if (epoch !== this.epoch) this.clear(epoch, this.period);
    if (this.next !== null) this.skipped += (number - this.next) >>> 0;
    this.next = (number + 1) >>> 0;
    this.lost = lost;
    for (let k = 0, at = 16; k < count; k++, at += 32) {
      const i = this.end++ & MASK;
      this.time[i] = view.getFloat64(at, true);
      for (let c = 0; c < CHANNELS.length; c++) this[CHANNELS[c]][i] = view.getFloat32(at + 8 + 4 * c, true);
      const mode = (this.mode[i] = view.getUint8(at + 28));
      // a handle that is not driven has no reference
      if (mode !== 2 && mode !== 3) this.reference[i] = NaN;
    }
    this.received += count;
  }

  /** Index of the first sample at `t` or later. */
  find(t) {
    let [low, high] = [this.start, this.end];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle & MASK] < t) low = middle + 1; else high = middle;
    }
    return low;
  }

  /** Index of the sample nearest to `t`, or -1. */
  nearest(t) {
    const after = this.find(t);
    if (this.end === this.start) return -1;
    if (after >= this.end) return this.end - 1;
    if (after > this.start && t - this.time[(after - 1) & MASK] < this.time[after & MASK] - t) return after - 1;
    return after;
  }

  /**
   * [times, ...values] of some channels between two times for `columns` columns of pixels. Where a column has more
   * than two samples, its least and largest stay, in the order they came; a gap in time stays a gap.
   */
  picture(names, from, to, columns) {
    const [first, last] = [this.find(from), this.find(to)];
    const out = [[], ...names.map(() => [])];
    const width = (to - from) / columns;
    const gap = 1.5 * this.period;
    if (width < 2 * this.period) {
      for (let i = first; i < last; i++) {
        const t = this.time[i & MASK];
        if (i > first && t - this.time[(i - 1) & MASK] > gap) { out[0].push(t - this.period); names.forEach((_, c) => out[c + 1].push(null)); }
        out[0].push(t);
        names.forEach((name, c) => out[c + 1].push(this[name][i & MASK]));
      }
      return out;
    }
    // columns are counted from time zero, so that they do not flicker as the picture moves
    for (let i = first; i < last;) {
      const column = Math.floor(this.time[i & MASK] / width);
      const end = Math.min(last, Math.max(i + 1, this.find((column + 1) * width)));
      const t = column * width;
      if (i > first && this.time[i & MASK] - this.time[(i - 1) & MASK] > Math.max(gap, width)) {
        out[0].push(out[0].at(-1) + 1e-6); // between the last column and this one: times never decrease
        names.forEach((_, c) => out[c + 1].push(null));
      }
      out[0].push(t, t + 0.5 * width);
      names.forEach((name, c) => {
        const values = this[name];
        let low = i, high = i;
        for (let k = i + 1; k < end; k++) {
          const value = values[k & MASK];
          if (value < values[low & MASK]) low = k; else if (value > values[high & MASK]) high = k;
        }
        out[c + 1].push(values[Math.min(low, high) & MASK], values[Math.max(low, high) & MASK]);
      });
      i = end;
    }
    return out;
  }

  /** Worst and rms deviation of the time between samples over the last `count`, µs; samples a second. */
  jitter(count) {
    const first = Math.max(this.start, this.end - count);
    let [worst, sum, n] = [0, 0, 0];
    for (let i = first + 1; i < this.end; i++) {
      const off = this.time[i & MASK] - this.time[(i - 1) & MASK] - this.period;
      if (Math.abs(off) > 0.5 * this.period) continue; // a lost sample, counted elsewhere
      worst = Math.max(worst, Math.abs(off));
      sum += off * off;
      n++;
    }
    return n ? { worst: 1e6 * worst, rms: 1e6 * Math.sqrt(sum / n) } : null;
  }
}
