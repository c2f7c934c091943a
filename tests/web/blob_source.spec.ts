/** A store on this device, which is a Blob and has no address. */
import { beforeAll, expect, test } from "vitest";
import type { Core } from "../../web/core/index.ts";
import { BlobSource, StreamError } from "../../web/stream/index.ts";
import { core as load, openWhole, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

const { signal } = new AbortController();
let core: Core;
let bytes: Uint8Array;
beforeAll(async () => {
  core = await load();
  bytes = storeBytes();
});

const blobOf = (part: Uint8Array) => new Blob([part as BlobPart]);
const kindOf = (failed: Promise<unknown>) =>
  failed.then(
    () => "none",
    (error: unknown) => (error instanceof StreamError ? error.kind : String(error)),
  );

test("streams until the picture is complete", async () => {
  const harness = new Harness();
  const source = new BlobSource(blobOf(bytes), "fixture");
  const session = await harness.open(source, core, { firstIsovalues: [100.5] });
  try {
    session.update(view(100.5));
    await harness.complete();
    expect(harness.errors).toEqual([]);
    expect(harness.progress?.finestLevel).toBe(0);
    expect(source.bytesReceived).toBeGreaterThan(1000);
    expect(source.requests).toBeGreaterThan(1);
  } finally {
    harness.close();
  }
});

test("chunks, pages and ranges are those of the file", async () => {
  const store = openWhole(core, bytes);
  const source = new BlobSource(blobOf(bytes), "fixture");
  const chunks = store.chunksFor(0, 100.5);
  expect(chunks.length).toBeGreaterThan(2);
  let arrived = 0;
  await source.chunks(chunks, signal, (chunk, read) => {
    ++arrived;
    expect(read).toEqual(bytes.slice(chunk.offset, chunk.offset + chunk.bytes));
  });
  expect(arrived).toBe(chunks.length);
  expect(source.group(chunks).flat()).toEqual(chunks);
  await source.pages(store.pages(), signal, (index, read) => {
    const page = store.pages()[index];
    expect(read).toEqual(bytes.slice(page?.offset, (page?.offset ?? 0) + (page?.bytes ?? 0)));
  });
  expect(await source.contentId(signal)).toBe(store.info.contentId);
  store.close();
});

test("files that are not stores, are truncated or cannot be read have their faults", async () => {
  expect(await kindOf(new BlobSource(new Blob(["text"]), "a.txt").header(signal))).toBe(
    "not-a-store",
  );
  expect(await kindOf(new BlobSource(new Blob(), "empty").header(signal))).toBe("not-a-store");
  const cut = new BlobSource(blobOf(bytes.subarray(0, 30_000)), "cut");
  expect(await kindOf(cut.range(29_000, 2000, signal, () => {}))).toBe("cut-short");
  const harness = new Harness();
  expect(await kindOf(harness.open(cut, core))).toBe("cut-short");
  class Removed extends Blob {
    override slice(): Blob {
      return new Removed();
    }
    override arrayBuffer(): Promise<ArrayBuffer> {
      return Promise.reject(new DOMException("gone", "NotReadableError"));
    }
    override get size(): number {
      return 1000;
    }
  }
  const removed = new BlobSource(new Removed(), "removed");
  expect(await kindOf(removed.header(signal))).toBe("unreachable");
});

test("an aborted call rejects with the reason", async () => {
  const source = new BlobSource(blobOf(bytes), "fixture");
  await expect(source.header(AbortSignal.abort(new Error("enough")))).rejects.toThrow("enough");
});
