import type { Builder } from "./builder.ts";
import type { BuildLimits, BuildReport, VolumeDescription } from "./types.ts";

/** Encodes blocks, here or in a worker. */
export interface Encoder {
  setUp(setup: Uint8Array): Promise<void>;
  /** The buffer of `task` may be transferred. */
  encode(task: Uint8Array): Promise<Uint8Array>;
  statistics(): Promise<Uint8Array>;
}

/**
 * Number of tasks that an encoder has at a time, so that it never waits for the director between two
 * tasks.
 */
const tasksPerEncoder = 2;

/**
 * Builds a store: distributes the tasks of a build to encoders, and adds their blocks in any order.
 * Rejects with the first error, and then distributes no more tasks. `signal` cancels.
 */
export async function directBuild(
  builder: Builder,
  encoders: readonly Encoder[],
  volume: VolumeDescription,
  limits: BuildLimits = {},
  signal?: AbortSignal,
): Promise<BuildReport> {
  const setup = builder.begin(volume, { encoders: encoders.length, ...limits });
  await Promise.all(encoders.map((encoder) => encoder.setUp(setup)));

  let isEnded = false;
  let wake: () => void = () => {};
  let blockAdded = new Promise<void>((resolve) => {
    wake = resolve;
  });
  const feed = async (encoder: Encoder): Promise<void> => {
    while (!isEnded) {
      signal?.throwIfAborted();
      const next = builder.next();
      if (next === "complete") return;
      if (next === "wait") {
        await blockAdded;
        continue;
      }
      const block = await encoder.encode(next);
      if (isEnded) return;
      builder.add(block);
      wake();
      blockAdded = new Promise((resolve) => {
        wake = resolve;
      });
    }
  };
  const feeds = encoders.flatMap((encoder) =>
    Array.from({ length: tasksPerEncoder }, () => feed(encoder)),
  );
  try {
    await Promise.all(feeds);
  } finally {
    isEnded = true;
    wake();
  }
  for (const encoder of encoders) builder.addStatistics(await encoder.statistics());
  signal?.throwIfAborted();
  return builder.finish();
}
