// Films and pictures of a session, made as a person makes them and looked at by a browser: right
// size, right length, something in them that moves; and what cannot be made is refused in words.
// Usage: node check_film.mjs SANSO SESSION-FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { openBrowser, patientPage } from "./browser.mjs";

const [sanso, session, shots] = process.argv.slice(2);
const kWidth = 240, kHeight = 160, kFps = 3, kFrom = 1, kTo = 3, kHold_s = 1;

function film(name, ...more) {
  const file = join(shots, name);
  return { file, ...spawnSync(sanso, ["report", session, "--film", file, "--width", kWidth, "--height", kHeight,
    "--fps", kFps, "--from", kFrom, "--to", kTo, ...more].map(String), { encoding: "utf8" }) };
}
function made(name) {
  const done = film(name);
  assert.equal(done.status, 0, done.stderr);
  return readFileSync(done.file);
}

for (const [name, more, words] of [["film.avi", [], /\.webm, \.gif or \.png/], ["f.gif", ["--trials", 1, 9], /trials 1 to 2/],
                                   ["f.gif", ["--browser", "/nowhere"], /not there/]]) {
  const refused = film(name, ...more);
  assert.equal(refused.status, 2);
  assert.match(refused.stderr, words);
}

const browser = await openBrowser();
try {
  const page = await patientPage(browser);
  await page.goto(`file://${resolve("check_film.mjs")}`);  // decoders want to know where they are
  /** What a browser sees of a picture: its size and how much of it is not its background. */
  const seen = (type, bytes) => page.evaluate(async ([type, text]) => {
    const image = new Image();
    image.src = `data:${type};base64,${text}`;
    await image.decode();
    const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    const c = canvas.getContext("2d");
    c.drawImage(image, 0, 0);
    const p = c.getImageData(0, 0, image.width, image.height).data;
    let dark = [0, 0];
    for (let i = 0; i < p.length; i += 4)
      if (p[i] + p[i + 1] + p[i + 2] < 300) ++dark[i < p.length / 2 ? 0 : 1];
    return { width: image.width, height: image.height, dark };
  }, [type, bytes.toString("base64")]);

  const png = await seen("image/png", made("film.png"));
  assert.deepEqual([png.width, png.height], [kWidth, 2 * kHeight]);
  for (const share of png.dark) assert.ok(share > 0.004 * kWidth * kHeight, `an empty row: ${png.dark}`);

  const gif = made("film.gif");
  const first = await seen("image/gif", gif);
  assert.deepEqual([first.width, first.height], [kWidth, 2 * kHeight]);
  const decoded = await page.evaluate(async (text) => {
    const data = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const decoder = new ImageDecoder({ data, type: "image/gif" });
    await decoder.tracks.ready;
    await decoder.completed;
    const grab = async (frameIndex) => {
      const { image } = await decoder.decode({ frameIndex });
      const bytes = new Uint8Array(image.allocationSize());
      await image.copyTo(bytes);
      return bytes;
    };
    const count = decoder.tracks.selectedTrack.frameCount, a = await grab(0), b = await grab(Math.floor(count / 2));
    let changed = 0;
    for (let i = 0; i < a.length; ++i) changed += Math.abs(a[i] - b[i]) > 40 ? 1 : 0;
    return { count, changed };
  }, gif.toString("base64"));
  assert.equal(decoded.count, (kTo - kFrom + kHold_s) * kFps + 1);
  assert.ok(decoded.changed > 200, `nothing moves: ${decoded.changed} numbers of pixels differ`);

  const video = await page.evaluate((text) => new Promise((done, failed) => {
    const v = document.createElement("video");
    v.onloadedmetadata = () => done({ width: v.videoWidth, height: v.videoHeight, duration: v.duration });
    v.onerror = () => failed(new Error(v.error?.message));
    v.src = `data:video/webm;base64,${text}`;
  }), made("film.webm").toString("base64"));
  assert.deepEqual([video.width, video.height], [kWidth, 2 * kHeight]);
  assert.ok(Math.abs(video.duration - (kTo - kFrom + kHold_s)) < 0.7, `${video.duration} s`);
  console.log(`films: as expected, in ${shots}`);
} finally {
  await browser.close();
}
