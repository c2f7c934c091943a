/** Each fault of a source is identified correctly, ends when its cause does, and causes no request loop. */
import {
  mkdtempSync,
  readFileSync,
  renameSync,
  rmSync,
  truncateSync,
  utimesSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test, vi } from "vitest";
import { type Core, CoreError } from "../../web/core/index.ts";
import {
  type FaultKind,
  FileSource,
  faults,
  InlineDecoder,
  longestSlowRetry,
  ServerSource,
  type Source,
  StreamSession,
  slowRetry,
} from "../../web/stream/index.ts";
import { maxWholeBytes } from "../../web/stream/whole_file.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { type Nginx, nginx } from "../support/nginx.ts";
import { core as load, openWhole, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

const readme = fileURLToPath(new URL("../../web/stream/README.md", import.meta.url));
const other = fileURLToPath(new URL("../golden/v1.0/u8.isosplat", import.meta.url));
/** Long enough for two slow retries on a slow machine. */
const slow = 3 * longestSlowRetry + 20_000;

let folder: string;
let isosplat: RunningServer;
let host: Nginx;
let core: Core;
let whole: Uint8Array;
const harnesses: Harness[] = [];
const proxies: FaultProxy[] = [];
let number = 0;

beforeAll(async () => {
  core = await load();
  whole = storeBytes();
  folder = mkdtempSync(join(tmpdir(), "isosplat-faults-"));
  isosplat = await serve([folder]);
  host = await nginx({ folders: [folder] });
});
afterAll(async () => {
  for (const harness of harnesses) harness.close();
  for (const proxy of proxies) await proxy.stop();
  await isosplat?.stop();
  await host?.stop();
  rmSync(folder, { recursive: true, force: true });
});
/** Tests run concurrently, because they wait for seconds. Each closes its resources at its end. */
function newHarness(): Harness {
  const harness = new Harness();
  harnesses.push(harness);
  return harness;
}

const path = (name: string): string => join(folder, `${name}.isosplat`);

/** Adds a store with these bytes under a new name, atomically (by renaming). */
function put(bytes: Uint8Array, name = `store-${++number}`): string {
  writeFileSync(`${path(name)}.part`, bytes);
  renameSync(`${path(name)}.part`, path(name));
  return name;
}

async function proxyTo(target: string): Promise<FaultProxy> {
  const proxy = new FaultProxy(target);
  await proxy.start();
  proxies.push(proxy);
  return proxy;
}

/** Waits until the server's state of a volume is the expected one. */
async function served(name: string, isAsWanted: (answer: Response) => boolean): Promise<void> {
  for (let attempt = 0; attempt < 200; ++attempt) {
    const answer = await fetch(`${isosplat.url}v1/volumes/${name}`);
    await answer.arrayBuffer();
    if (isAsWanted(answer)) return;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error(`the server does not serve ${name} as it should`);
}

function damaged(places: readonly { offset: number; bytes: number }[]): Uint8Array {
  const bytes = whole.slice();
  for (const { offset, bytes: count } of places) {
    for (let i = 0; i < Math.min(64, count); ++i) bytes[offset + i] = (bytes[offset + i] ?? 0) ^ 85;
  }
  return bytes;
}

/** Chunks of level 0 that the isovalue needs. */
function chunksOfLevel0(isovalue: number): { offset: number; bytes: number }[] {
  const store = openWhole(core, whole);
  const chunks = store.chunksFor(0, isovalue);
  store.close();
  return chunks;
}

async function openingFault(source: Source): Promise<FaultKind | undefined> {
  const error = await newHarness()
    .open(source, core)
    .then(
      () => undefined,
      (reason: unknown) => reason,
    );
  expect(error).toMatchObject({ name: "StreamError" });
  return (error as { kind: FaultKind }).kind;
}

test("the documents name every fault, and no other", () => {
  const text = readFileSync(readme, "utf8");
  const table = text.slice(text.indexOf("## Faults"));
  const named = [...table.matchAll(/^\| `([a-z0-9-]+)` \|/gm)].map((match) => match[1]);
  expect(named.sort()).toEqual(Object.keys(faults).sort());
});

describe("a store that cannot be opened has the fault of its cause", () => {
  const broken: [string, FaultKind, () => Uint8Array][] = [
    ["an empty file", "cut-short", () => new Uint8Array()],
    ["a text", "not-a-store", () => new TextEncoder().encode("no store at all. ".repeat(5000))],
    ["a short text", "not-a-store", () => new TextEncoder().encode("no")],
    ["half of a header", "cut-short", () => whole.slice(0, 100)],
    ["a file short by 1000 bytes", "cut-short", () => whole.slice(0, -1000)],
    ["half of a file", "cut-short", () => whole.slice(0, whole.length / 2)],
    ["a damaged header", "damaged-header", () => damaged([{ offset: 60, bytes: 64 }])],
    [
      "a newer version",
      "newer-version",
      () => {
        const bytes = whole.slice();
        bytes[8] = 2;
        return bytes;
      },
    ],
  ];

  test.each(broken)("%s: %s", async (_, kind, bytes) => {
    const name = put(bytes());
    await served(name, (answer) => answer.status === 500);
    // For an empty file, the server reports that it is not a store.
    const onServer = bytes().length === 0 ? "not-a-store" : kind;
    const source = new ServerSource({ base: isosplat.url, volume: name });
    expect(await openingFault(source)).toBe(onServer);
    expect(await openingFault(new FileSource(`${host.url}${name}.isosplat`))).toBe(kind);
  });

  test("nothing at the address", async () => {
    const volume = "nothing";
    expect(await openingFault(new ServerSource({ base: isosplat.url, volume }))).toBe("not-found");
    expect(await openingFault(new FileSource(`${host.url}nothing.isosplat`))).toBe("not-found");
  });

  test("a host without Range: small stores are fetched whole", async () => {
    const name = put(whole);
    const plain = await nginx({ folders: [folder], range: false });
    try {
      const warn = vi.spyOn(console, "warn").mockImplementation(() => {});
      const source = new FileSource(`${plain.url}${name}.isosplat`);
      await newHarness().open(source, core);
      expect(warn).toHaveBeenCalledOnce();
      warn.mockRestore();
      // Parts are taken from memory.
      const { requests } = source;
      const parts: Uint8Array[] = [];
      const { signal } = new AbortController();
      await source.range(100, 5000, signal, (part) => parts.push(part));
      expect(Buffer.concat(parts).equals(whole.subarray(100, 5100))).toBe(true);
      expect(source.requests).toBe(requests);
      const large = put(Buffer.concat([whole, Buffer.alloc(maxWholeBytes)]));
      expect(await openingFault(new FileSource(`${plain.url}${large}.isosplat`))).toBe("no-range");
    } finally {
      await plain.stop();
    }
  });

  test("each attempt makes one request, also if it was begun early or is a second one", async () => {
    const { signal } = new AbortController();
    const proxy = await proxyTo(host.url);
    const nothing = new FileSource(`${proxy.url}/nothing.isosplat`);
    nothing.warm();
    await expect(nothing.header(signal)).rejects.toMatchObject({ kind: "not-found" });
    expect(proxy.requests.length).toBe(1);
    // The source bypasses the caches at once, because they may contain the wrong bytes.
    proxy.requests.length = 0;
    const name = put(damaged([{ offset: 60, bytes: 64 }]));
    const again = new FileSource(`${proxy.url}/${name}.isosplat`);
    again.bypassCaches();
    again.warm();
    expect(await openingFault(again)).toBe("damaged-header");
    expect(proxy.requests.length).toBe(1);
  });

  test("a host that never responds is tried again, and reported", async () => {
    const harness = newHarness();
    const proxy = await proxyTo(host.url);
    proxy.fault = () => ({ kind: "silence" });
    const name = put(whole);
    const source = new FileSource(`${proxy.url}/${name}.isosplat`, { longestSilence: 300 });
    const ending = new AbortController();
    const opened = harness.open(source, core, { signal: ending.signal });
    opened.catch(() => {});
    await harness.until(() => harness.errors.length > 0);
    expect(harness.errors[0]).toMatchObject({ kind: "unreachable", retrying: true });
    proxy.fault = () => undefined;
    await opened;
  });
});

const kinds: [string, (name: string) => Source, () => string][] = [
  [
    "isosplat serve",
    (name) => new ServerSource({ base: isosplat.url, volume: name }),
    () => isosplat.url,
  ],
  ["nginx", (name) => new FileSource(`${host.url}${name}.isosplat`), () => host.url],
];

describe.each(kinds)("on %s", { concurrent: true }, (label, source, address) => {
  const isServer = label !== "nginx";
  /** A source of the store behind a proxy that counts requests. */
  async function counted(name: string): Promise<{ proxy: FaultProxy; source: Source }> {
    const proxy = await proxyTo(address());
    return {
      proxy,
      source: isServer
        ? new ServerSource({ base: proxy.url, volume: name })
        : new FileSource(`${proxy.url}/${name}.isosplat`),
    };
  }

  test("damaged chunks are left out, all others arrive, and no further requests follow", async () => {
    const harness = newHarness();
    const chunks = chunksOfLevel0(300.5);
    expect(chunks.length).toBeGreaterThan(3);
    const name = put(damaged(chunks.slice(0, 3)));
    if (isServer) await served(name, ({ ok }) => ok);
    const { proxy, source: through } = await counted(name);
    const session = await harness.open(through, core, { firstIsovalues: [300.5] });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete", 20_000);
    expect(harness.progress?.damagedParts).toBe(3);
    expect(harness.progress?.chunksToGo).toBe(3);
    expect(harness.progress?.fault?.kind).toBe("damaged-part");
    expect(harness.progress?.fault?.message).toMatch(/checksum.*expected 0x.*found 0x/);
    expect(harness.errors.map(({ kind }) => kind)).toEqual(["damaged-part"]);
    // After that, one of the parts and the address are checked every 12 s, and nothing else is requested.
    const before = proxy.requests.length;
    await new Promise((resolve) => setTimeout(resolve, slowRetry + 3000));
    expect(proxy.requests.length - before).toBeLessThanOrEqual(3);
    expect(harness.progress?.state).toBe("incomplete");
  }, 60_000);

  test("a view with damaged chunks settles after its occlusion queries", async () => {
    const harness = newHarness();
    harness.answersOcclusion = true;
    const name = put(damaged(chunksOfLevel0(300.5)));
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [300.5] });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete", 20_000);
    expect(harness.progress?.fault?.kind).toBe("damaged-part");
  }, 60_000);

  test("parts that were damaged in transit are fetched again when the network is repaired", async () => {
    const harness = newHarness();
    const name = put(whole);
    if (isServer) await served(name, ({ ok }) => ok);
    const { proxy, source: through } = await counted(name);
    const session = await harness.open(through, core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    proxy.fault = () => ({ kind: "corrupt", at: 60 });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete");
    proxy.fault = () => undefined;
    await harness.until(() => harness.progress?.complete === true, slow);
    expect(harness.progress?.fault).toBeNull();
  }, 90_000);

  test("a damaged directory page is reported, and everything else settles", async () => {
    const harness = newHarness();
    const store = openWhole(core, whole);
    const page = store.pages().find(({ level }) => level === 0);
    store.close();
    const name = put(damaged([page ?? { offset: 0, bytes: 0 }]));
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [300.5] });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete", 20_000);
    expect(harness.progress?.fault?.kind).toBe("damaged-page");
    expect(harness.progress?.damagedParts).toBe(1);
    expect(harness.visible.length).toBeGreaterThan(0);
  });

  test("if every page is damaged, nothing is drawn, and the fault is reported", async () => {
    const harness = newHarness();
    const store = openWhole(core, whole);
    const pages = store.pages();
    store.close();
    const name = put(damaged(pages));
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [300.5] });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "incomplete", 20_000);
    expect(harness.progress?.fault?.kind).toBe("damaged-page");
    expect(harness.visible).toEqual([]);
  });

  test("a store that is replaced while open is reported once", async () => {
    const harness = newHarness();
    const name = put(whole);
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    put(readFileSync(other), name);
    const old = session.info.contentId;
    if (isServer) await served(name, ({ ok }) => ok);
    // The server may serve the old volume for a moment; until then there is no fault.
    for (let step = 0; harness.replacements.length === 0; ++step) {
      await new Promise((resolve) => setTimeout(resolve, 100 + 10 * step));
      session.update(view(40.5 + 23 * step));
      await harness.until(
        () =>
          harness.replacements.length > 0 ||
          harness.progress?.complete === true ||
          harness.progress?.fault !== null,
      );
      if (harness.progress?.fault) {
        await harness.until(() => harness.replacements.length > 0, slow);
      }
      expect(step).toBeLessThan(40);
    }
    expect(harness.replacements.length).toBe(1);
    expect(harness.replacements[0]?.kind).toBe("replaced");
    expect(harness.replacements[0]?.message).toContain(old);
    // The viewer then does the following.
    session.source.forget();
    const next = new Harness();
    const again = await next.open(session.source, core);
    expect(again.info.contentId).not.toBe(old);
    next.close();
  }, 90_000);

  test("a store that is missing for a while is used again without an action", async () => {
    const harness = newHarness();
    const name = put(whole);
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    renameSync(path(name), `${path(name)}.away`);
    if (isServer) await served(name, ({ status }) => status === 404);
    session.update(view(300.5));
    await harness.until(() => harness.progress?.fault !== null);
    expect(harness.progress?.fault?.kind).toBe("not-found");
    expect(harness.progress?.state).toBe("incomplete");
    expect(harness.visible.length).toBeGreaterThan(0);
    renameSync(`${path(name)}.away`, path(name));
    await harness.until(() => harness.progress?.complete === true, slow);
    expect(harness.progress?.fault).toBeNull();
    expect(harness.errors.map(({ kind }) => kind)).toEqual(["not-found"]);
  }, 90_000);

  test("a store that is truncated while open has the fault cut-short", async () => {
    const harness = newHarness();
    const name = put(whole);
    if (isServer) await served(name, ({ ok }) => ok);
    const session = await harness.open(source(name), core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    truncateSync(path(name), 20_000);
    if (isServer) await served(name, ({ status }) => status === 500);
    session.update(view(300.5));
    await harness.until(() => harness.progress?.fault?.kind === "cut-short", slow);
    expect(harness.progress?.state).toBe("incomplete");
    expect(harness.progress?.fault?.message).toMatch(/20000|20,000/);
    expect(harness.visible.length).toBeGreaterThan(0);
  }, 90_000);

  test("a failing server is tried by one request at a time", async () => {
    const harness = newHarness();
    const name = put(whole);
    if (isServer) await served(name, ({ ok }) => ok);
    const { proxy, source: through } = await counted(name);
    const session = await harness.open(through, core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    const before = proxy.requests.length;
    proxy.fault = () => ({ kind: "status", status: 503 });
    session.update(view(300.5));
    await harness.until(() => harness.progress?.state === "offline");
    expect(harness.progress?.fault?.kind).toBe("server-fault");
    await new Promise((resolve) => setTimeout(resolve, 5000));
    // The requests in flight together, then retries after 1/4, 1/2, 1, 2 and 4 s.
    expect(proxy.requests.length - before).toBeLessThanOrEqual(6 + 6);
    proxy.fault = () => undefined;
    await harness.until(() => harness.progress?.complete === true, 90_000);
    expect(harness.progress?.fault).toBeNull();
  }, 120_000);
});

test("the same file with another ETag is not another file", async () => {
  const harness = newHarness();
  const name = put(whole);
  const session = await harness.open(new FileSource(`${host.url}${name}.isosplat`), core, {
    firstIsovalues: [100.5],
  });
  session.update(view(100.5));
  await harness.complete();
  utimesSync(path(name), 1e9, 1e9);
  session.update(view(300.5));
  await harness.until(() => harness.progress?.complete === true, slow);
  expect(harness.replacements).toEqual([]);
  expect(harness.errors).toEqual([]);
}, 60_000);

test("another file of the same size is detected on a host that sends neither ETag nor length", async () => {
  const harness = newHarness();
  // The proxy removes these header fields from responses, as CORS may hide them.
  const name = put(whole);
  const source = new FileSource(`${host.url}${name}.isosplat`);
  const fetchAll = globalThis.fetch;
  globalThis.fetch = async (...asked) => {
    const answer = await fetchAll(...asked);
    const headers = new Headers(answer.headers);
    for (const field of ["ETag", "Content-Range", "Content-Length"]) headers.delete(field);
    return new Response(answer.body, { status: answer.status, headers });
  };
  try {
    const session = await harness.open(source, core, { firstIsovalues: [100.5] });
    session.update(view(100.5));
    await harness.complete();
    const bytes = new Uint8Array(whole.length);
    bytes.set(readFileSync(other));
    put(bytes, name);
    session.update(view(300.5));
    await harness.until(() => harness.replacements.length > 0, slow);
  } finally {
    globalThis.fetch = fetchAll;
  }
}, 60_000);

test("if a group of requests fails, none of its chunks is uploaded later", async () => {
  const store = openWhole(core, whole);
  const chunks = [...store.chunksFor(0, 100.5), ...store.chunksFor(1, 100.5)];
  store.close();
  const apart = [chunks[0], chunks.at(-1)].flatMap((chunk) => (chunk ? [chunk] : []));
  const name = put(whole);
  const proxy = await proxyTo(host.url);
  let asked = 0;
  proxy.fault = () => (++asked === 1 ? { kind: "reset" } : { kind: "drip", bytes: 100 });
  const arrived: number[] = [];
  const source = new FileSource(`${proxy.url}/${name}.isosplat`);
  const chunksOf = source.chunks(apart, new AbortController().signal, ({ handle }) =>
    arrived.push(handle),
  );
  await expect(chunksOf).rejects.toMatchObject({ kind: "unreachable" });
  expect(asked).toBe(2);
  const before = arrived.length;
  await new Promise((resolve) => setTimeout(resolve, 200));
  expect(arrived.length).toBe(before);
});

describe("a chunk that does not fit into GPU memory", () => {
  test("is not resident, and the view uses coarser levels", async () => {
    const harness = newHarness();
    const name = put(whole);
    const source = new FileSource(`${host.url}${name}.isosplat`);
    const session = await harness.open(source, core, { firstIsovalues: [300.5] });
    harness.takes = () => harness.samples < 60_000;
    session.update(view(300.5));
    const isDone = (): boolean =>
      ["complete", "limited", "incomplete"].includes(harness.progress?.state ?? "");
    await harness.until(() => isDone() && harness.progress?.fault !== null, 20_000);
    expect(harness.progress?.fault?.kind).toBe("out-of-memory");
    expect(harness.progress?.samplesResident).toBe(harness.samples);
    expect(harness.visible.length).toBeGreaterThan(0);
    expect(harness.errors.map(({ kind }) => kind)).toEqual(["out-of-memory"]);
    harness.takes = () => true;
    session.retry();
    await harness.until(() => harness.progress?.complete === true && !harness.progress.fault);
    expect(harness.progress?.finestLevel).toBe(0);
  });

  test("is removed if the GPU reports it later", async () => {
    const harness = newHarness();
    const name = put(whole);
    const source = new FileSource(`${host.url}${name}.isosplat`);
    const session = await harness.open(source, core, { firstIsovalues: [300.5] });
    session.update(view(300.5));
    await harness.complete();
    const lost = harness.visible.slice(0, 2);
    session.rejectUploads(lost, "no room");
    for (const id of lost) expect(harness.resident.has(id)).toBe(false);
    await harness.until(() => harness.progress?.fault?.kind === "out-of-memory");
    const requests = session.source.requests;
    session.retry();
    await harness.until(() => harness.progress?.complete === true && !harness.progress.fault);
    // Their samples were not kept, so the chunks were requested again.
    expect(session.source.requests).toBeGreaterThan(requests);
    for (const id of lost) {
      expect(harness.resident.has(id)).toBe(true);
      expect(harness.uploaded.get(id)).toBe(2);
    }
  });
});

test("chunks wait for lost workers, and do not count as damaged", async () => {
  const harness = newHarness();
  const name = put(whole);
  const inline = new InlineDecoder(core);
  let isLost = true;
  const decoder = {
    decode: (...job: Parameters<InlineDecoder["decode"]>) =>
      isLost
        ? Promise.reject(new CoreError("worker_lost", "the worker was ended"))
        : inline.decode(...job),
    decodeField: (...job: Parameters<InlineDecoder["decodeField"]>) => inline.decodeField(...job),
    close: () => {},
  };
  const states: string[] = [];
  let fault: string | undefined;
  let isComplete = false;
  const session = await StreamSession.open(new FileSource(`${host.url}${name}.isosplat`), core, {
    decoder,
    firstIsovalues: [300.5],
    events: {
      samples: () => true,
      drop: () => {},
      visible: () => {},
      replaced: () => {},
      error: () => {},
      progress: (progress) => {
        states.push(progress.state);
        fault = progress.fault?.kind;
        isComplete = progress.complete;
      },
    },
  });
  try {
    session.update(view(300.5));
    await harness.until(() => fault === "worker-lost");
    expect(states.at(-1)).toBe("incomplete");
    isLost = false;
    session.retry();
    await harness.until(() => isComplete);
    expect(fault).toBeUndefined();
  } finally {
    session.close();
  }
});
