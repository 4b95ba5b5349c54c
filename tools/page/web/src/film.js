// Draws stored trials as a film or a picture, frame by frame, as long as it takes: nobody looks.
// One trial a row; what is done goes back to the program that serves this page.
import { GIFEncoder, applyPalette, quantize } from "gifenc";
import { ArrayBufferTarget, Muxer } from "webm-muxer";
import { parseMjcf } from "./mjcf.js";
import { unpack } from "./unpack.js";
import { View } from "./view.js";

const kInk = "#1f262d", kSoft = "#4a545e", kBad = "#b33f00", kFont = "system-ui, 'DejaVu Sans', sans-serif";
const kHold_s = 1;            // the last pose, before it begins again
const kColours = 127;         // of a GIF; one more is "as before"
const kSamples = 8;           // frames that choose them
const kBitsPerPixel = 0.12;   // of a WebM
const kCells = 6;             // of a picture, in a row

/** One trial in a view of its own, drawn at any time of it. */
class Row {
  constructor(scene, place, trial, width, height) {
    this.scene = scene;
    this.trial = trial;
    this.holder = document.createElement("div");
    Object.assign(this.holder.style, { width: `${width}px`, height: `${height}px` });
    document.body.append(this.holder);
    this.view = new View(this.holder, place, scene.fixed, scene.joints);
  }
  get length() { return (this.trial.count - 1) * this.scene.dt; }
  /** The whole way that the robot and its reference go, from the side. */
  standAside() { this.view.standAside(this.trial.rows.flatMap((r) => [r.subarray(0, 3), r.subarray(19, 22)])); }
  draw(time) {
    const r = this.trial.rows[Math.min(this.trial.count - 1, Math.max(0, Math.round(time / this.scene.dt)))];
    this.view.show(r.subarray(0, 19), r.subarray(19, 38), [[0, 0, r[38]], [0, 0, r[39]]]);
    this.view.draw();
    return this.view.renderer.domElement;
  }
  get words() { return `trial ${this.trial.n}, cost ${this.trial.cost.toFixed(1)}`; }
}

class Film {
  constructor(scene, options) {
    this.options = options;
    const place = parseMjcf(scene.mjcf);
    const picture = options.kind === "png";
    const cell = picture ? Math.floor(options.width / kCells) : options.width;
    this.width = picture ? cell * kCells : cell;
    this.rows = scene.trials.map((trial) => new Row(scene, place, trial, cell, options.row_height));
    const longest = Math.max(...this.rows.map((row) => row.length));
    this.from = Math.min(options.from, longest);
    this.to = Math.min(options.to > 0 ? options.to : longest, longest);
    this.canvas = document.createElement("canvas");
    this.canvas.width = this.width;
    this.canvas.height = options.row_height * this.rows.length;
    this.c = this.canvas.getContext("2d", { willReadFrequently: true });
  }

  words(text, x, y, size, colour, align = "left") {
    this.c.font = `600 ${size}px ${kFont}`;
    this.c.fillStyle = colour;
    this.c.textAlign = align;
    this.c.fillText(text, x, y);
  }
  caption(row, i, time) {
    const y = i * this.options.row_height + 24;
    this.words(row.words, 12, y, 16, kInk);
    if (row.trial.failed && time >= row.length) this.words(row.trial.end, 12, y + 20, 14, kBad);
    if (i > 0) { this.c.fillStyle = "#ffffff"; this.c.fillRect(0, i * this.options.row_height - 1, this.width, 2); }
  }
  frame(time) {
    this.rows.forEach((row, i) => {
      this.c.drawImage(row.draw(time), 0, i * this.options.row_height);
      this.caption(row, i, time);
    });
    this.words(`${Math.min(time, this.to).toFixed(1)} s`, this.width - 12, 24, 14, kSoft, "right");
  }
  /** Moments of the trials side by side. */
  strip() {
    const cell = this.width / kCells;
    this.rows.forEach((row, i) => {
      for (let k = 0; k < kCells; ++k) {
        const time = this.from + (this.to - this.from) * k / (kCells - 1);
        row.view.jump(row.trial.rows[Math.min(row.trial.count - 1, Math.round(time / row.scene.dt))]);
        this.c.drawImage(row.draw(time), k * cell, i * this.options.row_height);
        this.words(`${time.toFixed(1)} s`, (k + 1) * cell - 10, (i + 1) * this.options.row_height - 10, 13, kSoft, "right");
      }
      this.caption(row, i, this.to);
    });
  }
  *times() {
    const count = Math.round((this.to - this.from + kHold_s) * this.options.fps);
    for (let k = 0; k <= count; ++k) yield Math.min(this.from + k / this.options.fps, this.to);
  }
}

// --- what it is written as -----------------------------------------------------------------------

async function png(film) {
  film.strip();
  const blob = await new Promise((made) => film.canvas.toBlob(made, "image/png"));
  return blob.arrayBuffer();
}

function pixelsAt(film, time) {
  film.frame(time);
  return film.c.getImageData(0, 0, film.canvas.width, film.canvas.height).data;
}

/** One palette for all frames, and only what has changed: a small file, and still still. */
async function gif(film, told) {
  const { width, height } = film.canvas, samples = new Uint8Array(4 * width * height * kSamples / 4);
  for (let k = 0; k < kSamples; ++k) {
    const pixels = pixelsAt(film, film.from + (film.to - film.from) * k / (kSamples - 1));
    for (let from = 4 * (k % 4), to = k * width * height; from < pixels.length; from += 16, to += 4)
      samples.set(pixels.subarray(from, from + 4), to);
  }
  const palette = quantize(samples, kColours, { format: "rgb565" });
  const as_before = palette.length;
  palette.push([255, 255, 255]);
  const out = GIFEncoder(), delay = 10 * Math.round(100 / film.options.fps);
  let before;
  for (const time of film.times()) {
    const whole = applyPalette(pixelsAt(film, time), palette.slice(0, as_before), "rgb565");
    const changed = before ? whole.map((v, i) => (v === before[i] ? as_before : v)) : whole;
    out.writeFrame(changed, width, height, { palette: before ? undefined : palette, delay, repeat: 0,
      transparent: before !== undefined, transparentIndex: as_before, dispose: 1 });
    before = whole;
    await told(time);
  }
  out.finish();
  return out.bytes();
}

async function webm(film, told) {
  const { width, height } = film.canvas, fps = film.options.fps;
  const target = new ArrayBufferTarget();
  const muxer = new Muxer({ target, video: { codec: "V_VP8", width, height, frameRate: fps } });
  let broken;
  const encoder = new VideoEncoder({
    output: (chunk, about) => muxer.addVideoChunk(chunk, about), error: (e) => (broken = e) });
  encoder.configure({ codec: "vp8", width, height, framerate: fps, bitrate: kBitsPerPixel * width * height * fps });
  let k = 0;
  for (const time of film.times()) {
    film.frame(time);
    const duration = Math.round(1e6 / fps), frame = new VideoFrame(film.canvas, { timestamp: k * duration, duration });
    encoder.encode(frame, { keyFrame: k++ % Math.round(4 * fps) === 0 });
    frame.close();
    while (encoder.encodeQueueSize > 4) await new Promise((later) => setTimeout(later, 5));
    if (broken) throw broken;
    await told(time);
  }
  await encoder.flush();
  muxer.finalize();
  return target.buffer;
}

const kWriters = { png, gif, webm };
const send = (name, body) => fetch(`/take/${name}${location.search}`, { method: "POST", body });

export async function film(packed, options) {
  try {
    const made = new Film(unpack(packed), options);
    if (options.kind !== "png") made.rows.forEach((row) => row.standAside());
    let told = -1;
    const tell = async (time) => {  // also lets the browser breathe
      const percent = Math.floor(100 * (time - made.from) / Math.max(1e-9, made.to - made.from));
      if (percent > told) await send("progress", String(told = percent));
    };
    await send("done", await kWriters[options.kind](made, tell));
  } catch (error) {
    await send("failed", String(error?.stack ?? error));
  }
}

window.sansoPage = { film };
