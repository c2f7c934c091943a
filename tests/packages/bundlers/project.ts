/** A project of a bundler in a temporary folder, with the packages that it names, from npm. */
import { type ChildProcess, execFile, spawn } from "node:child_process";
import { cpSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { freePort, nginx } from "../../support/nginx.ts";
import { tarball } from "../npm/consumer.ts";
import type { Fixture, Way } from "./fixtures.ts";

export const projects = fileURLToPath(new URL("projects", import.meta.url));

/** The environment of all commands: no colours, and no telemetry. */
const environment = {
  ...process.env,
  NO_COLOR: "1",
  CI: "1",
  ASTRO_TELEMETRY_DISABLED: "1",
  NEXT_TELEMETRY_DISABLED: "1",
  NUXT_TELEMETRY_DISABLED: "1",
};

export interface Served {
  /** With a slash at the end. */
  url: string;
  stop(): Promise<void>;
}

export class Project {
  readonly folder = mkdtempSync(join(tmpdir(), "isosplat-bundler-"));
  readonly #environment: NodeJS.ProcessEnv;

  /** `store`: the address that its pages show. */
  constructor(fixture: Fixture, store: string) {
    cpSync(join(projects, fixture.project), this.folder, { recursive: true });
    for (const file of readdirSync(this.folder, { recursive: true, encoding: "utf8" })) {
      if (!/\.(html|jsx|svelte|astro|vue)$/.test(file)) continue;
      const path = join(this.folder, file);
      writeFileSync(path, readFileSync(path, "utf8").replaceAll("STORE", store));
    }
    const dependencies = { ...fixture.packages, isosplat: `file:${tarball}` };
    const manifest = { private: true, type: "module", ...fixture.manifest, dependencies };
    writeFileSync(join(this.folder, "package.json"), JSON.stringify(manifest, null, 2));
    const programs = join(this.folder, "node_modules/.bin");
    this.#environment = { ...environment, PATH: `${programs}:${process.env.PATH}` };
  }

  install(): Promise<void> {
    // `npm run` passes on engine-strict; some projects bring a newer Node along.
    return this.#run("npm install --engine-strict=false --no-audit --no-fund --prefer-offline");
  }

  /** Makes the page in one of the fixture's ways, and serves it, if the way has one. */
  async serve({ commands = [], serves }: Way): Promise<Served | undefined> {
    for (const command of commands) await this.#run(command);
    if (!serves) return undefined;
    if ("folder" in serves) return nginx({ folders: [join(this.folder, serves.folder)] });
    const port = await freePort();
    return this.#listen(serves.command(port), `http://127.0.0.1:${port}/`);
  }

  remove(): void {
    rmSync(this.folder, { recursive: true, force: true });
  }

  /** Rejects with what the command has printed. */
  async #run(command: string): Promise<void> {
    const options = { cwd: this.folder, env: this.#environment, maxBuffer: 1 << 26 };
    await promisify(execFile)("bash", ["-c", command], options).catch((error) => {
      const { stdout, stderr } = error as { stdout: string; stderr: string };
      throw new Error(`${command}\n${lastLines(stdout + stderr)}`);
    });
  }

  async #listen(command: string, url: string): Promise<Served> {
    // A group of processes, since tools start others.
    const child = spawn("bash", ["-c", `exec ${command}`], {
      cwd: this.folder,
      env: this.#environment,
      detached: true,
      stdio: ["ignore", "pipe", "pipe"],
    });
    let printed = "";
    for (const stream of [child.stdout, child.stderr]) {
      stream?.on("data", (data: Buffer) => {
        printed += data.toString();
      });
    }
    for (let attempt = 0; ; ++attempt) {
      if (await fetch(url, { method: "HEAD" }).catch(() => undefined)) break;
      if (attempt === 600 || child.exitCode !== null) {
        await end(child);
        throw new Error(`${command}: expected a server at ${url}, found\n${lastLines(printed)}`);
      }
      await new Promise((next) => setTimeout(next, 200));
    }
    return { url, stop: () => end(child) };
  }
}

async function end(child: ChildProcess): Promise<void> {
  if (child.exitCode !== null || child.signalCode !== null || !child.pid) return;
  const ended = new Promise((resolve) => child.once("exit", resolve));
  process.kill(-child.pid, "SIGTERM");
  const timer = setTimeout(() => child.pid && process.kill(-child.pid, "SIGKILL"), 5000);
  await ended;
  clearTimeout(timer);
}

function lastLines(text: string): string {
  return text.trim().split("\n").slice(-40).join("\n");
}
