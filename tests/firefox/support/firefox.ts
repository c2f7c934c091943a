/**
 * Debian's Firefox, driven over WebDriver BiDi. Firefox has WebGL 2 only with a display, so tests
 * start a virtual one, on which llvmpipe draws.
 */
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import puppeteer, { type Browser } from "puppeteer-core";

const executablePath =
  process.env.ISOSPLAT_FIREFOX ??
  ["/usr/bin/firefox-esr", "/usr/bin/firefox"].find((path) => existsSync(path)) ??
  "/usr/bin/firefox-esr";

export interface Firefox {
  browser: Browser;
  /** The folder for files that pages save. */
  downloads: string;
  close(): Promise<void>;
}

/** Starts Firefox. `webgl` false: without a display, and therefore without WebGL. */
export async function startFirefox({ webgl = true } = {}): Promise<Firefox> {
  const display = webgl ? await startDisplay() : undefined;
  const downloads = mkdtempSync(join(tmpdir(), "isosplat-downloads-"));
  const env: Record<string, string | undefined> = { ...process.env, LIBGL_ALWAYS_SOFTWARE: "1" };
  delete env.DISPLAY;
  delete env.WAYLAND_DISPLAY;
  if (display) Object.assign(env, { DISPLAY: display.name, MOZ_X11_EGL: "1" });
  const browser = await puppeteer.launch({
    browser: "firefox",
    executablePath,
    headless: !webgl,
    env,
    extraPrefsFirefox: {
      "browser.download.alwaysOpenPanel": false,
      "browser.download.dir": downloads,
      // The download folder above.
      "browser.download.folderList": 2,
      "gfx.x11-egl.force-enabled": webgl,
      "layers.acceleration.force-enabled": webgl,
      "ui.prefersReducedMotion": 1,
      // By default, Firefox refuses llvmpipe.
      "webgl.force-enabled": webgl,
    },
  });
  return {
    browser,
    downloads,
    close: async () => {
      await browser.close();
      await display?.stop();
      rmSync(downloads, { recursive: true, force: true });
    },
  };
}

interface Display {
  /** The display's name, as the variable DISPLAY has it. */
  name: string;
  stop(): Promise<void>;
}

function startDisplay(): Promise<Display> {
  // The server chooses a free number, and writes it to file descriptor 3 when it accepts
  // connections.
  const options = ["-displayfd", "3", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"];
  const child = spawn("Xvfb", options, { stdio: ["ignore", "ignore", "pipe", "pipe"] });
  const ended = new Promise<void>((resolve) => child.on("exit", () => resolve()));
  return new Promise((resolve, reject) => {
    let output = "";
    child.stderr?.on("data", (data: Buffer) => {
      output += data.toString();
    });
    let number = "";
    child.stdio[3]?.on("data", (data: Buffer) => {
      number += data.toString();
      if (!number.endsWith("\n")) return;
      resolve({
        name: `:${number.trim()}`,
        stop: () => {
          child.kill("SIGTERM");
          return ended;
        },
      });
    });
    child.on("error", reject);
    child.on("exit", (code) => reject(new Error(`Xvfb ended with status ${code}: ${output}`)));
  });
}
