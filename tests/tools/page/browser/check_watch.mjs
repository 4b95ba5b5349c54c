// `sanso watch` of a controller that runs somewhere: it draws the robot by a URDF, primitives and a
// mesh, on the ground that it was told, in the angles that the controller reads, and stops it.
// Usage: node check_watch.mjs SANSO FIRMWARE EMULATOR STORED-SESSION FOLDER SCREENSHOTS
import { strict as assert } from "node:assert";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { openBrowser, openPage, serve } from "./browser.mjs";

const [sanso, firmware, emulator, stored, folder, shots] = process.argv.slice(2);
const kDesk = { width: 1180, height: 760 };
const kRightKnee = 10, kFault = 7;  // place in the frame; state
const until = (page, condition, argument) => page.waitForFunction(condition, argument);

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

/** A controller beside an emulated robot, without a host: where it listens. A crowded machine may
    give it a fault; it is watched all the same. */
async function controllerOf(robot, key) {
  const server = createServer().listen(0, "127.0.0.1");
  await new Promise((listening) => server.on("listening", listening));
  const { port } = server.address();
  await new Promise((closed) => server.close(closed));
  writeFileSync(key, `${"5a".repeat(32)}\n`, { mode: 0o600 });
  const settings = join(robot, "firmware.toml");
  writeFileSync(settings, ["[device]", `bus = "${robot}/bus"`, `imu = "unix:${robot}/imu"`,
    `pose = "unix:${robot}/pose"`, 'listen = "127.0.0.1"', `port = ${port}`, `key_file = "${key}"`,
    `log_directory = "${robot}"`, "allow_without_realtime = true", ""].join("\n"));
  children.push(spawn(emulator, ["--dir", robot, "--ground", "ramp"], { stdio: "ignore" }));
  for (let tries = 0; tries < 600 && !existsSync(join(robot, "imu")); ++tries) await sleep(100);
  tell(robot, { command: "place", pose: "walkready", held: true });
  children.push(spawn(firmware, ["--config", settings], { stdio: "ignore" }));
  return `127.0.0.1:${port}`;
}
const tell = (robot, command) =>
  execFileSync(emulator, ["--dir", robot, "--tell", JSON.stringify(command)]);

const urdf = robotWithAMesh(), children = [];
const robot = mkdtempSync(join(tmpdir(), "sanso_watch_")), key = join(robot, "key.hex");  // a short path
const address = await controllerOf(robot, key);
const { child: watches, address: promised } = serve(sanso, ["watch", address, "--key", key,
  "--urdf", urdf, "--ground", "ramp", "--control", "--page", "0"]);
const browser = await openBrowser();
try {
  const complaints = [], page = await openPage(browser, await promised, kDesk, complaints);
  await until(page, (at) => window.sansoFrame && Math.abs(sansoFrame.x[at]) > 0.5, kRightKnee);
  const drawn = await page.evaluate(() => {
    const { scene, robot } = sansoLive.view, kinds = {};
    robot.root.traverse((o) => { if (o.geometry) kinds[o.geometry.type] = (kinds[o.geometry.type] ?? 0) + 1; });
    return { kinds, links: robot.links.length, notes: sansoLive.scene.urdf.notes,
             slopes: scene.children.filter((o) => o.geometry?.type === "BoxGeometry" && Math.abs(o.rotation.y) > 0.1).length };
  });
  assert.deepEqual(drawn.notes, []);
  assert.ok(drawn.links > 20 && drawn.kinds.BoxGeometry >= 2, JSON.stringify(drawn));
  assert.equal(drawn.kinds.BufferGeometry, 1, `one mesh: ${JSON.stringify(drawn)}`);
  assert.ok(drawn.slopes > 0, "the ground that it was told is not shown");
  const drawnAsSaid = () => page.evaluate((at) => {
    const { view } = sansoLive;
    view.show(sansoFrame.x, sansoFrame.r, sansoFrame.F);
    return [view.robot.joints.get("r_knee").q, sansoFrame.x[at]];
  }, kRightKnee);
  const [drawnKnee, said] = await drawnAsSaid();
  assert.equal(drawnKnee, said);
  assert.ok(Math.abs(said) > 0.5, `it stands with bent knees: ${said}`);
  await page.screenshot({ path: join(shots, "watch_urdf.png") });

  await page.locator("[data-do=estop]").click();
  await until(page, () => /estop: done/.test(document.getElementById("notes").textContent));
  await until(page, (fault) => sansoFrame.s === fault, kFault);
  assert.deepEqual(complaints, [], "the browser complains");
  console.log(`watch: as expected; picture in ${shots}`);
} finally {
  for (const child of [watches, ...children]) child.kill("SIGKILL");
  rmSync(robot, { recursive: true, force: true });
  await browser.close();
}
