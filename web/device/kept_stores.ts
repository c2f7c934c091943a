import { deviceErrorTexts } from "../texts/device_errors.ts";
import { localized } from "../texts/numbers.ts";

/**
 * Stores that are kept on this device, in the origin private file system: {contentId}.isosplat, and
 * {contentId}.json with the description for the list of stores. The JSON is written last, so a store without it is
 * incomplete, and is not listed. If the browser has no such file system, or denies access to it, the stores are kept
 * in memory until the tab is closed.
 */

/** The description of a kept store in a list. */
export interface KeptStore {
  /** 32 hexadecimal digits. */
  contentId: string;
  name: string;
  bytes: number;
  voxels?: readonly number[];
  type?: string;
  /** The files it was built from: see filesKey. */
  filesKey?: string;
  /** The address from which its volume was fetched, and the version of the fetched file. */
  address?: string;
  version?: string;
  /** Milliseconds since 1970. */
  keptAt: number;
  /** Whether the store is in memory only. */
  isTemporary?: boolean;
}

/**
 * The device has no room for the store, or the browser does not allow it. The store stays in
 * memory.
 */
export class NotKeptError extends Error {
  override readonly name = "NotKeptError";
}

const folderName = "isosplat-stores";
const inMemory = new Map<string, { store: KeptStore; blob: Blob }>();
const changes = new BroadcastChannel("isosplat-stores");
const listeners = new Set<() => void>();
changes.onmessage = () => notify();

/** Calls the function when the list has changed, in this tab or another. */
export function onKeptChange(changed: () => void): () => void {
  listeners.add(changed);
  return () => void listeners.delete(changed);
}

function notify(): void {
  for (const listener of listeners) listener();
}

function changed(): void {
  changes.postMessage(null);
  notify();
}

async function folder(): Promise<FileSystemDirectoryHandle | undefined> {
  try {
    const root = await navigator.storage.getDirectory();
    return await root.getDirectoryHandle(folderName, { create: true });
  } catch {
    return undefined; // not a secure origin, private browsing, or an old browser
  }
}

const storeFile = (id: string) => `${id}.isosplat`;
const textFile = (id: string) => `${id}.json`;
const isContentId = (text: string) => /^[0-9a-f]{32}$/.test(text);

/** Complete stores, the newest first. Removes the remains of interrupted writes. */
export async function keptStores(): Promise<KeptStore[]> {
  const stores = [...inMemory.values()].map(({ store }) => store);
  const directory = await folder();
  if (directory) {
    for await (const name of directory.keys()) {
      const id = name.replace(/\.\w+$/, "");
      if (!name.endsWith(".isosplat") || !isContentId(id)) continue;
      const store = await readEntry(directory, id);
      if (store) stores.push(store);
      else await removeIncomplete(directory, id);
    }
  }
  return stores.sort((a, b) => b.keptAt - a.keptAt);
}

async function readEntry(
  directory: FileSystemDirectoryHandle,
  id: string,
): Promise<KeptStore | undefined> {
  try {
    const text = await (await directory.getFileHandle(textFile(id))).getFile();
    const store = JSON.parse(await text.text()) as KeptStore;
    const file = await (await directory.getFileHandle(storeFile(id))).getFile();
    return store.contentId === id && store.bytes === file.size ? store : undefined;
  } catch {
    return undefined;
  }
}

async function writeEntry(directory: FileSystemDirectoryHandle, store: KeptStore): Promise<void> {
  const text = await directory.getFileHandle(textFile(store.contentId), { create: true });
  const writing = await text.createWritable();
  await writing.write(JSON.stringify(store));
  await writing.close();
}

/** Removes an incomplete store, unless another tab is writing it. */
async function removeIncomplete(directory: FileSystemDirectoryHandle, id: string): Promise<void> {
  await navigator.locks.request(lockOf(id), { ifAvailable: true }, async (lock) => {
    if (lock && !(await readEntry(directory, id))) await removeFiles(directory, id);
  });
}

async function removeFiles(directory: FileSystemDirectoryHandle, id: string): Promise<void> {
  // The JSON is removed first, so that a store is not listed if its removal is interrupted.
  for (const name of [textFile(id), storeFile(id)]) {
    await directory.removeEntry(name).catch(() => {});
  }
}

const lockOf = (id: string) => `isosplat-store-${id}`;

/** The store's bytes; undefined if it is not on this device. */
export async function keptBlob(id: string): Promise<{ store: KeptStore; blob: Blob } | undefined> {
  const held = inMemory.get(id);
  if (held) return held;
  if (!isContentId(id)) return undefined;
  const directory = await folder();
  const store = directory && (await readEntry(directory, id));
  if (!store) return undefined;
  return { store, blob: await (await directory.getFileHandle(storeFile(id))).getFile() };
}

/** Holds a store in memory, so that the page can open it. */
export function hold(store: KeptStore, blob: Blob): void {
  inMemory.set(store.contentId, { store: { ...store, isTemporary: true }, blob });
  changed();
}

/**
 * Keeps a store on this device. The store is not listed before it is complete. Rejects with a
 * NotKeptError, which states the reason, or with the signal's reason.
 */
export async function keep(store: KeptStore, blob: Blob, signal?: AbortSignal): Promise<void> {
  const directory = await folder();
  if (!directory || !("createWritable" in FileSystemFileHandle.prototype)) {
    throw new NotKeptError(deviceErrorTexts.notAllowed);
  }
  const { quota = Number.POSITIVE_INFINITY, usage = 0 } = await navigator.storage.estimate();
  if (blob.size > quota - usage) throw full(blob.size, Math.max(0, quota - usage));
  const id = store.contentId;
  await navigator.locks.request(lockOf(id), async () => {
    const existing = await readEntry(directory, id);
    const { isTemporary: _, ...entry } = store;
    if (existing) {
      // Another tab has kept the same bytes, or the volume was kept earlier from another address.
      await writeEntry(directory, { ...existing, ...entry }).catch(() => {});
      return;
    }
    try {
      // The written bytes are visible to readers only after the stream is closed.
      const handle = await directory.getFileHandle(storeFile(id), { create: true });
      await blob.stream().pipeTo(await handle.createWritable(), signal ? { signal } : {});
      await writeEntry(directory, entry);
    } catch (error) {
      await removeFiles(directory, id);
      signal?.throwIfAborted();
      const isFull = error instanceof DOMException && error.name === "QuotaExceededError";
      if (isFull) throw full(blob.size, undefined);
      const reason = error instanceof Error ? error.message : String(error);
      throw new NotKeptError(deviceErrorTexts.notKept(reason));
    }
  });
  inMemory.delete(id);
  changed();
}

function full(bytes: number, left: number | undefined): NotKeptError {
  const mb = (n: number) => localized(`${(n / 1e6).toFixed(n < 1e7 ? 1 : 0)} MB`);
  const found = left === undefined ? deviceErrorTexts.less : mb(left);
  return new NotKeptError(deviceErrorTexts.noRoom(mb(bytes), found));
}

/** Removes a store from this device. A tab that has it open can no longer read it. */
export async function remove(id: string): Promise<void> {
  inMemory.delete(id);
  const directory = await folder();
  if (directory && isContentId(id)) {
    await navigator.locks.request(lockOf(id), () => removeFiles(directory, id));
  }
  changed();
}
