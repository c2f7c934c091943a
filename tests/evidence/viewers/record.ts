/**
 * Records visits of the page's client to the real server, behind nginx, over a link like that of
 * visitors.
 */
import { loadCore } from "../../../web/core/index.ts";
import { openDelayedLink } from "../../bench/harness/delayed_link.ts";
import { Chance } from "../../support/chance.ts";
import { connectToProxy, type PackagedNginx } from "../../support/packaged_nginx.ts";
import { installFetch, VisitRecorder } from "./http2_fetch.ts";
import type { RecordedVisit } from "./requests.ts";
import { ScriptedVisitor, scripts } from "./scripted_visitor.ts";

export interface Wanted {
  volume: string;
  /** A name of `scripts`. */
  scenario: string;
  /** Seed of the random numbers. The same seed gives the same gestures. */
  seed: number;
}

export interface RecordOptions {
  /** Number of concurrent visits. */
  together: number;
  /** Round-trip time of each visitor's link. */
  roundTripMs: number;
  megabitsPerSecond: number;
  /** Whether clients know that they have HTTP/2. Otherwise they request chunks in batches. */
  isMultiplexed: boolean;
}

/** Records visits. The results have the order of `wanted`. */
export async function record(
  proxy: PackagedNginx,
  wanted: readonly Wanted[],
  { together, roundTripMs, megabitsPerSecond, isMultiplexed }: RecordOptions,
): Promise<RecordedVisit[]> {
  const core = await loadCore();
  const link = await openDelayedLink(proxy.port, roundTripMs, megabitsPerSecond);
  const recorders = new Map<string, VisitRecorder>();
  const uninstall = installFetch(recorders);
  const base = `https://volumes.example:${link.port}/`;

  async function one({ volume, scenario, seed }: Wanted, name: string): Promise<RecordedVisit> {
    const script = scripts[scenario];
    if (!script) throw new Error(`no script "${scenario}"`);
    const connection = await connectToProxy({ ...proxy, port: link.port });
    const recorder = new VisitRecorder(connection, isMultiplexed);
    recorders.set(name, recorder);
    let fault: Error | undefined;
    const fail = (error: Error) => {
      fault ??= error;
    };
    try {
      const place = { base, volume };
      const visitor = await ScriptedVisitor.arrive(core, place, name, new Chance(seed), fail);
      await script(visitor);
      visitor.leave();
      if (fault) throw fault;
      return { volume, scenario, requests: recorder.requests, duration: recorder.now };
    } finally {
      connection.destroy();
    }
  }

  const visits: RecordedVisit[] = [];
  let next = 0;
  const worker = async () => {
    for (let i = next++; i < wanted.length; i = next++) {
      visits[i] = await one(wanted[i] as Wanted, String(i));
    }
  };
  try {
    await Promise.all(Array.from({ length: together }, worker));
  } finally {
    uninstall();
    link.close();
    core.close();
  }
  return visits;
}
