/** nginx as a typical static host: the configuration sets only the folder and a few settings. */
import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import type { AddressInfo } from "node:net";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { writtenLog } from "./written_log.ts";

const program = ["/usr/sbin/nginx", "nginx"].find(
  (candidate) => spawnSync(candidate, ["-v"]).error === undefined,
);

/** Whether nginx is installed. */
export const hasNginx = program !== undefined;

export interface NginxOptions {
  /** Folders to search, in this order. */
  folders: readonly string[];
  /**
   * Whether Range requests are supported (default). Without it, responses are whole files with
   * `no-store`: if a browser had the whole file in its cache, it would answer Range requests from
   * there.
   */
  range?: boolean;
  /**
   * The access of pages of other origins. all (default): they can read every response, including
   * Content-Range, Content-Length and ETag. body: every response without these fields. none:
   * nothing.
   */
  cors?: "all" | "body" | "none";
  /** Default: a free port. */
  port?: number;
}

export interface Nginx {
  /** With a slash at the end. */
  url: string;
  /**
   * The lines of the access log, including those of all responses that were received before the
   * call.
   */
  accessLog(): Promise<string[]>;
  stop(): Promise<void>;
}

export async function nginx(options: NginxOptions): Promise<Nginx> {
  if (!program) throw new Error("nginx is missing: .ci/install-packages --for test");
  const folder = mkdtempSync(join(tmpdir(), "isosplat-nginx-"));
  const port = options.port ?? (await freePort());
  const { cors = "all" } = options;
  const headers = [
    ...(options.range === false ? ["Cache-Control no-store"] : []),
    ...(cors === "none" ? [] : ["Access-Control-Allow-Origin *"]),
    ...(cors === "all"
      ? ['Access-Control-Expose-Headers "Content-Range, Content-Length, ETag"']
      : []),
  ];
  const locations = options.folders.map((root, i) => {
    const next = i + 1 < options.folders.length ? `@${i + 1}` : "=404";
    return `location ${i === 0 ? "/" : `@${i}`} { root ${resolve(root)}; try_files $uri $uri/index.html ${next}; }`;
  });
  // If the test runs as root, nginx must do so too: other users cannot read the temporary folders.
  const user = process.getuid?.() === 0 ? "user root;" : "";
  writeFileSync(
    join(folder, "nginx.conf"),
    `daemon off; ${user} pid ${folder}/pid; error_log ${folder}/errors;
    events {}
    http {
      access_log ${folder}/access;
      types { text/html html; text/javascript js; text/css css; image/svg+xml svg; }
      client_body_temp_path ${folder}/1; proxy_temp_path ${folder}/2; fastcgi_temp_path ${folder}/3;
      uwsgi_temp_path ${folder}/4; scgi_temp_path ${folder}/5;
      ${options.range === false ? "max_ranges 0;" : ""}
      ${headers.map((field) => `add_header ${field} always;`).join(" ")}
      server { listen 127.0.0.1:${port}; ${locations.join("\n")} }
    }`,
  );
  const server = spawn(program, ["-p", folder, "-c", join(folder, "nginx.conf")], {
    stdio: "ignore",
  });
  const url = `http://127.0.0.1:${port}/`;
  for (let attempt = 0; ; ++attempt) {
    if (await fetch(url, { method: "HEAD" }).catch(() => undefined)) break;
    if (attempt === 200 || server.exitCode !== null) {
      throw new Error(`nginx did not start: ${readFileSync(join(folder, "errors"), "utf8")}`);
    }
    await new Promise((next) => setTimeout(next, 50));
  }
  return {
    url,
    accessLog: async () => {
      const lines = await writtenLog(join(folder, "access"), async (name) => {
        const response = await fetch(url + name, { headers: { connection: "close" } });
        await response.arrayBuffer();
      });
      // The first line is the request that checks whether nginx has started.
      return lines.slice(1);
    },
    stop: () => stopped(server, folder),
  };
}

async function stopped(server: ChildProcess, folder: string): Promise<void> {
  if (server.exitCode === null) {
    const ended = new Promise((resolve) => server.once("exit", resolve));
    server.kill("SIGTERM");
    await ended;
  }
  rmSync(folder, { recursive: true, force: true });
}

export async function freePort(): Promise<number> {
  const server = createServer();
  await new Promise<void>((next) => server.listen(0, "127.0.0.1", next));
  const { port } = server.address() as AddressInfo;
  await new Promise((next) => server.close(next));
  return port;
}
