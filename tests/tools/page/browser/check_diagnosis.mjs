// The robot of a diagnosis report: it moves with the slider, the joint and the link that were found
// are lit, simulations stand apart from the recording as far as they differ, and one that floats goes
// along its way.
// Usage: node check_diagnosis.mjs FOLDER-OF-MECHANISM-SAMPLES SCREENSHOTS
import { strict as assert } from "node:assert";
import { statSync } from "node:fs";
import { join, resolve } from "node:path";
import { openBrowser, openPage } from "./browser.mjs";

const [folder, shots] = process.argv.slice(2);
const kDesk = { width: 1180, height: 900 }, kPhone = { width: 390, height: 844 };
const kMost_bytes = 5e6, kLit = 0xd6006c;

const open = async (browser, name, size, complaints) => {
  const file = resolve(folder, name);
  assert.ok(statSync(file).size < kMost_bytes, "the report is too large to send");
  const page = await openPage(browser, `file://${file}`, size, complaints);
  await page.waitForFunction(() => window.sansoMechanism);
  await page.evaluate(() => sansoMechanism.play(false));
  return page;
};

/** Where each figure's last link is in the world at a time. */
const tips = (page, time) => page.evaluate((t) => {
  sansoMechanism.seek(t);
  return sansoMechanism.stage.robots.map((robot) => {
    robot.root.updateMatrixWorld(true);
    return robot.groups.at(-1).matrixWorld.elements.slice(12, 15);
  });
}, time);
const far = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));

const browser = await openBrowser();
try {
  const complaints = [], page = await open(browser, "arm.html", kDesk, complaints);
  const early = await tips(page, 0.3), later = await tips(page, 1.2);
  assert.equal(early.length, 3);
  assert.ok(far(early[0], later[0]) > 0.05, `the arm stands still: ${early[0]} ${later[0]}`);
  assert.ok(far(later[0], later[2]) < 1e-4, "patched is as recorded here");
  const apart = far(later[0], later[1]);
  assert.ok(apart > 0.01, `nominal is as recorded: ${apart}`);

  await page.evaluate(() => sansoMechanism.enlarge(3));
  const enlarged = far((await tips(page, 1.2))[1], later[0]);
  assert.ok(enlarged > 2 * apart, `${apart} enlarged threefold is ${enlarged}`);
  await page.evaluate(() => sansoMechanism.enlarge(1));

  const lit = await page.evaluate((colour) => {
    const out = [];
    sansoMechanism.stage.robots[0].root.traverse((o) => { if (o.material?.color.getHex() === colour) out.push(o.geometry.type); });
    return out;
  }, kLit);
  assert.deepEqual(lit.sort(), ["BufferGeometry", "CylinderGeometry"], "the joint and the mesh of the link");
  assert.match(await page.textContent("#replay"), /backlash at b/i);
  assert.match(await page.textContent("#replay output"), /^11\.20 s/, "the recording's own time");

  await tips(page, 0.8);
  await page.evaluate(() => document.getElementById("replay").scrollIntoView());
  await page.screenshot({ path: join(shots, "diagnosis.png") });
  const picture = () => page.locator(".replay-view canvas").first().screenshot();
  const together = await picture();
  await page.getByText("side by side").click();
  await page.evaluate(() => sansoMechanism.stage.draw());
  assert.notDeepEqual(await picture(), together, "side by side looks the same");
  await page.screenshot({ path: join(shots, "diagnosis_apart.png") });
  await page.getByLabel("recording", { exact: true }).selectOption("1");
  await page.evaluate(() => { sansoMechanism.seek(0); sansoMechanism.play(true); });
  await page.waitForFunction(() => sansoMechanism.time > 0.3);
  await page.close();

  const floating = await open(browser, "floating.html", kPhone, complaints);
  const begin = await tips(floating, 0), end = await tips(floating, 2.9);
  assert.ok(end[0][0] - begin[0][0] > 0.5, `it stays where it is: ${begin[0]} ${end[0]}`);
  assert.equal(end.length, 3, "recorded, nominal, patched");
  assert.ok(far(end[0], end[2]) < 1e-4, "patched is as recorded here");
  assert.ok(Math.abs(far(end[0], end[1]) - 0.05) < 1e-3, `nominal lies lower by 0.05: ${end}`);
  await floating.evaluate(() => sansoMechanism.enlarge(3));
  const lower = await tips(floating, 2.9);
  assert.ok(Math.abs(far(lower[0], lower[1]) - 0.15) < 2e-3, `enlarged threefold: ${lower}`);
  assert.match(await floating.textContent("#replay"), /base height/);
  const box = await floating.locator("#replay").boundingBox();
  assert.ok(box.x + box.width <= kPhone.width, "wider than the phone");
  await floating.close();
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`diagnosis: as expected; pictures in ${shots}`);
} finally {
  await browser.close();
}
