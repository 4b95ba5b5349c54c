// The live page of a session in process: it learns on a virtual clock, so that a crowded machine
// makes the test slow and nothing else. Looks, pushes, stops in an emergency, goes on; and tries to
// get in without the token and from a foreign page.
// Usage: node check_live.mjs SANSO SESSION-FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { createServer } from "node:http";
import { join } from "node:path";
import { fits, openBrowser, openPage, patientPage, serve } from "./browser.mjs";

const [sanso, session, shots] = process.argv.slice(2);
const kDesk = { width: 1180, height: 760 }, kPhone = { width: 390, height: 844 };
const kRunning = 5, kFault = 7, kEmergencyStop = 42, kForbidden = 403;
const kBent = 0.1;  // rad, a squat bends it by several times that

const until = (page, condition, argument) => page.waitForFunction(condition, argument);

/** The knee as it is drawn leaves the angle that a trial found it at. Where frames come close
 *  together a dozen of them is a tenth of a second: what moves is waited for, not counted. */
async function untilAKneeBends(page) {
  await until(page, (running) => window.sansoFrame?.s === running, kRunning);
  const found = await page.evaluate(() => sansoLive.view.robot.joints.get("r_knee").angle);
  await until(page, ([found, bent]) =>
    Math.abs(sansoLive.view.robot.joints.get("r_knee").angle - found) > bent, [found, kBent]);
}

const stopped = (page) => page.waitForFunction((fault) => sansoFrame.f === fault, kEmergencyStop,
  { timeout: 5000 }).then(() => true, () => false);

/** A trial may be over before the button is found: then it goes on, and presses again; a stop that
 *  met the next trial before it began has stopped it. */
async function stopInAnEmergency(page) {
  for (let tries = 0; tries < 20; ++tries) {
    await until(page, ([running, fault]) => (sansoFrame.s === running && sansoFrame.tt > 0) ||
      sansoFrame.f === fault, [kRunning, kEmergencyStop]);
    if (await page.evaluate((fault) => sansoFrame.f === fault, kEmergencyStop)) return;
    await page.locator("[data-do=estop]").click();
    await until(page, () => sansoFrame.paused || document.querySelector("[data-do=stop]").disabled);
    if (await stopped(page)) return;
    await page.locator("[data-do=start]").click();
  }
  assert.fail("the emergency stop never met a robot that moves");
}

/** A page of another origin that knows the address asks for what it must not get. */
async function foreignPage(browser, address) {
  const server = createServer((_, answer) => {
    answer.setHeader("Content-Type", "text/html");
    answer.end(`<iframe src="${address}"></iframe>`);
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const page = await patientPage(browser);
  await page.goto(`http://127.0.0.1:${server.address().port}/foreign`);
  const asked = await page.evaluate(async (address) => {
    const ask = (path, options) => fetch(address.replace("/?", path + "?"), options)
      .then((r) => `let in: ${r.status}`, (e) => "kept out: " + e.message);
    return [await ask("/scene.json"), await ask("/control", { method: "POST", body: '{"do":"push"}' })];
  }, address);
  for (const answer of asked) assert.ok(answer.startsWith("kept out"), `${asked}`);
  // what cannot be read must not be carried out either
  const sent = await fetch(address.replace("/?", "/control?"), { method: "POST", body: '{"do":"push"}',
    headers: { Origin: `http://127.0.0.1:${server.address().port}` } });
  assert.equal(sent.status, kForbidden);
  const inner = page.frames().find((f) => f !== page.mainFrame());
  const shown = await inner.evaluate(() => document.body?.id ?? "").catch(() => "");
  assert.notEqual(shown, "live", "the page lets itself be framed");
  await page.close();
  server.close();
}

async function withoutTheToken(browser, address) {
  const page = await patientPage(browser);
  for (const wrong of ["", "?token=", "?token=" + "0".repeat(32)]) {
    const answer = await page.goto(new URL("/", address).href + wrong);
    assert.equal(answer.status(), kForbidden);
    assert.match(await page.textContent("body"), /use the address that sanso printed/);
  }
  await page.close();
}

const { child, address: promised } = serve(sanso, ["learn", "--motion", "squat", "--iterations",
  "500", "--page", "0", "--control", "--ground", "ramp", "--out", session]);
const browser = await openBrowser();
try {
  const address = await promised, complaints = [];
  const page = await openPage(browser, address, kDesk, complaints);
  await untilAKneeBends(page);
  await until(page, () => sansoFrame.r && sansoLive.view.ghost.root.visible);
  await until(page, () => sansoFrame.F && sansoLive.view.arrows.some((a) => a.group.visible));
  const slopes = await page.evaluate(() => sansoLive.view.scene.children.filter(
    (o) => o.geometry?.type === "BoxGeometry" && Math.abs(o.rotation.y) > 0.1).length);
  assert.ok(slopes > 0, "the ground that it stands on is not shown");
  assert.ok(await fits(page), "wider than the window");

  await withoutTheToken(browser, address);
  await foreignPage(browser, address);
  await page.locator("[data-do=push]").click();
  await until(page, () => /push: 10 N/.test(document.getElementById("notes").textContent));
  await until(page, () => sansoLive.trials.length >= 2);
  await until(page, (running) => sansoFrame.s === running && sansoFrame.x[2] < 0.23, kRunning);
  await page.screenshot({ path: join(shots, "live.png") });

  await stopInAnEmergency(page);
  await until(page, (fault) => sansoFrame.s === fault, kFault);
  assert.match(await page.textContent("#notes"), /F42/);
  assert.equal(await page.textContent("#state"), "FAULT");
  await page.screenshot({ path: join(shots, "live_estop.png") });

  const phone = await openPage(browser, address, kPhone, complaints);
  await until(phone, () => window.sansoLive);
  await phone.locator("[data-do=start]").click();
  await until(phone, (running) => window.sansoFrame?.s === running, kRunning);
  assert.ok(await fits(phone), "wider than the phone");
  const stop = await phone.locator("[data-do=estop]").boundingBox();
  assert.ok(stop.x >= 0 && stop.x + stop.width <= kPhone.width && stop.y + stop.height <= kPhone.height,
            "the emergency stop is out of sight");
  await phone.screenshot({ path: join(shots, "live_phone.png") });
  await phone.close();

  child.kill("SIGKILL");
  await until(page, () => document.getElementById("link").classList.contains("bad"));
  const ours = complaints.filter((c) => !/ERR_INCOMPLETE_CHUNKED_ENCODING|ERR_CONNECTION_REFUSED/.test(c));
  assert.deepEqual(ours, [], "the browser complains");
  console.log(`live page: as expected; pictures in ${shots}`);
} finally {
  child.kill("SIGKILL");
  await browser.close();
}
