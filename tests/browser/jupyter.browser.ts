// A notebook of the gallery in a real Jupyter Notebook, whose browser shows the outputs of a kernel. Debian has no
// anywidget, so the view is HTML.
import { type ChildProcess, spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { program } from "./support/server.ts";

const jupyter = "/usr/bin/jupyter-notebook";
const packages = process.env.ISOSPLAT_PYTHON_PACKAGE ?? "build/release/native/python/package";
const token = "0123456789abcdef0123456789abcdef";
const notebook = "01_first_surface.ipynb";

interface ClassicNotebook {
  notebook: { kernel: { is_connected(): boolean } | null; execute_all_cells(): void };
}

let server: ChildProcess | undefined;
let folder = "";

async function freePort(): Promise<number> {
  const holder = createServer();
  await new Promise<void>((listening) => holder.listen(0, "127.0.0.1", listening));
  const { port } = holder.address() as AddressInfo;
  await new Promise((closed) => holder.close(closed));
  return port;
}

test.skip(!existsSync(jupyter), "Jupyter Notebook is not installed");

test.afterEach(async () => {
  if (server) {
    const ended = new Promise((done) => server?.on("exit", done));
    server.kill("SIGTERM"); // it ends its kernels
    await ended;
  }
  if (folder) rmSync(folder, { recursive: true, force: true });
  server = undefined;
});

test("a notebook of the gallery shows its volume", async ({ page }) => {
  test.setTimeout(180_000);
  folder = mkdtempSync(join(tmpdir(), "isosplat-jupyter-"));
  copyFileSync(join("docs/gallery", notebook), join(folder, notebook));
  const port = await freePort();
  const options = [
    "--no-browser",
    "--allow-root",
    `--port=${port}`,
    `--NotebookApp.token=${token}`,
  ];
  server = spawn(jupyter, options, {
    cwd: folder,
    env: {
      ...process.env,
      HOME: folder,
      PYTHONPATH: join(process.cwd(), packages),
      ISOSPLAT_PROGRAM: join(process.cwd(), program),
    },
    stdio: "ignore",
  });
  // The page of the notebook and that of the kernel's server may have different names of this machine.
  for (const host of ["localhost", "127.0.0.1"]) {
    const address = `http://${host}:${port}/notebooks/${notebook}?token=${token}`;
    await expect
      .poll(
        () =>
          page.goto(address).then(
            (response) => response?.status(),
            () => 0,
          ),
        { timeout: 60_000 },
      )
      .toBe(200);
    await page.waitForFunction(
      () =>
        (
          globalThis as unknown as { Jupyter?: ClassicNotebook }
        ).Jupyter?.notebook.kernel?.is_connected(),
      null,
      { timeout: 60_000 },
    );
    await page.evaluate(() => {
      (globalThis as unknown as { Jupyter: ClassicNotebook }).Jupyter.notebook.execute_all_cells();
    });
    const view = page.frameLocator("iframe").locator("isosplat-viewer");
    const shown = () =>
      view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => [
        e.isovalues,
        e.progress?.complete,
        e.progress?.fault,
      ]);
    await expect.poll(shown, { timeout: 60_000 }).toEqual([[0], true, null]);
  }
});
