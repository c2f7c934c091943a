// A client that visits the server while others flood it.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench } from "../harness/benchmark.ts";

/** The time that a visitor waits after each response, like the delay of a network. */
const delayMs = 5;

/** Requests on a connection. Then the visitor opens another one, which the server must admit. */
const requestsOfConnection = 20;

const script = `
local number = 0
function delay() return ${delayMs} end
function request()
  number = number + 1
  wrk.headers["Connection"] = number % ${requestsOfConnection} == 0 and "close" or "keep-alive"
  return wrk.format("GET", wrk.path)
end
`;

/** Responses with status 200 per second. Refused and incomplete responses do not count. */
export async function visit(bench: Bench, url: string, seconds: number): Promise<number> {
  const file = join(bench.folder, "visitor.lua");
  writeFileSync(file, script);
  // biome-ignore format: options with their values
  const { stdout } = await bench.command("wrk", [
    "-t1", "-c4", `-d${seconds}s`, "--timeout", "30s", "-s", file, url,
  ]);
  const [, answers, time] = stdout.match(/(\d+) requests in ([\d.]+)s/) ?? [];
  if (!answers || !time) throw new Error(`wrk ${url}:\n${stdout}`);
  const refused = Number(stdout.match(/Non-2xx or 3xx responses: (\d+)/)?.[1] ?? 0);
  return (Number(answers) - refused) / Number(time);
}
