// Debian's chromium without a display, drawing by software; what it complains about is collected.
import { spawn } from "node:child_process";
import { chromium } from "playwright-core";

// Ends what hangs, not what is slow: a crowded machine draws one picture in half a minute.
const kPatience_ms = 300000;

export async function openBrowser() {
  return chromium.launch({
    timeout: kPatience_ms,
    executablePath: "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
           "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  });
}

export async function patientPage(browser, options) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(kPatience_ms);
  return page;
}

/** A page whose errors go to `complaints`. The driver's own notes on slow drawing do not count. */
export async function openPage(browser, address, size, complaints) {
  const page = await patientPage(browser, { viewport: size });
  page.on("console", (m) => {
    const ours = !/GL Driver Message|GPU stall|WebGL-/.test(m.text());
    if (["error", "warning"].includes(m.type()) && ours) complaints.push(m.text());
  });
  page.on("pageerror", (e) => complaints.push(e.message));
  page.on("request", (r) => {
    const outside = !/^(data|blob|file):/.test(r.url()) && new URL(r.url()).hostname !== "127.0.0.1";
    if (outside) complaints.push(`asks for ${r.url()}`);
  });
  await page.goto(address);
  return page;
}

export async function fits(page) {
  return page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth);
}

/** Starts a program that prints `page: ADDRESS`: the process, and a promise of the address. */
export function serve(program, parameters) {
  const child = spawn(program, parameters, { stdio: ["ignore", "pipe", "inherit"] });
  let said = "";
  const address = new Promise((found, lost) => {
    child.stdout.on("data", (text) => {
      said += text;
      const match = /page: (\S+)/.exec(said);
      if (match) found(match[1]);
    });
    child.on("exit", () => lost(new Error(`it ended before it served a page: ${said}`)));
  });
  return { child, address };
}
