/**
 * Keeps responses of the page's host about volumes for use without a network: lists, headers,
 * directories, chunks and ranges of stores. Responses that the host marks as private are not kept.
 */
import { covering, type Part, partIn } from "./byte_ranges.ts";
import { chunkAddresses, chunksInFrames, framesOf } from "./chunk_frames.ts";
import { keptHeader } from "./kept_header.ts";

const listsName = "isosplat-lists";
const storePrefix = "isosplat-seen-";
/**
 * The largest number of stores of which parts are kept. If there are more, those kept first are
 * removed.
 */
const mostStores = 16;
/** The largest size of one store's parts, and of one response (bytes). */
const mostBytes = 128 * 1024 * 1024;
const mostAnswerBytes = 16 * 1024 * 1024;
/** In the address of a part of a file. */
const partParameter = "isosplat-part";
/** Bytes of a kept body. */
const bytesHeader = "X-Isosplat-Bytes";

/**
 * Responses that may change are kept as lists, by their address; others by the content id of their
 * store.
 */
export type AnswerKind = "list" | { store: string };

/**
 * Undefined if such responses are not kept. `path`: relative to the page, without a leading slash; of a
 * server (server/HTTP.md), or of a site (docs/deploy.md).
 */
export function answerKind(path: string, query: string): AnswerKind | undefined {
  const isList = path === "v1/volumes" || path === "v1/scenes";
  if ((isList && query === "") || path === "catalog.json") return "list";
  const [isEntry, rest] = /^v1\/(?:volumes|scenes)\/[^/]+(\/.*)?$/.exec(path) ?? [];
  if (isEntry && (rest === undefined || rest === "/bootstrap")) return "list";
  const [, scene] = /^v1\/scenes\/[^/]+\/([0-9a-f]{16})\//.exec(path) ?? [];
  if (scene !== undefined) return { store: scene };
  const [, published] =
    /^stores\/.*-([0-9a-f]{16})(?:-[0-9a-f]+)?\.(?:isobundle|webp)$/.exec(path) ?? [];
  if (published !== undefined) return { store: published };
  const [, id] = /(?:^|[/-])([0-9a-f]{32})(?:\/|-[0-9a-f]+\.|\.)/.exec(path) ?? [];
  return id === undefined ? undefined : { store: id };
}

/** Keeps a response. Does nothing if it is private, large or a failure, or if there is no space. */
export async function keepAnswer(kind: AnswerKind, request: Request, answer: Response) {
  const isPrivate = /private|no-store/.test(answer.headers.get("Cache-Control") ?? "");
  const isLarge = Number(answer.headers.get("Content-Length")) > mostAnswerBytes;
  if (!answer.ok || isPrivate || isLarge || request.headers.has("Authorization")) {
    await answer.body?.cancel();
    return;
  }
  try {
    const body = new Uint8Array(await answer.arrayBuffer());
    const name = kind === "list" ? listsName : await storeName(kind.store);
    const cache = await caches.open(name);
    for (const [url, bytes] of bodies(request, answer, body)) {
      if (kind !== "list") {
        const sum = (await bytesIn(name, cache)) + bytes.length;
        if (sum > mostBytes || (await cache.match(url))) continue;
        keptBytes.set(name, sum);
      }
      const headers = new Headers(answer.headers);
      headers.set(bytesHeader, String(bytes.length));
      headers.set(keptHeader, new Date().toISOString());
      headers.delete("Content-Encoding"); // the body was decoded
      headers.set("Content-Length", String(bytes.length));
      await cache.put(url, new Response(bytes as BufferSource, { headers }));
    }
  } catch {} // the disk is full, or the connection broke: what is kept stays
}

/** The addresses and bodies under which a response is kept. */
function bodies(request: Request, answer: Response, body: Uint8Array): [string, Uint8Array][] {
  const addresses = chunkAddresses(request.url);
  if (addresses) {
    return chunksInFrames(body).map((chunk, i) => [addresses[i] ?? request.url, chunk]);
  }
  if (answer.status !== 206) return [[request.url, body]];
  const part = partIn(answer.headers.get("Content-Range"));
  return part ? [[partAddress(request.url, part), body]] : [];
}

function partAddress(url: string, { first, last }: Part): string {
  return `${url}?${partParameter}=${first}-${last}`;
}

/** A kept response, or one composed of kept ones; undefined if some part of it was not kept. */
export async function keptAnswer(
  kind: AnswerKind,
  request: Request,
): Promise<Response | undefined> {
  const name = kind === "list" ? listsName : storePrefix + kind.store;
  if (!(await caches.has(name))) return undefined;
  const cache = await caches.open(name);
  const addresses = chunkAddresses(request.url);
  if (addresses) return batchOf(addresses, cache);
  const part = partIn(request.headers.get("Range"));
  return part ? partOf(request.url, part, cache) : cache.match(request.url);
}

async function batchOf(addresses: string[], cache: Cache): Promise<Response | undefined> {
  const chunks: Uint8Array[] = [];
  for (const address of addresses) {
    const chunk = await cache.match(address);
    if (!chunk) return undefined;
    chunks.push(new Uint8Array(await chunk.arrayBuffer()));
  }
  const body = framesOf(addresses, chunks);
  return new Response(body as BufferSource, { headers: { "Content-Length": `${body.length}` } });
}

async function partOf(url: string, wanted: Part, cache: Cache): Promise<Response | undefined> {
  const kept = (await cache.keys()).flatMap(({ url: address }) => {
    const [base, range] = address.split(`?${partParameter}=`);
    const part = partIn(`bytes=${range}`);
    return base === url && part ? [part] : [];
  });
  const [any] = kept;
  const headers = new Headers((any && (await cache.match(partAddress(url, any))))?.headers);
  const fileBytes = Number(/\/(\d+)$/.exec(headers.get("Content-Range") ?? "")?.[1]);
  const last = Math.min(wanted.last, fileBytes - 1);
  const parts = covering({ first: wanted.first, last }, kept);
  if (!parts || !(last >= wanted.first)) return undefined;
  const body = new Uint8Array(last - wanted.first + 1);
  for (const part of parts) {
    const answer = await cache.match(partAddress(url, part));
    if (!answer) return undefined; // removed in the meantime
    const bytes = new Uint8Array(await answer.arrayBuffer());
    const from = Math.max(part.first, wanted.first);
    body.set(
      bytes.subarray(from - part.first, Math.min(part.last, last) + 1 - part.first),
      from - wanted.first,
    );
  }
  headers.set("Content-Range", `bytes ${wanted.first}-${last}/${fileBytes}`);
  headers.set("Content-Length", String(body.length));
  return new Response(body, { status: 206, headers });
}

/** The name of a store's cache. Removes other caches if it is new and there are too many. */
async function storeName(id: string): Promise<string> {
  const name = storePrefix + id;
  const names = (await caches.keys()).filter((each) => each.startsWith(storePrefix));
  if (names.includes(name)) return name;
  const surplus = names.slice(0, Math.max(0, names.length + 1 - mostStores));
  for (const each of [...surplus, name]) keptBytes.delete(each);
  await Promise.all(surplus.map((each) => caches.delete(each)));
  return name;
}

/** The size of each store's cache, after it was counted. */
const keptBytes = new Map<string, number>();

async function bytesIn(name: string, cache: Cache): Promise<number> {
  const known = keptBytes.get(name);
  if (known !== undefined) return known;
  const answers = await cache.matchAll();
  const bytes = answers.reduce((sum, { headers }) => sum + Number(headers.get(bytesHeader)), 0);
  keptBytes.set(name, bytes);
  return bytes;
}
