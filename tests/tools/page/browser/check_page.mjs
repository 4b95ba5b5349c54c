// Starts the demo with the page's buttons on, looks at it as a person with a desk, a phone and bad
// intentions would, and presses the emergency stop.
// Usage: node check_page.mjs SANSO SANSO-EMULATOR SESSION-FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { execFileSync, spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import http from "node:http";
import { join } from "node:path";
import { fits, openBrowser, openPage } from "./browser.mjs";

const [sanso, emulator, session, shots] = process.argv.slice(2);
const kPatience_ms = 180000;  // a crowded machine starts programs slowly
const kDesk = { width: 1280, height: 800 }, kPhone = { width: 390, height: 844 };
const kFault = 7, kStopped = 42, kRun = 5, kKnee = 7 + 3;

const demo = spawn(sanso, ["demo", "--motion", "squat", "--iterations", "5", "--out", session,
                           "--page", "0", "--control"]);
let told = "";
for (const stream of [demo.stdout, demo.stderr]) stream.on("data", (d) => (told += d));

async function until(what, condition) {
  for (const begin = Date.now(); Date.now() - begin < kPatience_ms;) {
    const got = await condition();
    if (got) return got;
    if (demo.exitCode != null) throw new Error(`the demo ended:\n${told}`);
    await new Promise((r) => setTimeout(r, 100));
  }
  throw new Error(`waited for ${what} in vain:\n${told}`);
}

function status(port, path, { method = "GET", headers = {}, body } = {}) {
  return new Promise((resolve, reject) => {
    const r = http.request({ host: "127.0.0.1", port, path, method, headers }, (answer) => {
      answer.resume();
      resolve(answer.statusCode);
    });
    r.on("error", reject);
    r.end(body);
  });
}

async function checkDoors(address) {
  const url = new URL(address), token = url.search;
  assert.equal(await status(url.port, "/"), 403, "no token");
  assert.equal(await status(url.port, "/?token=" + "0".repeat(32)), 403, "wrong token");
  const stop = { method: "POST", body: '{"do":"estop"}' };
  assert.equal(await status(url.port, "/control" + token,
    { ...stop, headers: { Origin: "http://example.org" } }), 403, "foreign origin");
  assert.equal(await status(url.port, "/scene.json" + token,
    { headers: { Host: "robot.example.org" } }), 403, "foreign name");
  assert.equal(await status(url.port, "/scene.json" + token), 200, "the rightful one");
}

const frame = (page) => page.evaluate(() => window.sansoFrame);
const pictureOf = (page) => page.locator("#view canvas").screenshot();

/** The squat bends the knees, and the picture changes with them. */
async function checkMotion(page) {
  await until("a trial", async () => (await frame(page))?.s === kRun);
  const knees = [], before = await pictureOf(page);
  await until("the squat", async () => {
    const f = await frame(page);
    if (f.s === kRun) knees.push(f.x[kKnee]);
    return Math.max(...knees) - Math.min(...knees) > 0.3;
  });
  await until("the picture to move", async () => !before.equals(await pictureOf(page)));
  const f = await frame(page);
  assert.ok(f.r, "no reference during a trial");
  assert.ok(f.F[0][2] + f.F[1][2] > 10, `feet carry ${f.F}`);
  assert.match(await page.locator("#trial").textContent(), /trial \d+ of 5/);
}

async function checkPhone(browser, address, complaints) {
  const page = await openPage(browser, address, kPhone, complaints);
  await until("frames on the phone", () => frame(page));
  await new Promise((r) => setTimeout(r, 1500));
  assert.ok(await fits(page), "the phone has to scroll sideways");
  await page.screenshot({ path: join(shots, "phone.png"), fullPage: true });
  await page.close();
}

const truth = (folder) => JSON.parse(execFileSync(emulator,
  ["--dir", folder, "--tell", '{"command": "truth"}']).toString());

async function checkStop(page) {
  const config = readFileSync(join(session, "run", "emulator.toml"), "utf8");
  const folder = config.match(/directory = "(.*)"/)[1];
  assert.ok(truth(folder).torque_on.some(Boolean), "nothing to stop");
  await page.locator("[data-do=estop]").click();
  await until("fault 42", async () => {
    const f = await frame(page);
    return f.s === kFault && f.f === kStopped;
  });
  assert.ok(!truth(folder).torque_on.some(Boolean), "servos hold torque after the emergency stop");
  await until("its text", async () => /F42 emergency_stop/.test(await page.locator("#notes").textContent()));
  await page.screenshot({ path: join(shots, "stopped.png") });
  await until("the session to wait", async () => (await frame(page)).paused);
  const trial = (await frame(page)).n;
  await page.locator("[data-do=start]").click();
  await until("the next trial", async () => {
    const f = await frame(page);
    return f.s === kRun && f.n > trial;
  });
}

let browser;
try {
  const address = await until("the address", () => told.match(/page: (http:\S+)/)?.[1]);
  await checkDoors(address);
  const complaints = [];
  browser = await openBrowser();
  const page = await openPage(browser, address, kDesk, complaints);
  await checkMotion(page);
  assert.ok(await fits(page), "the desk has to scroll sideways");
  await page.screenshot({ path: join(shots, "live.png") });
  await checkPhone(browser, address, complaints);
  await checkStop(page);
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`live page: as expected; pictures in ${shots}`);
} finally {
  await browser?.close();
  demo.kill("SIGKILL");
}
