// Play, slider, clock and speed of whatever runs along a time; a report has one of them.

const kSpeeds = [0.25, 0.5, 1, 2], kLongestStep_s = 0.1, kHold_s = 0.5;  // the end, before it begins again

export class Transport {
  /** `show(time)` is called whenever the time is another one, `idle()` when it stands still;
      `words(time)` are the clock's. */
  constructor(holder, { step, label, show, idle, words }) {
    Object.assign(this, { show, idle, words: words ?? ((time) => `${time.toFixed(2)} s`) });
    this.time = this.length = 0;
    this.speed = 1;
    const bar = document.createElement("div");
    bar.className = "transport";
    this.button = document.createElement("button");
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider = document.createElement("input");
    Object.assign(this.slider, { type: "range", min: 0, step });
    this.slider.setAttribute("aria-label", label);
    this.slider.addEventListener("input", () => { this.play(false); this.seek(Number(this.slider.value)); });
    const speed = document.createElement("select");
    speed.setAttribute("aria-label", "speed");
    for (const v of kSpeeds) speed.add(new Option(`${v}×`, v));
    speed.value = 1;
    speed.addEventListener("change", () => (this.speed = Number(speed.value)));
    this.clock = document.createElement("output");
    bar.append(this.button, this.slider, this.clock, speed);
    holder.append(bar);
    this.play(true);
  }
  start() {
    const loop = (now) => { this.advance(now); requestAnimationFrame(loop); };
    requestAnimationFrame(loop);
  }
  setLength(length) {
    this.length = this.slider.max = length;
    this.seek(Math.min(this.time, length));
  }
  play(on) {
    this.playing = on;
    this.button.textContent = on ? "pause" : "play";
  }
  seek(time) {
    this.time = time;
    this.slider.value = time;
    this.clock.textContent = this.words(time);
    this.show(time);
  }
  advance(now) {
    const passed = Math.min(kLongestStep_s, (now - (this.last ?? now)) / 1000);
    this.last = now;
    if (!this.playing) { this.idle(); return; }
    const next = this.time + passed * this.speed;
    this.seek(next > this.length + kHold_s ? 0 : Math.min(next, this.length + kHold_s));
  }
}
