// Loads a server with wrk.
import type { Bench } from "../harness/benchmark.ts";

export interface Load {
  requestsPerSecond: number;
  /** Bytes of bodies and header fields per second. */
  bytesPerSecond: number;
  p99Ms: number;
}

const milliseconds = { us: 0.001, ms: 1, s: 1000, m: 60_000 };
const bytes = { B: 1, KB: 2 ** 10, MB: 2 ** 20, GB: 2 ** 30 };

/** Requests one address repeatedly, on this many keep-alive connections. */
export async function load(
  bench: Bench,
  url: string,
  { connections = 32, seconds = 3 } = {},
): Promise<Load> {
  const threads = Math.min(2, connections);
  // biome-ignore format: options with their values
  const options = [`-t${threads}`, `-c${connections}`, `-d${seconds}s`, "--timeout", "60s", "--latency"];
  const { stdout } = await bench.command("wrk", [...options, url]);
  const rate = stdout.match(/Requests\/sec:\s+([\d.]+)/)?.[1];
  const [, p99, unit] = stdout.match(/99%\s+([\d.]+)(us|ms|s|m)\b/) ?? [];
  const [, moved, size] = stdout.match(/Transfer\/sec:\s+([\d.]+)(B|KB|MB|GB)/) ?? [];
  if (!rate || !p99 || !moved || /Non-2xx|Socket errors/.test(stdout)) {
    throw new Error(`wrk ${url}:\n${stdout}`);
  }
  return {
    requestsPerSecond: Number(rate),
    bytesPerSecond: Number(moved) * bytes[size as keyof typeof bytes],
    p99Ms: Number(p99) * milliseconds[unit as keyof typeof milliseconds],
  };
}
