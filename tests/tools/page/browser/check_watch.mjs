// A second program watches a controller that another one plans for: it draws the robot by a URDF,
// primitives and a mesh, on the ground that it was told, and stops it in an emergency.
// Usage: node check_watch.mjs SANSO STORED-SESSION FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { openBrowser, openPage, serve } from "./browser.mjs";

const [sanso, stored, folder, shots] = process.argv.slice(2);
const kDesk = { width: 1180, height: 760 }, kPatience = { timeout: 300000 };
const kHold = 4, kRunning = 5, kEmergencyStop = 42;
const until = (page, condition, argument) => page.waitForFunction(condition, argument, kPatience);

/** The robot as sanso exports it, its trunk a pyramid of STL. */
function robotWithAMesh() {
  mkdirSync(folder, { recursive: true });
  execFileSync(sanso, ["export", stored, "--mcap", join(folder, "op3.mcap"), "--urdf"]);
  const corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 2]];
  const sides = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
  const stl = ["solid pyramid"];
  for (const side of sides) {
    stl.push("facet normal 0 0 0", "outer loop");
    for (const corner of side) stl.push(`vertex ${corners[corner].join(" ")}`);
    stl.push("endloop", "endfacet");
  }
  writeFileSync(join(folder, "trunk.stl"), stl.concat("endsolid", "").join("\n"));
  const urdf = readFileSync(join(folder, "op3.urdf"), "utf8");
  const body = /(<link name="body_link">)([\s\S]*?)(<\/link>)/.exec(urdf);
  assert.ok(body, "the exported URDF has no body_link");
  const mesh = '<visual><origin xyz="0 0 0.03"/><geometry><mesh filename="package://op3/trunk.stl" ' +
    'scale="0.05 0.06 0.06"/></geometry></visual>';
  const file = join(folder, "with_mesh.urdf");
  const plain = body[2].replace(/<visual>[\s\S]*?<\/visual>/g, "");
  writeFileSync(file, urdf.replace(body[0], body[1] + plain + mesh + body[3]));
  return file;
}

/** Where the controller of an emulated robot listens. */
async function controllerOf(session) {
  const settings = join(session, "run", "firmware.toml");
  for (let tries = 0; tries < 600 && !existsSync(settings); ++tries) await sleep(100);
  return `127.0.0.1:${/^port = (\d+)/m.exec(readFileSync(settings, "utf8"))[1]}`;
}

const urdf = robotWithAMesh(), session = join(folder, "session");
const learns = spawn(sanso, ["learn", "--motion", "squat", "--robot", "emulated", "--iterations", "500",
  "--ground", "ramp", "--out", session], { stdio: "ignore" });
const address = await controllerOf(session);
const { child: watches, address: promised } = serve(sanso, ["watch", address, "--key",
  join(session, "run", "key.hex"), "--urdf", urdf, "--ground", "ramp", "--control", "--page", "0"]);
const browser = await openBrowser();
try {
  const complaints = [], page = await openPage(browser, await promised, kDesk, complaints);
  await until(page, (running) => window.sansoFrame?.s === running, kRunning);
  const drawn = await page.evaluate(() => {
    const { scene, robot } = sansoLive.view, kinds = {};
    robot.root.traverse((o) => { if (o.geometry) kinds[o.geometry.type] = (kinds[o.geometry.type] ?? 0) + 1; });
    return { kinds, links: robot.links.length, notes: sansoLive.scene.urdf.notes,
             slopes: scene.children.filter((o) => o.geometry?.type === "BoxGeometry" && Math.abs(o.rotation.y) > 0.1).length };
  });
  assert.deepEqual(drawn.notes, []);
  assert.ok(drawn.links > 20 && drawn.kinds.BoxGeometry > 5, JSON.stringify(drawn));
  assert.equal(drawn.kinds.BufferGeometry, 1, `one mesh: ${JSON.stringify(drawn)}`);
  assert.ok(drawn.slopes > 0, "the ground that it was told is not shown");
  const knee = () => page.evaluate(() => sansoLive.view.robot.joints.get("r_knee").q);
  const before = await knee();
  await until(page, (q) => Math.abs(sansoLive.view.robot.joints.get("r_knee").q - q) > 0.1, before);
  await page.screenshot({ path: join(shots, "watch_urdf.png") });

  await page.locator("[data-do=lower]").click();
  await until(page, () => /lower: refused.*R125/.test(document.getElementById("notes").textContent));
  await until(page, ([hold, running]) => [hold, running].includes(sansoFrame.s), [kHold, kRunning]);
  await page.locator("[data-do=estop]").click();
  await until(page, (fault) => sansoFrame.f === fault, kEmergencyStop);
  assert.match(await page.textContent("#notes"), /F42/);
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`watch: as expected; picture in ${shots}`);
} finally {
  learns.kill("SIGINT");
  watches.kill("SIGINT");
  await browser.close();
}
