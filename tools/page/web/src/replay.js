// The replay of a report: stored trials, one or two side by side, on one clock. The data are packed
// by tools/page/replay_data.cpp: JSON in front, then 16-bit numbers, each row the change to the one
// before.
import { parseMjcf } from "./mjcf.js";
import { Strip, makeStrips } from "./strips.js";
import { View } from "./view.js";

export function unpack(bytes) {
  const head = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  const text = new TextDecoder().decode(bytes.subarray(4, 4 + head));
  const scene = JSON.parse(text);
  const words = new Int16Array(bytes.slice(4 + head).buffer);
  let at = 0;
  for (const trial of scene.trials) {
    trial.rows = Array.from({ length: trial.count }, () => new Float32Array(scene.columns.length));
    for (let c = 0; c < scene.columns.length; ++c)
      for (let k = 0, sum = 0; k < trial.count; ++k) {
        sum = (sum + words[at++]) << 16 >> 16;  // wraps as the writer's does
        trial.rows[k][c] = trial.low[c] + (sum + 32768) * trial.step[c];
      }
  }
  return scene;
}

const kUpdates = [0.25, 0.5, 1, 2];

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
    this.time = 0;
    this.speed = 1;
    const sides = document.createElement("div");
    sides.className = "sides";
    holder.append(sides);
    this.sides = [0, 1].map((i) => new Side(this, i, sides));
    this.addTransport(holder);
    const strips = document.createElement("div");
    strips.className = "replay-strips";
    holder.append(strips);
    this.strips = makeStrips(strips);
    this.strips.height.options.lines = [{ name: "1st", color: "#0072b2" },
      { name: "ref", color: "#e69f00", text: "#8a5f00" }, { name: "2nd", color: "#d55e00" }];
    this.choose(0, scene.first);
    this.choose(1, scene.second);
    const loop = (now) => { this.advance(now); requestAnimationFrame(loop); };
    requestAnimationFrame(loop);
  }

  addTransport(holder) {
    const bar = document.createElement("div");
    bar.className = "transport";
    this.button = document.createElement("button");
    this.button.textContent = "pause";
    this.playing = true;
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider = document.createElement("input");
    Object.assign(this.slider, { type: "range", min: 0, step: this.scene.dt });
    this.slider.setAttribute("aria-label", "time in the trial");
    this.slider.addEventListener("input", () => { this.play(false); this.seek(Number(this.slider.value)); });
    const speed = document.createElement("select");
    speed.setAttribute("aria-label", "speed");
    for (const v of kUpdates) speed.add(new Option(`${v}×`, v));
    speed.value = 1;
    speed.addEventListener("change", () => (this.speed = Number(speed.value)));
    this.clock = document.createElement("output");
    bar.append(this.button, this.slider, this.clock, speed);
    holder.append(bar);
  }

  play(on) {
    this.playing = on;
    this.button.textContent = on ? "pause" : "play";
  }
  trial(i) { return this.scene.trials[this.chosen[i]]; }
  choose(i, index) {
    this.chosen[i] = index;
    this.sides[i].select.value = index;
    this.sides[i].holder.hidden = index < 0;
    if (index >= 0) this.sides[i].view.resize();
    const longest = Math.max(...[0, 1].filter((k) => this.chosen[k] >= 0).map((k) => this.trial(k).count));
    this.length = (longest - 1) * this.scene.dt;
    this.slider.max = this.length;
    this.fillStrips();
    this.seek(Math.min(this.time, this.length));
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
  seek(time) {
    this.time = time;
    this.slider.value = time;
    this.clock.textContent = `${time.toFixed(2)} s`;
    [0, 1].forEach((i) => this.chosen[i] >= 0 && this.sides[i].show(this.trial(i), time));
    for (const strip of Object.values(this.strips)) strip.draw(0, this.length, time);
  }
  advance(now) {
    const passed = Math.min(0.1, (now - (this.last ?? now)) / 1000);
    this.last = now;
    if (!this.playing) { this.sides.forEach((s) => s.view.drawIfNew()); return; }
    const next = this.time + passed * this.speed;
    this.seek(next > this.length + 0.5 ? 0 : Math.min(next, this.length + 0.5));
  }
}

export function replay(holder, packed) {
  const made = new Replay(holder, unpack(packed));
  window.sansoReplay = made;  // for tests and films: play(), seek(), choose()
}
