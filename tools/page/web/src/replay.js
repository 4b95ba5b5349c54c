// The replay of a report: stored trials, one or two side by side, on one clock.
import { parseMjcf } from "./mjcf.js";
import { makeStrips } from "./strips.js";
import { Transport } from "./transport.js";
import { unpack } from "./unpack.js";
import { View } from "./view.js";

class Side {
  constructor(replay, index, holder) {
    this.replay = replay;
    const scene = replay.scene;
    this.root = document.createElement("div");
    this.root.className = "side";
    this.select = document.createElement("select");
    this.select.setAttribute("aria-label", index === 0 ? "trial" : "second trial");
    if (index > 0) this.select.add(new Option("no second trial", -1));
    scene.trials.forEach((t, i) => this.select.add(new Option(
      `trial ${t.n}: cost ${t.cost.toFixed(2)}${t.failed ? ", failed: " + t.end : ""}`, i)));
    this.select.addEventListener("change", () => this.replay.choose(index, Number(this.select.value)));
    this.holder = document.createElement("div");
    this.holder.className = "replay-view";
    this.root.append(this.select, this.holder);
    holder.append(this.root);
    this.view = new View(this.holder, replay.place, scene.fixed, scene.joints);
  }
  show(trial, time) {
    const rows = trial.rows;
    const k = Math.min(rows.length - 1, Math.max(0, Math.round(time / this.replay.scene.dt)));
    const r = rows[k];
    const force = (v) => [0, 0, v];
    this.view.show(r.subarray(0, 19), r.subarray(19, 38), [force(r[38]), force(r[39])]);
    this.view.drawIfNew();
  }
}

class Replay {
  constructor(holder, scene) {
    this.scene = scene;
    this.place = parseMjcf(scene.mjcf);
    this.chosen = [0, -1];
    const sides = document.createElement("div");
    sides.className = "sides";
    holder.append(sides);
    this.sides = [0, 1].map((i) => new Side(this, i, sides));
    this.transport = new Transport(holder, {
      step: scene.dt, label: "time in the trial", show: (time) => this.show(time),
      idle: () => this.sides.forEach((s) => s.view.drawIfNew()) });
    const strips = document.createElement("div");
    strips.className = "replay-strips";
    holder.append(strips);
    this.strips = makeStrips(strips);
    if (scene.trials.length < 2) this.showOneAlone(sides);
    this.strips.height.options.lines = [{ name: "1st", color: "#0072b2" },
      { name: "ref", color: "#e69f00", text: "#8a5f00" }, { name: "2nd", color: "#d55e00" }];
    this.choose(0, scene.first);
    this.choose(1, scene.second);
    this.transport.start();
  }

  /** There is nothing to choose: one trial, or the preview of a motion that nobody has tried yet. */
  showOneAlone(sides) {
    sides.classList.add("alone");
    this.sides[1].root.hidden = true;
    for (const side of this.sides) side.select.hidden = this.scene.preview === true;
  }
  get time() { return this.transport.time; }
  get length() { return this.transport.length; }
  play(on) { this.transport.play(on); }
  seek(time) { this.transport.seek(time); }
  trial(i) { return this.scene.trials[this.chosen[i]]; }
  choose(i, index) {
    this.chosen[i] = index;
    this.sides[i].select.value = index;
    this.sides[i].holder.hidden = index < 0;
    if (index >= 0) this.sides[i].view.resize();
    const longest = Math.max(...[0, 1].filter((k) => this.chosen[k] >= 0).map((k) => this.trial(k).count));
    this.fillStrips();
    this.transport.setLength((longest - 1) * this.scene.dt);
  }
  fillStrips() {
    const first = this.trial(0), second = this.chosen[1] >= 0 ? this.trial(1) : undefined;
    for (const strip of Object.values(this.strips)) strip.clear();
    const n = Math.max(first.count, second?.count ?? 0);
    for (let k = 0; k < n; ++k) {
      const a = first.rows[k], b = second?.rows[k], t = k * this.scene.dt;
      this.strips.height.push(t, [a?.[2] ?? null, a?.[21] ?? null, b?.[2] ?? null]);
      if (!a) continue;
      this.strips.layers.push(t, [a[40], a[41], a[42]]);
      this.strips.update.push(t, [a[43] > 0 ? a[43] : null]);
    }
  }
  show(time) {
    [0, 1].forEach((i) => this.chosen[i] >= 0 && this.sides[i].show(this.trial(i), time));
    for (const strip of Object.values(this.strips)) strip.draw(0, this.length, time);
  }
}

export function replay(holder, packed) {
  const made = new Replay(holder, unpack(packed));
  window.sansoReplay = made;  // for tests and films: play(), seek(), choose()
}
