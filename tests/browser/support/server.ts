import { type ChildProcess, spawn } from "node:child_process";
import { existsSync } from "node:fs";

export const program = process.env.ISOSPLAT ?? "build/release/native/cli/isosplat";
export const demoFolder = process.env.ISOSPLAT_DEMO ?? "build/demo";

/** A running `isosplat serve`, on its own port. */
export interface RunningServer {
  /** With a slash at the end. */
  url: string;
  /** Stops the server and waits. Does nothing if it has already ended. */
  stop(): Promise<void>;
  signal(name: NodeJS.Signals): void;
}

/**
 * Serves stores (files or folders) and the page. `port` 0: any free port. `more`: further options, which
 * may name another page (`--web-root`).
 */
export async function serve(
  stores: readonly string[],
  port = 0,
  more: readonly string[] = [],
): Promise<RunningServer> {
  if (!existsSync(program)) throw new Error(`${program} is missing: run .ci/build release`);
  const page = more.includes("--web-root") ? [] : ["--web-root", "build/page"];
  const options = ["serve", ...stores, "--port", String(port), ...page, ...more];
  const child = spawn(program, options, { stdio: ["ignore", "pipe", "pipe"] });
  const url = await addressOf(child);
  return { url, stop: () => ended(child), signal: (name) => void child.kill(name) };
}

function addressOf(child: ChildProcess): Promise<string> {
  return new Promise((resolve, reject) => {
    let output = "";
    const listen = (data: Buffer) => {
      output += data.toString();
      const address = /(https?):\/\/(?:localhost|127\.0\.0\.1):(\d+)/.exec(output);
      if (address) resolve(`${address[1]}://127.0.0.1:${address[2]}/`);
    };
    child.stdout?.on("data", listen);
    child.stderr?.on("data", listen);
    child.on("exit", (code) =>
      reject(new Error(`the server ended with status ${code}: ${output}`)),
    );
    child.on("error", reject);
  });
}

function ended(child: ChildProcess): Promise<void> {
  if (child.exitCode !== null || child.signalCode !== null) return Promise.resolve();
  return new Promise((resolve) => {
    child.on("exit", () => resolve());
    child.kill("SIGTERM");
    setTimeout(() => child.kill("SIGKILL"), 3000).unref();
  });
}
