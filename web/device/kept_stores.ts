import { deviceErrorTexts } from "../texts/device_errors.ts";
import { localized } from "../texts/numbers.ts";

/**
 * Stores that are kept on this device, in the origin private file system: {contentId}.isosplat, and
 * {contentId}.json with the description for the list of stores. While they are written or removed,
 * {contentId}.incomplete marks them. Only what is marked, and what the visitor names, is ever removed: what cannot be
 * read may be readable later. If the browser has no such file system, or denies access to it, the stores are kept in
 * memory until the tab is closed.
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

/** A kept store that cannot be read, at least not now. */
export interface UnreadableStore {
  contentId: string;
  reason: string;
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
const markFile = (id: string) => `${id}.incomplete`;
const isContentId = (text: string) => /^[0-9a-f]{32}$/.test(text);

/** The stores on this device, the newest first, and those that cannot be read. */
export async function listKept(): Promise<{
  stores: KeptStore[];
  unreadable: UnreadableStore[];
}> {
  const stores = [...inMemory.values()].map(({ store }) => store);
  const unreadable: UnreadableStore[] = [];
  const directory = await folder();
  if (directory) {
    const names = await namesIn(directory);
    for (const id of idsOf(names, ".isosplat")) {
      try {
        stores.push(await readEntry(directory, id));
        if (inMemory.delete(id)) stores.splice(stores.findIndex(isOf(id)), 1); // another tab kept it
      } catch (error) {
        if (names.has(markFile(id))) continue; // it is being written or removed
        const reason = String(error instanceof Error ? error.message : error).replace(/\.$/, "");
        if (!inMemory.has(id)) unreadable.push({ contentId: id, reason });
      }
    }
  }
  return { stores: stores.sort((a, b) => b.keptAt - a.keptAt), unreadable };
}

const isOf = (id: string) => (store: KeptStore) => store.contentId === id;

/** The stores on this device, the newest first. */
export async function keptStores(): Promise<KeptStore[]> {
  return (await listKept()).stores;
}

/**
 * Removes what an interrupted write or removal has left, unless another tab is at it. Resolves to the number of
 * stores that were removed.
 */
export async function removeRemains(): Promise<number> {
  const directory = await folder();
  if (!directory) return 0;
  let count = 0;
  for (const id of idsOf(await namesIn(directory), ".incomplete")) {
    await navigator.locks.request(lockOf(id), { ifAvailable: true }, async (lock) => {
      if (!lock || !(await exists(directory, markFile(id)))) return;
      const isComplete = await readEntry(directory, id).then(
        () => true,
        () => false,
      );
      if (isComplete) return directory.removeEntry(markFile(id));
      await removeFiles(directory, id);
      count++;
    });
  }
  return count;
}

/** Whether the browser removes the stores only when the visitor asks for it. */
export async function isPersistent(): Promise<boolean> {
  return (await navigator.storage?.persisted?.()) ?? false;
}

async function namesIn(directory: FileSystemDirectoryHandle): Promise<Set<string>> {
  const names = new Set<string>();
  for await (const name of directory.keys()) names.add(name);
  return names;
}

function idsOf(names: Iterable<string>, ending: string): string[] {
  return [...names]
    .filter((name) => name.endsWith(ending))
    .map((name) => name.slice(0, -ending.length))
    .filter(isContentId);
}

async function exists(directory: FileSystemDirectoryHandle, name: string): Promise<boolean> {
  try {
    await directory.getFileHandle(name);
    return true;
  } catch (error) {
    return !(error instanceof DOMException && error.name === "NotFoundError");
  }
}

/** The description of a kept store. Rejects if its files cannot be read, or do not fit together. */
async function readEntry(directory: FileSystemDirectoryHandle, id: string): Promise<KeptStore> {
  const text = await (await directory.getFileHandle(textFile(id))).getFile();
  const store = JSON.parse(await text.text()) as KeptStore;
  const { size } = await (await directory.getFileHandle(storeFile(id))).getFile();
  if (store.contentId !== id || store.bytes !== size) {
    throw new Error(deviceErrorTexts.keptSize(store.bytes, size));
  }
  return store;
}

async function writeEntry(directory: FileSystemDirectoryHandle, store: KeptStore): Promise<void> {
  const text = await directory.getFileHandle(textFile(store.contentId), { create: true });
  const writing = await text.createWritable();
  await writing.write(JSON.stringify(store));
  await writing.close();
}

/** The mark stays if the files cannot be removed, so that they are removed later. */
async function removeFiles(directory: FileSystemDirectoryHandle, id: string): Promise<void> {
  await directory.getFileHandle(markFile(id), { create: true }).catch(() => {}); // a full disk
  for (const name of [textFile(id), storeFile(id), markFile(id)]) {
    if (await exists(directory, name)) await directory.removeEntry(name);
  }
}

const lockOf = (id: string) => `isosplat-store-${id}`;

/** The store's bytes; undefined if it is not on this device, or cannot be read. */
export async function keptBlob(id: string): Promise<{ store: KeptStore; blob: Blob } | undefined> {
  const held = inMemory.get(id);
  if (held) return held;
  if (!isContentId(id)) return undefined;
  const directory = await folder();
  if (!directory) return undefined;
  try {
    const store = await readEntry(directory, id);
    return { store, blob: await (await directory.getFileHandle(storeFile(id))).getFile() };
  } catch {
    return undefined;
  }
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
    const existing = await readEntry(directory, id).catch(() => undefined);
    // A mark is left by a tab that was closed while it wrote the store.
    const isMarked = await exists(directory, markFile(id));
    const isNew = isMarked || !(await exists(directory, storeFile(id)));
    const { isTemporary: _, ...entry } = store;
    if (existing) {
      // Another tab has kept the same bytes, or the volume was kept earlier from another address.
      await writeEntry(directory, { ...existing, ...entry }).catch(() => {});
      if (isMarked) await directory.removeEntry(markFile(id)).catch(() => {});
      return;
    }
    try {
      if (isNew) await directory.getFileHandle(markFile(id), { create: true });
      // The written bytes are visible to readers only after the stream is closed.
      const handle = await directory.getFileHandle(storeFile(id), { create: true });
      await blob.stream().pipeTo(await handle.createWritable(), signal ? { signal } : {});
      await writeEntry(directory, entry);
      if (isNew) await directory.removeEntry(markFile(id));
    } catch (error) {
      // What was there before may be readable later.
      if (isNew) await removeFiles(directory, id).catch(() => {});
      signal?.throwIfAborted();
      const isFull = error instanceof DOMException && error.name === "QuotaExceededError";
      if (isFull) throw full(blob.size, undefined);
      const reason = error instanceof Error ? error.message : String(error);
      throw new NotKeptError(deviceErrorTexts.notKept(reason));
    }
  });
  inMemory.delete(id);
  changed();
  // Firefox asks the visitor.
  void navigator.storage.persist?.().then((isGranted) => isGranted && changed());
}

function full(bytes: number, left: number | undefined): NotKeptError {
  const mb = (n: number) => localized(`${(n / 1e6).toFixed(n < 1e7 ? 1 : 0)} MB`);
  const found = left === undefined ? deviceErrorTexts.less : mb(left);
  return new NotKeptError(deviceErrorTexts.noRoom(mb(bytes), found));
}

/**
 * Removes a store from this device. A tab that has it open can no longer read it. Rejects if the browser does not
 * remove its files.
 */
export async function remove(id: string): Promise<void> {
  inMemory.delete(id);
  const directory = await folder();
  if (directory && isContentId(id)) {
    await navigator.locks.request(lockOf(id), () => removeFiles(directory, id));
  }
  changed();
}
