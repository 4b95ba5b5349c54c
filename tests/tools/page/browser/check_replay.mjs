// Lets a robot in process learn two trials and looks at the replay in their report.
// Usage: node check_replay.mjs SANSO SESSION-FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { execFileSync } from "node:child_process";
import { statSync } from "node:fs";
import { join, resolve } from "node:path";
import { openBrowser, openPage } from "./browser.mjs";

const [sanso, session, shots] = process.argv.slice(2);
const kDesk = { width: 1180, height: 900 }, kPhone = { width: 390, height: 844 };
const kMost_bytes = 5e6;

execFileSync(sanso, ["learn", "--motion", "squat", "--iterations", "2", "--out", session]);
const report = resolve(session, "report.html");
assert.ok(statSync(report).size < kMost_bytes, "the report is too large to send");

const browser = await openBrowser();
try {
  const complaints = [];
  const page = await openPage(browser, `file://${report}`, kDesk, complaints);
  await page.waitForFunction(() => window.sansoReplay);
  const trials = await page.evaluate(() => sansoReplay.scene.trials.map((t) => ({ n: t.n, count: t.count })));
  assert.deepEqual(trials.map((t) => t.n), [1, 2]);
  await page.evaluate(() => sansoReplay.play(false));

  // the squat is in the data, and what is drawn follows the slider
  const at = async (time) => {
    await page.evaluate((t) => sansoReplay.seek(t), time);
    const knee = await page.evaluate(() => sansoReplay.sides[0].view.robot.joints.get("r_knee").angle);
    return { knee, picture: await page.locator(".replay-view canvas").first().screenshot() };
  };
  const length = await page.evaluate(() => sansoReplay.length);
  const moments = [];
  for (let k = 0; k <= 8; ++k) moments.push(await at(length * k / 8));
  const knees = moments.map((m) => m.knee);
  assert.ok(Math.max(...knees) - Math.min(...knees) > 0.3, `knees ${knees}`);
  assert.notDeepEqual(moments[0].picture, moments[4].picture, "the picture stands still");
  await at(length / 2);
  await page.evaluate(() => document.getElementById("replay").scrollIntoView());
  await page.screenshot({ path: join(shots, "replay.png") });

  // alone, then two side by side
  await page.evaluate(() => sansoReplay.choose(1, -1));
  assert.equal(await page.locator(".replay-view:visible").count(), 1);
  await page.evaluate(() => sansoReplay.choose(1, 1));
  assert.equal(await page.locator(".replay-view:visible").count(), 2);
  await page.evaluate(() => sansoReplay.play(true));
  await page.waitForFunction(() => sansoReplay.time > 0.5);
  await page.close();

  const phone = await openPage(browser, `file://${report}`, kPhone, complaints);
  await phone.waitForFunction(() => window.sansoReplay);
  const box = await phone.locator("#replay").boundingBox();
  assert.ok(box.x + box.width <= kPhone.width, "the replay is wider than the phone");
  await phone.close();
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`replay: as expected, report of ${(statSync(report).size / 1e6).toFixed(2)} MB; picture in ${shots}`);
} finally {
  await browser.close();
}
