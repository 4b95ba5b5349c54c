// A motion made from a recipe, previewed before anything moves.
// Usage: node check_preview.mjs SANSO FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { openBrowser, openPage } from "./browser.mjs";

const [sanso, folder, shots] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const recipe = join(folder, "bow.toml");
writeFileSync(recipe, execFileSync(sanso, ["motions", "new", "--example"]));
execFileSync(sanso, ["motions", "new", recipe, "--as", "bow", "--out", folder]);

const browser = await openBrowser();
try {
  const complaints = [];
  const page = await openPage(browser, `file://${resolve(folder, "bow.html")}`, { width: 1180, height: 900 }, complaints);
  await page.waitForFunction(() => window.sansoReplay);
  const heights = await page.evaluate(() => {
    sansoReplay.play(false);
    const z = [];
    for (let k = 0; k <= 20; ++k) {
      sansoReplay.seek(sansoReplay.length * k / 20);
      z.push(sansoReplay.sides[0].view.robot.root.position.z);
    }
    sansoReplay.seek(sansoReplay.length * z.indexOf(Math.min(...z)) / 20);
    return z;
  });
  const low = Math.min(...heights), stands = heights[0];
  assert.ok(stands - low > 0.01, `the example's trunk does not go down: ${heights}`);
  assert.ok(Math.abs(heights.at(-1) - stands) < 0.005, `it does not end standing: ${heights}`);
  assert.equal(await page.locator(".side:visible").count(), 1, "one motion, one picture");
  assert.equal(await page.locator(".side select:visible").count(), 0, "no trial to choose");
  await page.evaluate(() => document.getElementById("replay").scrollIntoView());
  await page.screenshot({ path: join(shots, "preview.png") });
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`preview: as expected; picture in ${shots}`);
} finally {
  await browser.close();
}
