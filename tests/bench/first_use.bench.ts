// The steps of a new user, from a volume file to a link that a colleague opens: docs/first-use.md.
import { once } from "node:events";
import { mkdirSync, readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "@playwright/test";
import { drop } from "../browser/support/drop.ts";
import { nginx } from "../support/nginx.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { launch, links, Visitor } from "./stream/visit.ts";

const file = "chris_t1.nii.gz";
const link = links[0];
const unpack = "import sys, zipfile; zipfile.ZipFile(sys.argv[1]).extractall(sys.argv[2])";

/** Seconds of each step, by its name, one value per run. */
class Steps {
  readonly #seconds = new Map<string, number[]>();

  add(name: string, seconds: number): void {
    this.#seconds.set(name, [...(this.#seconds.get(name) ?? []), seconds]);
  }

  report(bench: Bench, way: string): void {
    for (const [name, seconds] of this.#seconds) bench.report(way, name, "s", seconds);
  }
}

/** Opens the page of a volume over the link, like a colleague with an empty cache. */
async function openLink(browser: Browser, url: string, steps: Steps): Promise<void> {
  const colleague = await Visitor.arrive(browser, link);
  await colleague.page.goto(url, { waitUntil: "commit" });
  const surface = await colleague.mark("isosplat:surface");
  steps.add("the colleague opens the link: first surface", surface.shown / 1000);
  const complete = await colleague.mark("isosplat:complete");
  steps.add("the colleague's picture is complete", complete.at / 1000);
  await colleague.leave();
}

/** Serves a folder like a web host, and opens its only volume. */
async function share(bench: Bench, browser: Browser, site: string, steps: Steps): Promise<void> {
  const host = await nginx({ folders: [site], cors: "none" });
  try {
    const [store = ""] = readdirSync(join(site, "stores")).filter((name) =>
      name.endsWith(".isosplat"),
    );
    bench.say(`site with ${store}`);
    await openLink(browser, `${host.url}?volume=chris_t1`, steps);
  } finally {
    await host.stop();
  }
}

/** Nothing is installed: the page builds the store, and saves it as a web site. */
async function inBrowser(bench: Bench, volume: string, run: number, steps: Steps): Promise<void> {
  const browser = await launch();
  const host = await nginx({ folders: [join(bench.root, "build/page")], cors: "none" });
  try {
    const visitor = await Visitor.arrive(browser, link);
    const { page } = visitor;
    await page.addInitScript(() => {
      window.addEventListener("drop", () => performance.mark("bench:dropped"), { capture: true });
    });
    const opened = await bench.time(async () => {
      await page.goto(host.url);
      await page.waitForSelector(".device-drop");
    });
    steps.add("open the start page", opened);
    await drop(page, [volume]);
    const dropped = await visitor.mark("bench:dropped");
    const surface = await visitor.mark("isosplat:surface");
    steps.add("drop the file: first surface", (surface.shown - dropped.at) / 1000);
    const built = await visitor.mark("isosplat:built");
    steps.add("the store is built", (built.at - dropped.at) / 1000);
    await page.getByRole("button", { name: "Save this volume" }).click();
    const option = page.locator(".save-option", { hasText: "Web site" });
    const zip = join(bench.folder, `site-${run}.zip`);
    const saved = await bench.time(async () => {
      const download = page.waitForEvent("download");
      await option.getByRole("button").click();
      await (await download).saveAs(zip);
    });
    steps.add("save it as a web site (ZIP)", saved);
    if (run === 0) bench.report("browser alone", "ZIP", "MB", statSync(zip).size / 1e6);
    const site = join(bench.folder, `site-${run}`);
    mkdirSync(site);
    const { seconds } = await bench.command("/usr/bin/python3", ["-c", unpack, zip, site]);
    steps.add("unpack the ZIP on the web host", seconds);
    await visitor.leave();
    await share(bench, browser, site, steps);
  } finally {
    await host.stop();
    await browser.close();
  }
}

/** The program is installed: one command shows the volume, another writes the web site. */
async function withProgram(bench: Bench, volume: string, run: number, steps: Steps): Promise<void> {
  const browser = await launch();
  const stores = join(bench.folder, `cache-${run}`);
  const page = join(bench.root, "build/page");
  const args = ["view", volume, "--port", "0", "--web-root", page];
  const server = bench.start(bench.isosplat, args, { XDG_CACHE_HOME: stores });
  try {
    let address = "";
    const waited = await bench.time(async () => {
      let text = "";
      if (!server.stdout) throw new Error("the program has no output");
      while (!address) {
        const [data] = (await once(server.stdout, "data")) as [Buffer];
        text += data.toString();
        address = /http:\/\/\S+/.exec(text)?.[0] ?? "";
      }
    });
    steps.add("isosplat view: until it prints the address", waited);
    const visitor = await Visitor.arrive(browser);
    await visitor.page.goto(address, { waitUntil: "commit" });
    const surface = await visitor.mark("isosplat:surface");
    steps.add("open the address: first surface", surface.shown / 1000);
    await visitor.leave();
    const folder = join(stores, "isosplat");
    const [name = ""] = readdirSync(folder).filter((entry) => entry.endsWith(".isosplat"));
    const site = join(bench.folder, `published-${run}`);
    const store = join(bench.folder, "chris_t1.isosplat");
    await bench.command("cp", [join(folder, name), store]);
    const publish = ["publish", store, "--to", site, "--web-root", page];
    const { seconds } = await bench.command(bench.isosplat, publish);
    steps.add("isosplat publish", seconds);
    await share(bench, browser, site, steps);
  } finally {
    server.kill();
    await browser.close();
  }
}

export default {
  title: "from a volume file to a colleague's picture, step by step",
  async run(bench) {
    const volume = bench.volume(file);
    if (!volume) return;
    const runs = Math.max(1, Math.min(bench.runs, 5));
    const ways = { "browser alone": inBrowser, "with the program": withProgram };
    for (const [way, take] of Object.entries(ways)) {
      const steps = new Steps();
      for (let run = 0; run < runs; ++run) await take(bench, volume, run, steps);
      steps.report(bench, way);
    }
  },
} satisfies Benchmark;
