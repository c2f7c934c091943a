import { deviceErrorTexts } from "../texts/device_errors.ts";

/** A file that was dropped, pasted, chosen or fetched. */
export interface InputFile {
  /** Relative, parts separated by "/": "scan/IM0001.dcm". */
  path: string;
  file: File;
  /** The version of a fetched file. Different content has a different version. */
  version?: string;
}

/** Limit of files in one drop. No volume needs more. */
export const maxFiles = 20_000;

/**
 * Whether a file is a ZIP according to its name. Files in folders do not count, because folders of
 * scans may contain archives. An .npz is a ZIP of NumPy arrays.
 */
export function isZip({ path }: InputFile): boolean {
  return /^[^/]+\.(zip|npz)$/i.test(path);
}

/** The files of a file chooser or of the clipboard. */
export function listedFiles(list: Iterable<File>): InputFile[] {
  return [...list].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}

/**
 * The files of a drop or of the clipboard, including those in folders. Call it in the task of the
 * event, because the browser empties the transfer afterwards. Rejects with an Error for more than
 * `maxFiles`.
 */
export function transferredFiles(transfer: DataTransfer): Promise<InputFile[]> {
  const plain: InputFile[] = [];
  const entries: FileSystemEntry[] = [];
  for (const item of transfer.items) {
    if (item.kind !== "file") continue;
    const entry = item.webkitGetAsEntry?.();
    const file = item.getAsFile();
    if (entry?.isDirectory) entries.push(entry);
    else if (file) plain.push({ path: file.name, file });
  }
  return withFolders(plain, entries);
}

async function withFolders(found: InputFile[], entries: FileSystemEntry[]): Promise<InputFile[]> {
  // This loop appends the entries of folders to the list.
  for (const entry of entries) {
    if (entry.isDirectory) {
      const reader = (entry as FileSystemDirectoryEntry).createReader();
      // Each call returns some of the entries; none after the last.
      for (;;) {
        const part = await new Promise<FileSystemEntry[]>((resolve, reject) =>
          reader.readEntries(resolve, reject),
        );
        if (part.length === 0) break;
        entries.push(...part);
      }
    } else {
      const file = await new Promise<File>((resolve, reject) =>
        (entry as FileSystemFileEntry).file(resolve, reject),
      );
      found.push({ path: entry.fullPath.replace(/^\/+/, ""), file });
    }
    if (found.length > maxFiles || entries.length > 2 * maxFiles) {
      throw new Error(deviceErrorTexts.tooManyFiles(maxFiles));
    }
  }
  return found;
}

/**
 * A key of these files: equal paths, sizes, times and versions give equal keys. If a kept store has the
 * key of a volume, the volume need not be built again.
 */
export function filesKey(files: readonly InputFile[], settings: object): Promise<string> {
  const facts = files
    .map(({ path, file, version }) => [path, file.size, file.lastModified, version ?? ""])
    .sort(([a], [b]) => (String(a) < String(b) ? -1 : 1));
  return keyOf([facts, settings]);
}

/** A key of these facts: equal facts have equal keys. */
export async function keyOf(facts: readonly unknown[]): Promise<string> {
  const text = new TextEncoder().encode(JSON.stringify(facts));
  // Only secure origins have `crypto.subtle`. Without it, every volume is built again.
  if (!globalThis.crypto?.subtle) return `unknown ${Math.random()}`;
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", text));
  return Array.from(digest.subarray(0, 16), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
