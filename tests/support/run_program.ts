/** Runs the program isosplat while servers of the same test keep answering. */
import { spawn } from "node:child_process";
import { program } from "../browser/support/server.ts";

export interface Ran {
  code: number | null;
  stdout: string;
  stderr: string;
}

/** `env`: variables in addition to those of the test; undefined removes one. */
export function runProgram(
  args: readonly string[],
  env: Record<string, string | undefined> = {},
): Promise<Ran> {
  return new Promise((resolve, reject) => {
    const child = spawn(program, args, {
      stdio: ["ignore", "pipe", "pipe"],
      env: { ...process.env, ...env },
    });
    const ran: Ran = { code: null, stdout: "", stderr: "" };
    child.stdout.on("data", (data: Buffer) => (ran.stdout += data.toString()));
    child.stderr.on("data", (data: Buffer) => (ran.stderr += data.toString()));
    child.on("error", reject);
    child.on("close", (code) => resolve({ ...ran, code }));
  });
}
