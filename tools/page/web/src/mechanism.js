// The robot of a diagnosis: the recorded motion as a solid figure, simulations of it as ghosts or
// beside it, and the joint or link that the diagnosis found lit.
import * as THREE from "three";
import { LinkRobot, kLit } from "./links.js";
import { Room, tiles } from "./room.js";
import { Strip } from "./strips.js";
import { Transport } from "./transport.js";
import { unpack } from "./unpack.js";

const kColours = [0xf2f4f6, 0xe69f00, 0x0072b2];  // recorded, nominal, patched
const kTexts = ["#1f262d", "#8a5f00", "#0072b2"];
const kFactors = [1, 3, 10, 30, 100];
const kSamples = 40;                              // instants that say how much room there must be
const kLeastSize_m = 0.02, kRobot_m = 0.5, kApart = 1.15, kLeastGap = 0.3, kMargin = 0.08;
const kBase = 7;

const css = (colour) => `#${colour.toString(16).padStart(6, "0")}`;

function element(tag, parent, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  parent?.append(made);
  return made;
}

/** Where a row's numbers are: time, then each figure's base (if it floats) and joints. */
class Layout {
  constructor(scene) {
    this.base = scene.floating ? kBase : 0;
    this.width = this.base + scene.joints.length;
  }
  baseOf(row, figure) {
    const from = 1 + figure * this.width;
    return this.base ? row.subarray(from, from + kBase) : undefined;
  }
  joint(row, figure, j) { return row[1 + figure * this.width + this.base + j]; }
}

/** The base of a figure, its difference from the recorded one enlarged. */
function enlarged(recorded, base, factor) {
  const turn = (b) => new THREE.Quaternion(b[4], b[5], b[6], b[3]).normalize();
  const difference = turn(recorded).conjugate().multiply(turn(base));
  if (difference.w < 0) difference.set(-difference.x, -difference.y, -difference.z, -difference.w);
  const axis = new THREE.Vector3(difference.x, difference.y, difference.z), half = Math.atan2(axis.length(), difference.w);
  const more = Math.min(2 * half * factor, Math.PI);
  const q = turn(recorded);
  if (half > 1e-9) q.multiply(new THREE.Quaternion().setFromAxisAngle(axis.normalize(), more));
  return [0, 1, 2].map((i) => recorded[i] + factor * (base[i] - recorded[i])).concat([q.w, q.x, q.y, q.z]);
}

class Stage extends Room {
  constructor(holder, scene, layout) {
    const robots = scene.figures.map(() => new LinkRobot(scene.links));
    const box = new THREE.Box3();
    const put = (robot, row, figure) => robot.setState(
      scene.joints.map((_, j) => layout.joint(row, figure, j)), scene.joints, layout.baseOf(row, figure));
    for (const trial of scene.trials)
      for (let k = 0; k < trial.count; k += Math.max(1, Math.floor(trial.count / kSamples)))
        robots.forEach((robot, figure) => {
          put(robot, trial.rows[k], figure);
          robot.extend(box);
          for (const joint of robot.joints.values())
            joint.range = [Math.min(joint.range[0], joint.q), Math.max(joint.range[1], joint.q)];
        });
    const size = Math.max(kLeastSize_m, box.getSize(new THREE.Vector3()).length());
    super(holder, size / kRobot_m);
    Object.assign(this, { robots, box, size, layout, names: scene.joints });
    const lit = new Set(scene.lit.map((l) => l.name));
    robots.forEach((robot, figure) => robot.dress(size, figure > 0 ? kColours[figure] : undefined, lit));
    for (const robot of robots) this.scene.add(robot.root);
    this.addFloor(scene.ground);
    this.arrange(false);
    this.open();
  }
  /** `height`: of the ground, where it is known. */
  addFloor(height) {
    const span = 40 * this.size, tile = this.size > 1.5 ? 1 : this.size > 0.15 ? 0.1 : 0.01;
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(span, span),
      new THREE.MeshStandardMaterial({ color: 0xe4e8ec, roughness: 0.95, map: tiles(Math.round(span / tile)) }));
    const middle = this.box.getCenter(new THREE.Vector3());
    floor.position.set(middle.x, middle.y, height ?? this.box.min.z - 0.08 * this.size);
    floor.receiveShadow = true;
    this.scene.add(floor);
  }

  /** Figures in each other's place or side by side, along the wider of the two ways that the motion
      takes; the camera looks across it and sees all of them. */
  arrange(apart) {
    const extent = this.box.getSize(new THREE.Vector3()), centre = this.box.getCenter(new THREE.Vector3());
    const wide = Math.max(extent.x, extent.y), deep = Math.min(extent.x, extent.y);
    this.way = extent.x >= extent.y ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const across = extent.x >= extent.y ? new THREE.Vector3(0, -1, 0) : new THREE.Vector3(1, 0, 0);
    const gap = kApart * Math.max(wide, kLeastGap * this.size), middle = apart ? (this.robots.length - 1) / 2 : 0;
    this.offsets = this.robots.map((_, i) => (apart ? (i - middle) * gap : 0));
    for (const robot of this.robots)
      if (robot.look) Object.assign(robot.look, { opacity: apart ? 1 : 0.4, depthWrite: apart });
    const { clientWidth: w, clientHeight: h } = this.holder;
    const up = Math.tan(THREE.MathUtils.degToRad(0.5 * (w < h ? 42 : 32))), margin = kMargin * this.size;
    const away = 0.5 * deep + Math.max((0.5 * wide + middle * gap + margin) / (up * (w / h || 1)),
                                       (0.5 * extent.z + margin) / up);
    this.controls.target.copy(centre);
    this.camera.position.copy(across).addScaledVector(this.way, 0.25);
    this.camera.position.z = 0.3;
    this.camera.position.normalize().multiplyScalar(away).add(centre);
    this.controls.minDistance = 0.1 * this.size;
    this.controls.maxDistance = 4 * away;
    Object.assign(this.scene.fog, { near: away + 2 * this.size, far: away + 12 * this.size });
    this.camera.far = away + 60 * this.size;
    this.camera.updateProjectionMatrix();
    this.sun.target.position.copy(centre);
    this.sun.position.copy(this.sunFrom).add(centre);
    this.dirty = true;
  }

  /** `factor`: by how much the simulations' differences from the recording are enlarged. */
  show(row, factor, visible) {
    this.robots.forEach((robot, figure) => {
      robot.root.visible = visible[figure];
      const q = this.names.map((_, j) => {
        const recorded = this.layout.joint(row, 0, j);
        return recorded + factor * (this.layout.joint(row, figure, j) - recorded);
      });
      const recorded = this.layout.baseOf(row, 0);
      const base = recorded && enlarged(recorded, this.layout.baseOf(row, figure), factor);
      robot.setState(q, this.names, base);
      robot.root.position.set(...(base ?? [0, 0, 0]).slice(0, 3)).addScaledVector(this.way, this.offsets[figure]);
    });
    this.dirty = true;
  }
}

class Mechanism {
  constructor(holder, scene) {
    this.scene = scene;
    this.layout = new Layout(scene);
    this.visible = scene.figures.map(() => true);
    this.factor = 1;
    this.addChoices(holder);
    this.place = element("div", holder, { className: "replay-view" });
    this.stage = new Stage(this.place, scene, this.layout);
    this.transport = new Transport(holder, {
      step: scene.trials[0].dt, label: "time in the recording", show: (time) => this.show(time),
      idle: () => this.stage.drawIfNew(),
      words: (time) => `${this.row(time)[0].toFixed(2)} s` });
    this.addStrips(holder);
    this.choose(0);
    this.transport.start();
  }

  get trial() { return this.scene.trials[this.chosen]; }
  row(time) {
    const k = Math.round(time / this.trial.dt);
    return this.trial.rows[Math.min(this.trial.count - 1, Math.max(0, k))];
  }
  play(on) { this.transport.play(on); }
  seek(time) { this.transport.seek(time); }
  get time() { return this.transport.time; }
  get length() { return this.transport.length; }

  addChoices(holder) {
    const bar = element("div", holder, { className: "choices" });
    const select = element("select", bar, { ariaLabel: "recording" });
    this.scene.trials.forEach((t, i) => select.add(new Option(t.name, i)));
    select.addEventListener("change", () => this.choose(Number(select.value)));
    this.scene.figures.forEach((name, figure) => {
      const label = element("label", bar);
      const box = element("input", label, { type: "checkbox", checked: true });
      element("i", label).style.background = css(kColours[figure]);
      label.append(name);
      box.addEventListener("change", () => { this.visible[figure] = box.checked; this.again(); });
    });
    if (this.scene.figures.length > 1) {
      const factor = element("select", bar, { ariaLabel: "differences enlarged" });
      for (const k of kFactors) factor.add(new Option(k === 1 ? "differences as they are" : `differences ${k}×`, k));
      factor.addEventListener("change", () => this.enlarge(Number(factor.value)));
      const label = element("label", bar);
      const apart = element("input", label, { type: "checkbox" });
      label.append("side by side");
      apart.addEventListener("change", () => { this.stage.arrange(apart.checked); this.again(); });
    }
    for (const lit of this.scene.lit) {
      const found = element("span", bar, { className: "found" });
      element("i", found).style.background = css(kLit);
      found.append(lit.text);
    }
  }
  /** What can be drawn over time: of one that floats the way of its base first, joints move as recorded. */
  curvesOf(scene) {
    const base = ["height", "x", "y"].map((name, i) => ({ name: `base ${name}`, slides: true,
      of: (row, figure) => this.layout.baseOf(row, figure)[(i + 2) % 3] }));
    const joints = scene.joints.map((name, j) => ({ name, slides: scene.slides[j],
      of: (row, figure) => this.layout.joint(row, figure, j) }));
    return scene.floating ? base.concat(joints) : joints;
  }
  addStrips(holder) {
    const bar = element("div", holder, { className: "choices" });
    this.joint = element("select", bar, { ariaLabel: "what the curves show" });
    this.curves = this.curvesOf(this.scene);
    this.curves.forEach(({ name }, i) => this.joint.add(new Option(name, i)));
    const lit = this.curves.findIndex(({ name }) => this.scene.lit.some((l) => l.joint === name));
    this.joint.value = Math.max(0, lit);
    this.joint.addEventListener("change", () => this.fillStrips());
    bar.hidden = this.curves.length < 2;
    const strips = element("div", holder, { className: "replay-strips two" });
    const lines = this.scene.figures.map((name, i) => ({ name, color: i > 0 ? css(kColours[i]) : kTexts[0], text: kTexts[i] }));
    const open = { min: Infinity, max: -Infinity };
    this.strips = { position: new Strip(strips, "position", { lines, ...open, digits: 3 }) };
    if (lines.length > 1)
      this.strips.error = new Strip(strips, "simulated less recorded", { lines: lines.slice(1), ...open, digits: 2 });
  }
  fillStrips() {
    if (this.curves.length === 0) return;
    const { slides, of } = this.curves[Number(this.joint.value)];
    this.strips.position.options.unit = slides ? "m" : "rad";
    if (this.strips.error) this.strips.error.options.unit = slides ? "mm" : "mrad";
    for (const strip of Object.values(this.strips)) strip.clear();
    this.trial.rows.forEach((row, k) => {
      const all = this.scene.figures.map((_, figure) => of(row, figure));
      this.strips.position.push(k * this.trial.dt, all);
      this.strips.error?.push(k * this.trial.dt, all.slice(1).map((v) => 1000 * (v - all[0])));
    });
    this.again();
  }
  enlarge(factor) { this.factor = factor; this.again(); }
  choose(index) {
    this.chosen = index;
    this.fillStrips();
    this.transport.setLength((this.trial.count - 1) * this.trial.dt);
  }
  again() { this.show(this.transport.time); }
  show(time) {
    this.stage.show(this.row(time), this.factor, this.visible);
    this.stage.drawIfNew();
    if (this.curves.length > 0)
      for (const strip of Object.values(this.strips)) strip.draw(0, this.length, time);
  }
}

export function mechanism(holder, packed) {
  window.sansoMechanism = new Mechanism(holder, unpack(packed));  // for tests: play(), seek(), choose()
}
