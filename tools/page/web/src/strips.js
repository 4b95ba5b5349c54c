// Curves beside the robot, drawn on canvases: a time strip with several lines or stacked shares, and
// bars of the cost over trials.

const kInk = "#4a545e", kGridLine = "#dfe4e9", kFont = "11px system-ui, 'DejaVu Sans', sans-serif";
const kBlue = "#0072b2", kRed = "#d55e00";

const short = (v) => String(Number(Math.abs(v) >= 100 ? v.toFixed(0) : Math.abs(v) >= 10 ? v.toFixed(1) : v.toFixed(2)));

class Panel {
  constructor(holder, title) {
    this.element = document.createElement("div");
    this.element.className = "strip";
    const head = document.createElement("div");
    head.className = "strip-head";
    const name = document.createElement("span");
    name.textContent = title;
    this.value = document.createElement("b");
    head.append(name, this.value);
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    this.element.append(head, this.canvas);
    holder.append(this.element);
  }
  begin() {
    const ratio = Math.min(2, window.devicePixelRatio);
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(w * ratio)) this.canvas.width = Math.round(w * ratio);
    if (this.canvas.height !== Math.round(h * ratio)) this.canvas.height = Math.round(h * ratio);
    const c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, w, h);
    c.font = kFont;
    return { c, w, h };
  }
}

export class Strip extends Panel {
  /** options: lines [{name, color}], min, max (of the axis; they widen), limit, most (of the axis),
      stacked, unit, digits */
  constructor(holder, title, options) {
    super(holder, title);
    this.options = options;
    this.rows = [];
  }
  clear() { this.rows = []; }
  /** Values may be null: a gap. A clock that goes back is another robot's: what was before goes. */
  push(t, values) {
    if (this.rows.length > 0 && t < this.rows.at(-1)[0]) this.clear();
    this.rows.push([t, ...values]);
  }
  forgetBefore(t) {
    let n = 0;
    while (n < this.rows.length && this.rows[n][0] < t) ++n;
    if (n > 50) this.rows.splice(0, n);
  }

  range() {
    let { min, max, limit } = this.options;
    if (this.options.stacked) return [0, 1];
    for (const row of this.rows)
      for (const v of row.slice(1)) if (v != null) { min = Math.min(min, v); max = Math.max(max, v); }
    if (limit != null) max = Math.max(max, 1.1 * limit);
    if (this.options.most != null) max = Math.min(max, this.options.most);
    return [min, max + 1e-9];
  }

  draw(from, to, cursor) {
    const { c, w, h } = this.begin();
    const [min, max] = this.range();
    const left = 34, x = (t) => left + (w - left) * (t - from) / Math.max(1e-9, to - from);
    const y = (v) => h - 4 - (h - 10) * Math.min(1, (v - min) / (max - min));
    c.strokeStyle = kGridLine;
    c.fillStyle = kInk;
    c.textAlign = "right";
    for (const v of [min, this.options.limit ?? max]) {
      c.beginPath(); c.moveTo(left, y(v)); c.lineTo(w, y(v)); c.stroke();
      c.fillText(this.options.stacked ? `${100 * v}%` : short(v), left - 4, y(v) + (v === min ? 0 : 8));
    }
    if (this.options.limit != null) this.limitLine(c, y(this.options.limit), left, w);
    const rows = this.rows.filter((r) => r[0] >= from && r[0] <= to);
    if (this.options.stacked) this.drawShares(c, rows, x, y); else this.drawLines(c, rows, x, y);
    if (cursor != null) {
      c.strokeStyle = kInk;
      c.beginPath(); c.moveTo(x(cursor), 0); c.lineTo(x(cursor), h); c.stroke();
    }
    this.tell(rows, cursor);
  }

  limitLine(c, y, left, w) {
    c.save();
    c.strokeStyle = kRed;
    c.setLineDash([4, 3]);
    c.beginPath(); c.moveTo(left, y); c.lineTo(w, y); c.stroke();
    c.restore();
  }
  drawLines(c, rows, x, y) {
    this.options.lines.forEach((line, i) => {
      c.strokeStyle = line.color;
      c.lineWidth = 1.6;
      c.beginPath();
      let pen = false;
      for (const row of rows) {
        const v = row[i + 1];
        if (v == null) { pen = false; continue; }
        if (pen) c.lineTo(x(row[0]), y(v)); else c.moveTo(x(row[0]), y(v));
        pen = true;
      }
      c.stroke();
      c.lineWidth = 1;
    });
  }
  drawShares(c, rows, x, y) {
    const stack = rows.map((r) => {
      const sum = r.slice(1).reduce((a, v) => a + (v ?? 0), 0);
      let below = 0;
      return [r[0], 0, ...r.slice(1).map((v) => (below += sum > 0 ? v / sum : 0))];
    });
    this.options.lines.forEach((line, i) => {
      c.fillStyle = line.color;
      c.beginPath();
      stack.forEach((r) => c.lineTo(x(r[0]), y(r[i + 2])));
      [...stack].reverse().forEach((r) => c.lineTo(x(r[0]), y(r[i + 1])));
      c.fill();
    });
  }
  /** The numbers at the cursor (or the newest), each in its line's colour. */
  tell(rows, cursor) {
    const row = cursor == null ? rows.at(-1) : rows.findLast((r) => r[0] <= cursor);
    const parts = this.options.lines.map((line, i) => {
      const span = document.createElement("span");
      const v = row?.[i + 1];
      span.style.color = line.text ?? line.color;
      span.textContent = (line.name ? `${line.name} ` : "") + (v == null ? "–" : v.toFixed(this.options.digits ?? 2));
      return span;
    });
    this.value.replaceChildren(...parts, ` ${this.options.unit ?? ""}`);
  }
}

export class Bars extends Panel {
  /** One bar a trial on a logarithmic axis; failed ones in red, the running one outlined. */
  draw(trials, running) {
    const { c, w, h } = this.begin();
    const all = running == null ? trials : [...trials, { cost: running, running: true }];
    const costs = all.map((t) => Math.max(0.1, t.cost));
    const low = Math.log10(Math.min(1, ...costs)), high = Math.log10(1.2 * Math.max(10, ...costs));
    const left = 34, step = (w - left) / Math.max(10, all.length);
    const height = (cost) => (h - 10) * (Math.log10(cost) - low) / (high - low);
    c.fillStyle = kInk;
    c.textAlign = "right";
    for (let d = Math.ceil(low); d <= high; ++d) {
      c.fillText(short(10 ** d), left - 4, h - 2 - height(10 ** d) + (d > low ? 4 : 0));
      c.fillStyle = kGridLine;
      c.fillRect(left, h - 4 - height(10 ** d), w - left, 1);
      c.fillStyle = kInk;
    }
    all.forEach((t, i) => {
      const top = Math.max(2, height(costs[i]));
      c.fillStyle = c.strokeStyle = t.failed ? kRed : kBlue;
      const bar = [left + i * step + 1, h - 4 - top, Math.max(1, step - 2), top];
      if (t.running) c.strokeRect(...bar); else c.fillRect(...bar);
    });
    const best = trials.filter((t) => !t.failed).reduce((b, t) => Math.min(b, t.cost), Infinity);
    this.value.textContent = trials.length === 0 ? "" :
      `last ${short(trials.at(-1).cost)}` + (best < Infinity ? ` · best ${short(best)}` : "");
  }
}

/** The strips that live page and replay share, in one column. */
export function makeStrips(holder) {
  const layers = [
    { name: "upper", color: "#56b4e9", text: "#0072b2" }, { name: "middle", color: "#e69f00", text: "#8a5f00" },
    { name: "lower", color: "#b9c2cc", text: "#5d6873" },
  ];
  return {
    height: new Strip(holder, "base height", {
      lines: [{ name: "", color: kBlue }, { name: "ref", color: "#e69f00", text: "#8a5f00" }], min: 0.2, max: 0.3,
      unit: "m", digits: 3 }),
    layers: new Strip(holder, "layers", { lines: layers, stacked: true, min: 0, max: 1 }),
    update: new Strip(holder, "policy update, of 60 ms", { lines: [{ name: "", color: kBlue }], min: 0, max: 10,
      limit: 60, most: 120, unit: "ms", digits: 1 }),
  };
}
