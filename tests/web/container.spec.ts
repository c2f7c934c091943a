/**
 * Runs the commands of native/packaging/Containerfile outside of a container. The server must start
 * with them, and the health check must succeed only for a server that is ready.
 */
import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterEach, describe, expect, test } from "vitest";
import { makeCertificate } from "../support/certificate.ts";
import { freePort } from "../support/nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const lines = readFileSync(join(root, "native/packaging/Containerfile"), "utf8").split("\n");

/** The command of an instruction in its JSON form. */
function command(instruction: string): string[] {
  const line = lines.find((candidate) => candidate.startsWith(`${instruction} `)) ?? "";
  return JSON.parse(line.slice(line.indexOf("["))) as string[];
}

describe("the container file", () => {
  const folders: string[] = [];
  let server: ChildProcess | undefined;

  afterEach(async () => {
    if (server?.exitCode === null) {
      server.kill("SIGTERM");
      await once(server, "exit");
    }
    for (const folder of folders) rmSync(folder, { recursive: true, force: true });
  });

  /** The exit status of the health check of a server with this file. */
  async function health(
    file: (path: string) => void,
    more: (folder: string) => string[] = () => [],
  ): Promise<number | null> {
    const folder = mkdtempSync(join(tmpdir(), "isosplat-container-"));
    folders.push(folder);
    file(join(folder, "store.isosplat"));
    const port = String(await freePort());
    const here = (part: string) =>
      part.replaceAll("/var/lib/isosplat", folder).replaceAll("8080", port);
    const [name, ...options] = [...command("ENTRYPOINT"), ...command("CMD")].map(here);
    expect(name).toBe("isosplat");
    const program = join(root, "build/release/native/cli/isosplat");
    server = spawn(program, [...options, ...more(folder)], {
      stdio: ["ignore", "pipe", "ignore"],
    });
    if (server.stdout) await once(server.stdout, "data");
    const [checker, ...check] = command("HEALTHCHECK").map(here);
    expect(checker).toBe("isosplat");
    return spawnSync(program, check).status;
  }

  test("serves, and is healthy", async () => {
    const store = join(root, "tests/golden/v1.0/u8.isosplat");
    expect(await health((path) => copyFileSync(store, path))).toBe(0);
  });

  test("is healthy with a TLS certificate for another name", async () => {
    const store = join(root, "tests/golden/v1.0/u8.isosplat");
    const withTls = (folder: string) => {
      const { certificate, key } = makeCertificate(folder, "volumes.example");
      return ["--tls-cert", certificate, "--tls-key", key];
    };
    expect(await health((path) => copyFileSync(store, path), withTls)).toBe(0);
  });

  test("is not healthy without a store that can be read", async () => {
    expect(await health((path) => writeFileSync(path, "not a store"))).not.toBe(0);
  });

  test("runs as a user without privileges", () => {
    const user = lines.find((line) => line.startsWith("USER "))?.slice(5);
    expect(user).toMatch(/^[1-9]\d*:[1-9]\d*$/);
  });
});
