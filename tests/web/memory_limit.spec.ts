/** The program under a memory limit (ulimit -v): it answers 503, and continues. */
import { spawn } from "node:child_process";
import { once } from "node:events";
import { get } from "node:http";
import { availableParallelism } from "node:os";
import { fileURLToPath } from "node:url";
import { expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { freePort } from "../support/nginx.ts";

const store = fileURLToPath(new URL("../golden/v1.0/u8.isosplat", import.meta.url));

/** The status and the body of an answer; the status 0 if the connection was closed without one. */
function ask(port: number, path: string): Promise<{ status: number; body: string }> {
  return new Promise((resolve) => {
    const request = get({ host: "127.0.0.1", port, path, agent: false }, (answer) => {
      let body = "";
      answer.on("data", (part: Buffer) => (body += part.toString("latin1")));
      answer.on("end", () => resolve({ status: answer.statusCode ?? 0, body }));
      answer.on("error", () => resolve({ status: 0, body }));
    });
    request.on("error", () => resolve({ status: 0, body: "" }));
  });
}

test("a server under ulimit -v serves what it can, and continues", {
  timeout: 60_000,
}, async () => {
  const port = await freePort();
  // The memory that it needs to start, and little more. It has one computing thread for two cores.
  const kilobytes = 185_000 + 1100 * availableParallelism();
  // biome-ignore format: options with their values
  const server = spawn("bash", [
    "-c", `ulimit -v ${kilobytes} && exec "$@"`, "bash",
    program, "serve", store, "--port", String(port), "--threads", "2", "--disk-threads", "4",
  ], { stdio: ["ignore", "pipe", "ignore"] });
  await once(server.stdout, "data");
  const { contentId, range } = JSON.parse((await ask(port, "/v1/volumes/u8")).body);
  const content = `/v1/volumes/u8/${contentId}`;
  const paths = [
    `${content}/samples?isovalue=${(range[0] + range[1]) / 2}`,
    `${content}/file`,
    `${content}/chunks?isovalue=${range[0]}..${range[1]}&level=0`,
    "/v1/volumes",
  ];
  const statuses = new Set<number>();
  const loop = async (index: number) => {
    for (let i = 0; i < 12; ++i) {
      statuses.add((await ask(port, paths[(index + i) % paths.length] ?? "")).status);
    }
  };
  await Promise.all(Array.from({ length: 60 }, (_, index) => loop(index)));
  expect(server.exitCode).toBe(null);
  expect([...statuses].filter((status) => ![0, 200, 503].includes(status))).toEqual([]);
  expect(statuses).toContain(200);
  for (const path of paths) expect((await ask(port, path)).status, path).toBe(200);
  server.kill("SIGTERM");
  const [code] = await once(server, "exit");
  expect(code).toBe(0);
});
