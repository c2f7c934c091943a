// The element of the package where a page keeps it from starting, and where it comes from another origin.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { type Nginx, nginx } from "../../support/nginx.ts";
import { type Consumer, consumer } from "./consumer.ts";

let project: Consumer;
let own: Nginx;
let other: Nginx;

test.beforeAll(async () => {
  test.setTimeout(120_000);
  project = consumer();
  own = await nginx({ folders: [project.folder] });
  other = await nginx({ folders: [project.folder] });
});

test.afterAll(async () => {
  await own?.stop();
  await other?.stop();
  project?.remove();
});

/** The policies that the README states, in its order: for an own package, and for one of another origin. */
function policies(): string[] {
  const readme = readFileSync(join(project.folder, "node_modules/isosplat/README.md"), "utf8");
  return [...readme.matchAll(/^```text\n(script-src .*)\n```$/gm)].map(([, policy = ""]) => policy);
}

/** A page with the element, whose scripts come from `host`. */
async function open(page: Page, policy: string, host = ""): Promise<void> {
  project.write(
    "view.html",
    `<!doctype html>
    <meta http-equiv="Content-Security-Policy" content="default-src 'none'; ${policy}" />
    <isosplat-viewer src="head.isosplat" isovalue="60.5"></isosplat-viewer>
    <script type="module" src="${host}./node_modules/isosplat/index.js"></script>`,
  );
  await page.addInitScript(() => {
    const faults: string[] = [];
    Object.assign(window, { faults });
    const note = (event: Event) => faults.push((event as CustomEvent<Error>).detail.message);
    addEventListener("fault", note, true);
  });
  await page.goto(`${own.url}view.html`);
}

/** Waits for the element's message, and checks that the event `fault` contained it. */
async function faultOf(page: Page): Promise<string> {
  const message = page.locator("isosplat-viewer").getByRole("status");
  await expect(message).toBeVisible();
  const text = (await message.textContent()) ?? "";
  const faults = await page.evaluate(() => (window as never as { faults: string[] }).faults);
  // What happened comes first.
  expect(faults.filter((fault) => text.endsWith(`: ${fault}`))).not.toEqual([]);
  return text;
}

/** Waits for the whole picture, which may take as long as it takes; nothing may be reported meanwhile. */
async function isDrawn(page: Page): Promise<void> {
  const view = page.locator("isosplat-viewer");
  await expect
    .poll(() =>
      view.evaluate(async (e: HTMLElementTagNameMap["isosplat-viewer"]) => {
        if (!e.progress?.complete) return 0;
        return (await createImageBitmap(await e.screenshot())).width;
      }),
    )
    .toBeGreaterThan(0);
  expect(await page.evaluate(() => (window as never as { faults: string[] }).faults)).toEqual([]);
}

/** The messages about policies in the browser's console. */
function refusals(page: Page): string[] {
  const found: string[] = [];
  page.on("console", (message) => {
    if (/Content Security Policy|violates/.test(message.text())) found.push(message.text());
  });
  return found;
}

test("the policy that the README states is enough", async ({ page }) => {
  const found = refusals(page);
  await open(page, policies()[0] ?? "");
  await isDrawn(page);
  // The style sheet is in force.
  await expect(page.locator("isosplat-viewer")).toHaveCSS("display", "block");
  expect(found).toEqual([]);
});

test("scripts of another origin, with the policy that the README states for them", async ({
  page,
}) => {
  const found = refusals(page);
  const policy = policies()[1]?.replaceAll("https://cdn.example", other.url) ?? "";
  expect(policy).toContain(other.url);
  await open(page, policy, other.url);
  await isDrawn(page);
  expect(found).toEqual([]);
  expect((await other.accessLog()).join("\n")).toContain("decode_worker.js");
});

const enough = () => policies()[0] ?? "";

test("a policy without wasm-unsafe-eval is reported", async ({ page }) => {
  await open(page, enough().replace(" 'wasm-unsafe-eval'", ""));
  expect(await faultOf(page)).toMatch(/isosplat-renderer\.wasm: .*'wasm-unsafe-eval'/);
});

test("a policy without workers is reported", async ({ page }) => {
  await open(page, enough().replace("worker-src 'self'", "worker-src 'none'"));
  expect(await faultOf(page)).toContain("decode_worker.js");
});

test("WebAssembly that is missing is reported", async ({ page }) => {
  await page.route("**/isosplat-renderer.wasm", (route) => route.fulfill({ status: 404 }));
  await open(page, enough());
  expect(await faultOf(page)).toMatch(/isosplat-renderer\.wasm, found status 404/);
});

test("a page in place of WebAssembly is reported", async ({ page }) => {
  const html = { status: 200, contentType: "text/html", body: "<!doctype html>" };
  await page.route("**/isosplat-renderer.wasm", (route) => route.fulfill(html));
  await open(page, enough());
  expect(await faultOf(page)).toMatch(/isosplat-renderer\.wasm, found a page/);
});

test("WebAssembly that never arrives is reported", async ({ page }) => {
  await page.route("**/isosplat-renderer.wasm", () => {});
  await open(page, enough());
  expect(await faultOf(page)).toContain("the renderer has not arrived for 4 s");
});

test("a worker whose program is missing is reported", async ({ page }) => {
  await page.route("**/decode_worker.js", (route) => route.fulfill({ status: 404 }));
  await open(page, enough());
  expect(await faultOf(page)).toContain("decode_worker.js");
});

test("a worker that does not answer is reported", async ({ page }) => {
  const body = "self.onmessage = () => {};";
  await page.route("**/decode_worker.js", (route) =>
    route.fulfill({ status: 200, contentType: "text/javascript", body }),
  );
  await open(page, enough());
  expect(await faultOf(page)).toContain("no worker has answered for 4 s");
});

test("setAssetBase: workers and WebAssembly come from a copy", async ({ page }) => {
  project.write(
    "based.html",
    `<!doctype html><isosplat-viewer src="head.isosplat" isovalue="60.5"></isosplat-viewer>
    <script type="module">
      import { setAssetBase } from "./node_modules/isosplat/index.js";
      setAssetBase("${other.url}node_modules/isosplat/assets");
    </script>`,
  );
  await open(page, enough()); // for the listener of faults
  await page.goto(`${own.url}based.html`);
  await isDrawn(page);
  const log = (await other.accessLog()).join("\n");
  for (const file of ["isosplat-renderer.wasm", "decode_worker.js"]) {
    expect(log).toContain(`/node_modules/isosplat/assets/${file}`);
  }
});
