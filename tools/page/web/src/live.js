// The live page: frames come as server-sent events, the robot moves with them, and the buttons ask
// the program that serves the page.
import { parseMjcf } from "./mjcf.js";
import { Bars, Strip, makeStrips } from "./strips.js";
import { View } from "./view.js";

const kWindow_s = 20, kSilence_ms = 2000;
const kIdle = 2;
const kStates = ["boot", "self-test", "idle", "standing up", "hold", "running", "stopping", "FAULT"];
const token = new URLSearchParams(location.search).get("token") ?? "";
const withToken = (path) => `${path}?token=${encodeURIComponent(token)}`;
const $ = (id) => document.getElementById(id);

class Live {
  constructor(scene) {
    this.scene = scene;
    this.trials = [];
    this.lastFault = 0;
    try {
      this.view = new View($("view"), parseMjcf(scene.mjcf), scene.fixed, scene.joints, scene.urdf);
    } catch (error) {
      $("view").dataset.note = `No picture of the robot here (${error.message}); the curves go on.`;
    }
    this.bars = new Bars($("strips"), "cost of each trial");
    this.strips = makeStrips($("strips"));
    this.strips.bus = new Strip($("strips"), "bus errors", {
      lines: [{ name: "lost", color: "#0072b2" }, { name: "damaged", color: "#d55e00" }], min: 0, max: 5, digits: 0 });
    $("what").textContent = `${scene.motion ? scene.motion + " on " : ""}${scene.robot}`;
    for (const note of scene.urdf?.notes ?? []) this.note(`not drawn: ${note}`);
    this.addButtons();
    this.listen();
    const loop = () => { this.view?.drawIfNew(); requestAnimationFrame(loop); };
    loop();
    setInterval(() => this.redraw(), 200);
  }

  listen() {
    const events = new EventSource(withToken("/events"));
    events.addEventListener("frame", (e) => this.frame(JSON.parse(e.data)));
    events.addEventListener("trial", (e) => this.trial(JSON.parse(e.data)));
    events.addEventListener("session", (e) => this.session(JSON.parse(e.data)));
    events.addEventListener("open", () => this.link("connected", true));
    events.addEventListener("error", () => this.link("the program is gone; waiting for it", false));
  }
  link(text, good) {
    $("link").textContent = text;
    $("link").classList.toggle("bad", !good);
  }

  session(s) {
    this.trials = s.trials;
    $("what").textContent = `${s.motion} on ${this.scene.robot}`;
    this.total = s.of;
    this.paused = s.paused;
    this.showPause();
  }
  trial(t) {
    this.trials.push(t);
    if (t.failed) this.note(`trial ${t.n} failed: ${t.end}`);
  }

  frame(f) {
    this.newest = f;
    this.heard = performance.now();
    window.sansoFrame = f;  // for tests, and for the curious
    this.view?.show(f.x, f.r, f.F);
    const { height, layers, update, bus } = this.strips;
    height.push(f.t, [f.s >= kIdle ? f.x[2] : null, f.r?.[2] ?? null]);  // before: no estimate
    layers.push(f.t, f.s === 5 ? f.u : [0, 0, 0]);
    update.push(f.t, [f.up ?? null]);
    bus.push(f.t, f.bus);
    for (const strip of Object.values(this.strips)) strip.forgetBefore(f.t - kWindow_s);
    $("state").textContent = kStates[f.s] ?? f.s;
    $("state").className = `pill s${f.s}`;
    $("trial").textContent = f.n > 0 && f.tt >= 0
      ? `trial ${f.n}${this.total ? " of " + this.total : ""} · ${(f.tt / 100).toFixed(1)} s` : "";
    $("small").textContent = `supply ${f.V.toFixed(1)} V · ${f.T.toFixed(0)} °C${f.cpu > 0 ? ` · tick ${f.cpu} µs` : ""} · late ticks ${f.late}`;
    if (f.f !== this.lastFault) {
      this.lastFault = f.f;
      if (f.f !== 0) this.note(`F${f.f} ${this.scene.faults[f.f] ?? ""}`);
    }
    this.paused = f.paused;
    this.showPause();
  }

  note(text) {
    const li = document.createElement("li");
    const time = document.createElement("time");
    time.textContent = new Date().toLocaleTimeString();
    li.append(time, " ", text);
    $("notes").prepend(li);
    while ($("notes").children.length > 20) $("notes").lastChild.remove();
  }

  redraw() {
    if (!this.newest) return;
    const now = this.newest.t;
    this.bars.draw(this.trials, this.newest.tt >= 0 ? this.newest.cost : null);
    for (const strip of Object.values(this.strips)) strip.draw(now - kWindow_s, now);
    if (performance.now() - this.heard > kSilence_ms) this.link("nothing heard from the controller", false);
    else this.link("connected", true);
  }

  // --- buttons ---------------------------------------------------------------------------------
  addButtons() {
    if (!this.scene.control) {
      $("buttons").remove();
      return;
    }
    const can = new Set(this.scene.can);
    for (const button of document.querySelectorAll("#buttons [data-do]")) {
      button.hidden = !can.has(button.dataset.do);
      button.addEventListener("click", () => this.ask({ do: button.dataset.do }));
    }
    for (const name of this.scene.motions ?? []) $("motion").add(new Option(name, name));
    $("motion").hidden = !can.has("next");
    $("motion").value = "";
    $("motion").addEventListener("change", () => this.ask({ do: "next", motion: $("motion").value }));
  }
  showPause() {
    const pause = document.querySelector("[data-do=stop]"), start = document.querySelector("[data-do=start]");
    if (pause) pause.disabled = this.paused === true;
    if (start) start.disabled = this.paused === false;
  }
  async ask(what) {
    try {
      const answer = await fetch(withToken("/control"), {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(what) });
      const text = await answer.text();
      this.note(`${what.do}${what.motion ? " " + what.motion : ""}: ${text}`);
    } catch (error) {
      this.note(`${what.do}: not sent, ${error.message}`);
    }
  }
}

export async function live() {
  const answer = await fetch(withToken("/scene.json"));
  if (!answer.ok) throw new Error(`the program refuses: ${await answer.text()}`);
  window.sansoLive = new Live(await answer.json());  // for tests, and for the curious
}
