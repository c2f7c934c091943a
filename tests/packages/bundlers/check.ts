/** See the script `check` beside it. */
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import type { Pixels } from "../../browser/support/pixels.ts";
import { nginx } from "../../support/nginx.ts";
import { root, tarball } from "../npm/consumer.ts";
import { type Fixture, fixtures, table } from "./fixtures.ts";
import { coverage, difference, pictureOf } from "./picture.ts";
import { Project } from "./project.ts";

const [minCoverage, maxDifference] = [0.05, 0.002];

let [passed, failed] = [0, 0];

/** Runs one check, and goes on if it fails. */
async function check(name: string, run: () => Promise<void>): Promise<void> {
  const begin = performance.now();
  const seconds = () => `${((performance.now() - begin) / 1000).toFixed(0)} s`;
  try {
    await run();
    ++passed;
    console.log(`✓ ${name} (${seconds()})`);
  } catch (error) {
    ++failed;
    const text = error instanceof Error ? error.message : String(error);
    console.log(`✗ ${name} (${seconds()})\n${text.replaceAll(/^/gm, "    ")}`);
  }
}

/** The picture of the element in a page without a bundler. `folder`: the unpacked package, and the page. */
async function expectedPicture(folder: string, store: string): Promise<Pixels> {
  writeFileSync(
    join(folder, "bare.html"),
    `<!doctype html><script type="module" src="./package/index.js"></script>
    <isosplat-viewer src="${store}" isovalue="100" style="width: 400px"></isosplat-viewer>`,
  );
  const server = await nginx({ folders: [folder] });
  try {
    const picture = await pictureOf(`${server.url}bare.html`);
    const share = coverage(picture);
    if (share < minCoverage) throw new Error(`expected a picture, found a coverage of ${share}`);
    return picture;
  } finally {
    await server.stop();
  }
}

async function checkFixture(fixture: Fixture, store: string, expected: Pixels): Promise<void> {
  const project = new Project(fixture, store);
  let isInstalled = false;
  try {
    await check(`${fixture.name}: install`, async () => {
      await project.install();
      isInstalled = true;
    });
    if (!isInstalled) return;
    for (const way of fixture.ways) {
      await check(`${fixture.name}: ${way.name}`, async () => {
        const server = await project.serve(way);
        if (!server) return;
        try {
          for (const path of fixture.pages ?? [""]) {
            const picture = await pictureOf(server.url + path);
            const share = difference(picture, expected);
            if (share > maxDifference) {
              const found = `${share} of the pixels differ, and ${coverage(picture)} are covered`;
              throw new Error(`/${path}: ${found}; expected at most ${maxDifference}`);
            }
          }
        } finally {
          await server.stop();
        }
      });
    }
  } finally {
    project.remove();
  }
}

async function main(options: string[]): Promise<void> {
  const report = options[0] === "--report" ? options.splice(0, 2)[1] : undefined;
  if (options[0] === "--table") return console.log(table());
  if (options[0] === "--list") {
    for (const { name, packages } of fixtures) {
      const list = Object.entries(packages).map(([name, version]) => `${name}@${version}`);
      console.log(`${name}: ${list.join(" ")}`);
    }
    return;
  }
  const unknown = options.find((name) => !fixtures.some((fixture) => fixture.name === name));
  if (unknown) {
    const names = fixtures.map(({ name }) => name).join(", ");
    throw new Error(`${unknown}: expected some of ${names}`);
  }
  if (!existsSync(tarball)) throw new Error(`${tarball} is missing: npm run build:package`);
  const folder = mkdtempSync(join(tmpdir(), "isosplat-bare-"));
  execFileSync("tar", ["-xzf", tarball, "-C", folder]);
  const host = await nginx({ folders: [join(root, "tests/golden/v1.0")] });
  try {
    const store = `${host.url}u8.isosplat`;
    const expected = await expectedPicture(folder, store);
    for (const fixture of fixtures) {
      if (options.length > 0 && !options.includes(fixture.name)) continue;
      await checkFixture(fixture, store, expected);
    }
  } finally {
    await host.stop();
    rmSync(folder, { recursive: true, force: true });
  }
  console.log(`${passed} passed, ${failed} failed`);
  if (report) writeFileSync(report, `${JSON.stringify({ passed, failed, skipped: 0 })}\n`);
  if (failed > 0) process.exitCode = 1;
}

await main(process.argv.slice(2));
