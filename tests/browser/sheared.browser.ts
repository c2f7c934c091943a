// A volume whose axes are not perpendicular, as in a CT with gantry tilt: other programs draw it.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { program, type RunningServer, serve } from "./support/server.ts";
import { complete, settled } from "./support/view.ts";

const folder = mkdtempSync(join(tmpdir(), "isosplat-sheared-"));
let server: RunningServer;

test.beforeAll(async () => {
  const voxels = Uint8Array.from({ length: 24 ** 3 }, (_, i) => {
    const [x, y, z] = [i % 24, Math.floor(i / 24) % 24, Math.floor(i / 576)];
    return Math.max(0, 190 - 10 * Math.hypot(x - 11.5, y - 11.5, z - 11.5));
  });
  for (const [name, third] of [
    ["sheared", "(0,0.3,1)"],
    ["straight", "(0,0,1)"],
  ] as const) {
    const header =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n" +
      `space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) ${third}\n\n`;
    const file = join(folder, `${name}.nrrd`);
    writeFileSync(file, Buffer.concat([Buffer.from(header), voxels]));
    execFileSync(program, ["build", file, "-o", join(folder, `${name}.isosplat`)], {
      stdio: "ignore",
    });
  }
  server = await serve([folder]);
});
test.afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** The messages of WebGL in the console from now on. */
function glMessages(page: Page): string[] {
  const messages: string[] = [];
  page.on("console", (message) => {
    if (message.text().includes("GL_")) messages.push(message.text());
  });
  return messages;
}

test("is drawn without errors of WebGL, and so is another camera", async ({ page }) => {
  const messages = glMessages(page);
  await page.goto(`${server.url}?volume=sheared&isovalue=100`);
  await complete(page);
  await settled(page);
  await page.goto(`${server.url}?volume=sheared&isovalue=100&projection=orthographic`);
  await complete(page);
  await settled(page);
  await page.getByRole("application").press("p");
  await settled(page);
  expect(messages).toEqual([]);
});

test("is added to one with perpendicular axes without errors of WebGL", async ({ page }) => {
  const messages = glMessages(page);
  await page.goto(`${server.url}?volume=straight&isovalue=100&layer=volume:sheared;isovalue:100`);
  await complete(page);
  await settled(page);
  expect(messages).toEqual([]);
});
