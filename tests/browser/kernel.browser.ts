// isosplat.view() of the Python package, without a notebook: a real process of Python, its server, and a page that
// does what the output of a cell does. The page has an origin of its own.
import { type ChildProcess, spawn } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createServer, request, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { expect, type Page, test } from "@playwright/test";
import type { Traits } from "../../web/element/notebook_traits.ts";
import { launchOptions } from "./support/chromium.ts";
import { demoFolder, program } from "./support/server.ts";

type Line = Record<string, unknown>;

const python = "/usr/bin/python3";
const packages = process.env.ISOSPLAT_PYTHON_PACKAGE ?? "build/release/native/python/package";

class Kernel {
  readonly #process: ChildProcess;
  readonly #waiting: ((line: Line) => void)[] = [];
  readonly #lines: Line[] = [];
  /** Messages that the page sent, without those of traits. */
  readonly asked: Line[] = [];
  #errors = "";
  onLine: ((line: Line) => void) | undefined;

  constructor(kind: "widget" | "html", store: string, proxy = "") {
    this.#process = spawn(python, ["-B", "tests/browser/support/kernel.py", kind, store, proxy], {
      env: { ...process.env, PYTHONPATH: packages, ISOSPLAT_PROGRAM: program },
    });
    if (!this.#process.stdout) throw new Error("no output");
    this.#process.stderr?.on("data", (data: Buffer) => {
      this.#errors += data.toString();
    });
    createInterface(this.#process.stdout).on("line", (text) => {
      const line = JSON.parse(text) as Line;
      const waiting = this.#waiting.shift();
      if (waiting) waiting(line);
      else if (this.onLine) this.onLine(line);
      else this.#lines.push(line);
    });
    this.#process.on("exit", () => {
      for (const waiting of this.#waiting) waiting({ errors: this.#errors });
    });
  }

  async next(): Promise<Line> {
    const line =
      this.#lines.shift() ?? (await new Promise<Line>((done) => this.#waiting.push(done)));
    if (line.errors !== undefined) throw new Error(`the kernel ended: ${line.errors}`);
    return line;
  }

  write(line: Line): void {
    if (line.message) this.asked.push(line.message as Line);
    this.#process.stdin?.write(`${JSON.stringify(line)}\n`);
  }

  /** The present values of traits in Python. */
  async values(...names: (keyof Traits)[]): Promise<Line> {
    const { onLine } = this;
    const found = new Promise<Line>((done) => {
      this.onLine = (line) => {
        if (line.values) done(line.values as Line);
        else onLine?.(line);
      };
    });
    this.write({ get: names });
    try {
      return await found;
    } finally {
      this.onLine = onLine;
    }
  }

  stop(): Promise<void> {
    this.#process.stdin?.end();
    if (this.#process.exitCode !== null) return Promise.resolve();
    return new Promise((done) => this.#process.on("exit", () => done()));
  }
}

/** A notebook's server: its page at `path`, and, like jupyter-server-proxy, ports of its machine. */
async function notebookServer(options: { html: string; proxied: boolean }): Promise<Server> {
  const server = createServer((incoming, response) => {
    const [, port, rest] = /^\/user\/me\/proxy\/(\d+)(\/.*)$/.exec(incoming.url ?? "") ?? [];
    if (!port || !options.proxied) {
      response.setHeader("Content-Type", "text/html");
      response.statusCode = port ? 404 : 200;
      response.end(options.html);
      return;
    }
    const { headers, method } = incoming;
    const outgoing = request({ host: "127.0.0.1", port, path: rest, method, headers }, (answer) => {
      response.writeHead(answer.statusCode ?? 502, answer.headers);
      answer.pipe(response);
    });
    outgoing.on("error", () => response.writeHead(502).end());
    outgoing.end();
  });
  await new Promise<void>((listening) => server.listen(0, "127.0.0.1", listening));
  return server;
}

const lab = `<!doctype html><script id="jupyter-config-data" type="application/json">{"baseUrl":"/user/me/"}</script>`;
const store = join(demoFolder, "bucky.isosplat");

let server: Server | undefined;
let kernel: Kernel | undefined;
test.afterEach(async () => {
  server?.close();
  await kernel?.stop();
  server = kernel = undefined;
});

const hub = "hub.example";
// The browser takes this host for another machine.
test.use({
  launchOptions: {
    ...launchOptions,
    args: [...launchOptions.args, `--host-resolver-rules=MAP ${hub} 127.0.0.1`],
  },
});

async function openNotebook(
  page: Page,
  html: string,
  { proxied = false, host = "127.0.0.1" } = {},
): Promise<void> {
  server?.close();
  server = await notebookServer({ html, proxied });
  const { port } = server.address() as AddressInfo;
  await page.goto(`http://${host}:${port}/user/me/lab`);
}

const kernelOfPage = new Map<Page, Kernel>();

/** Shows the widget as the manager of widgets does: a module from its text, and a model. */
async function showWidget(page: Page, running: Kernel): Promise<void> {
  const { state } = await running.next();
  kernelOfPage.set(page, running);
  if (!(await page.evaluate(() => "toKernel" in globalThis))) {
    await page.exposeFunction("toKernel", (line: Line) => kernelOfPage.get(page)?.write(line));
  }
  await page.evaluate((state) => {
    const values = state as Record<string, unknown>;
    const listeners = new Map<string, Set<(...call: unknown[]) => void>>();
    const unsaved = new Set<string>();
    const emit = (event: string, ...call: unknown[]) => {
      for (const listener of [...(listeners.get(event) ?? [])]) listener(...call);
    };
    const { toKernel } = globalThis as unknown as { toKernel(line: unknown): void };
    const model = {
      get: (name: string) => values[name],
      set(name: string, value: unknown) {
        values[name] = value;
        unsaved.add(name);
        emit(`change:${name}`);
      },
      save_changes() {
        toKernel({ state: Object.fromEntries([...unsaved].map((name) => [name, values[name]])) });
        unsaved.clear();
      },
      on: (event: string, listener: () => void) =>
        void listeners.set(event, (listeners.get(event) ?? new Set()).add(listener)),
      off: (event: string, listener: () => void) => void listeners.get(event)?.delete(listener),
      send: (message: unknown) => toKernel({ message }),
    };
    Object.assign(globalThis, {
      async show() {
        const code = URL.createObjectURL(
          new Blob([values._esm as string], { type: "text/javascript" }),
        );
        const { default: widget } = await import(code);
        const el = document.body.appendChild(document.createElement("div"));
        el.style.width = "400px";
        return widget.render({ model, el });
      },
      fromKernel(line: { state?: object; message?: unknown; buffers?: string[] }) {
        if (line.state) {
          Object.assign(values, line.state);
          for (const name of Object.keys(line.state)) emit(`change:${name}`);
        } else if (line.message) {
          const buffers = (line.buffers ?? []).map(
            (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer),
          );
          emit("msg:custom", line.message, buffers);
        }
      },
    });
  }, state);
  running.onLine = (line) =>
    void page.evaluate((line) => {
      (globalThis as unknown as { fromKernel(line: unknown): void }).fromKernel(line);
    }, line);
  await page.evaluate(() => (globalThis as unknown as { show(): Promise<unknown> }).show());
}

async function expectComplete(running: Kernel): Promise<void> {
  await expect
    .poll(async () => await running.values("complete", "fault"))
    .toEqual({ complete: true, fault: "" });
}

async function expectSynchronized(page: Page, running: Kernel): Promise<void> {
  const view = page.locator("isosplat-viewer");
  running.write({ set: { isovalue: 120 } });
  const shown = () => view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => e.isovalues);
  await expect.poll(shown).toEqual([120]);
  await view.getByLabel("Isovalue as a number").fill("130");
  await page.keyboard.press("Enter");
  await view.getByRole("application").press("ArrowLeft");
  await expect
    .poll(() => running.values("isovalue", "camera"))
    .toMatchObject({ isovalue: 130, camera: { azimuth: 35 } });
  await expectComplete(running);
  await expect
    .poll(async () => {
      await view.click({ position: { x: 200, y: 150 } });
      return (await running.values("picked")).picked;
    })
    .toMatchObject({
      isovalue: 130,
      position: [expect.any(Number), expect.any(Number), expect.any(Number)],
    });
}

test("the widget reads from the kernel's server, and values go both ways", async ({ page }) => {
  kernel = new Kernel("widget", store);
  await openNotebook(page, lab);
  await showWidget(page, kernel);
  await expectComplete(kernel);
  expect(kernel.asked).toEqual([]);
  await expectSynchronized(page, kernel);
});

test("the widget finds the port behind jupyter-server-proxy", async ({ page }) => {
  kernel = new Kernel("widget", store);
  await openNotebook(page, lab, { proxied: true, host: hub });
  await showWidget(page, kernel);
  await expectComplete(kernel);
  expect(kernel.asked).toEqual([]);
});

test("a kernel that is restarted has another server, and shows its volume in the same page", async ({
  page,
}) => {
  kernel = new Kernel("widget", store);
  await openNotebook(page, lab);
  await showWidget(page, kernel);
  await expectComplete(kernel);
  await kernel.stop();
  await page.evaluate(() => document.querySelector("isosplat-viewer")?.parentElement?.remove());
  // Scenes need code that the first volume did not.
  const folder = mkdtempSync(join(tmpdir(), "isosplat-kernel-"));
  try {
    const layers = [{ store: "a.isosplat", surfaces: [{ isovalue: 100 }] }];
    copyFileSync(store, join(folder, "a.isosplat"));
    const document = { format: "isosplat-scene", version: 1, layers };
    writeFileSync(join(folder, "scene.json"), JSON.stringify(document));
    kernel = new Kernel("widget", folder);
    await showWidget(page, kernel);
    await expectComplete(kernel);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

test("where no port can be reached, code and bytes come in messages", async ({ page }) => {
  kernel = new Kernel("widget", store);
  await openNotebook(page, lab, { host: hub });
  const requested: string[] = [];
  page.on("request", (request) => requested.push(request.url()));
  await showWidget(page, kernel);
  await expectComplete(kernel);
  const kinds = kernel.asked.map(({ kind }) => kind);
  expect(kinds[0]).toBe("module");
  expect(kinds.filter((kind) => kind === "read").length).toBeGreaterThan(0);
  expect(requested.filter((url) => /^http:\/\/(127\.0\.0\.1|localhost)/.test(url))).toEqual([]);
  await expectSynchronized(page, kernel);
});

test("without anywidget, HTML shows the volume", async ({ page }) => {
  kernel = new Kernel("html", store);
  const { html } = await kernel.next();
  await openNotebook(page, `<!doctype html><div class="output">${html}</div>`);
  const view = page.frameLocator("iframe").locator("isosplat-viewer");
  const state = () =>
    view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => [
      e.isovalues,
      e.progress?.complete,
    ]);
  await expect.poll(state).toEqual([[100], true]);
  expect((await page.locator("iframe").boundingBox())?.height).toBe(300);
});

test("HTML behind the proxy that proxy= names, and a port that cannot be reached", async ({
  page,
}) => {
  kernel = new Kernel("html", store, "/user/me/proxy/{port}");
  const { html } = await kernel.next();
  await openNotebook(page, `<!doctype html>${html}`, { proxied: true, host: hub });
  const view = page.frameLocator("iframe").locator("isosplat-viewer");
  const state = () =>
    view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => e.progress?.complete);
  await expect.poll(state).toBe(true);
  await openNotebook(page, `<!doctype html>${html}`);
  await expect(page.frameLocator("iframe").locator("body")).toContainText("cannot reach port");
});
