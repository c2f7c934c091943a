import {
  ERR_BAD_FORMAT,
  ERR_CENTRAL_DIRECTORY_NOT_FOUND,
  ERR_ENCRYPTED,
  ERR_EOCDR_NOT_FOUND,
  ERR_SPLIT_ZIP_FILE,
  ERR_UNSAFE_FILENAME,
  ERR_UNSUPPORTED_COMPRESSION,
  ERR_UNSUPPORTED_ENCRYPTION,
  type FileEntry,
  type Reader,
  ZipReader,
} from "@zip.js/zip.js/lib/zip-core-reader.js";
import { BlobParts } from "../core/blob_parts.ts";
import { deviceErrorTexts } from "../texts/device_errors.ts";
import { maxFetchedBytes } from "./fetch_file.ts";
import { type InputFile, isZip, maxFiles } from "./files.ts";

/**
 * Limit of an archive's directory (bytes), which is read as a whole. `maxFiles` files need less.
 */
const maxDirectoryBytes = 64 << 20;
/** Files that programs add to archives, besides those of the user. */
const ignored = /(^|\/)(__MACOSX\/|\.[^/]*$)/;

export interface UnzipOptions {
  signal: AbortSignal;
  /** Called with the number of bytes decompressed so far, and of all files. */
  progress(unpacked: number, bytes: number): void;
  /** Limit of the decompressed bytes of all files together. Default: maxFetchedBytes. */
  maxBytes?: number;
}

/**
 * Replaces each ZIP among files by its contents, in a folder with its name. A ZIP in a ZIP or in a
 * folder stays as it is. The files are decompressed into Blobs one after the other. At most 16 MiB
 * of them are in memory outside of Blobs. Rejects with the signal's reason, or with an Error that
 * states the remedy: for example if a ZIP is encrypted, damaged or split, or has paths outside of
 * its folder. ZIPs with more than `maxFiles` files or `maxBytes` are refused before anything is
 * decompressed.
 */
export async function unzipped(
  files: readonly InputFile[],
  options: UnzipOptions,
): Promise<InputFile[]> {
  const { signal, progress, maxBytes = maxFetchedBytes } = options;
  const found = files.filter((file) => !isZip(file));
  const entries: [InputFile, FileEntry][] = [];
  let bytes = 0;
  for (const zip of files.filter(isZip)) {
    await explained(zip, signal, async () => {
      for await (const entry of entriesOf(zip.file)) {
        signal.throwIfAborted();
        if (entry.directory || ignored.test(entry.filename)) continue;
        if (entry.encrypted) throw new Error(ERR_ENCRYPTED);
        entries.push([zip, entry]);
        bytes += entry.uncompressedSize;
        if (found.length + entries.length > maxFiles) {
          throw new ZipError(deviceErrorTexts.zipFiles(maxFiles));
        }
        if (bytes > maxBytes) {
          const mb = (n: number) => `${Math.ceil(n / 1e6)} MB`;
          throw new ZipError(deviceErrorTexts.zipTooLarge(mb(maxBytes), mb(bytes)));
        }
      }
    });
  }
  let unpacked = 0;
  for (const [zip, entry] of entries) {
    const blob = await explained(zip, signal, () =>
      contentOf(entry, signal, (count) => {
        unpacked += count;
        progress(unpacked, bytes);
      }),
    );
    const path = `${zip.path.replace(/\.[^.]*$/, "")}/${entry.filename}`;
    const name = path.slice(path.lastIndexOf("/") + 1);
    const { lastModified } = zip.file;
    found.push({ path, file: new File([blob], name, { lastModified }) });
  }
  return found;
}

/** A fault with its remedy. The archive's name is put before the message. */
class ZipError extends Error {}

function entriesOf(file: File) {
  const reader: Pick<Reader<File>, "size" | "init" | "createReadable" | "readUint8Array"> = {
    size: file.size,
    init: () => Promise.resolve(),
    createReadable: ({ offset = 0, size = file.size } = {}) =>
      file.slice(offset, offset + size).stream(),
    async readUint8Array(offset, length) {
      if (length > maxDirectoryBytes) {
        throw new ZipError(deviceErrorTexts.zipDirectory);
      }
      return new Uint8Array(await file.slice(offset, offset + length).arrayBuffer());
    },
  };
  return new ZipReader(reader as Reader<File>, {
    useWebWorkers: false,
    checkSignature: true,
    filenameValidation: "balanced",
    // Some programs for Windows separate folders by backslashes.
    normalizeFilename: (name) => name.replaceAll("\\", "/"),
  }).getEntriesGenerator();
}

/** Decompresses a file. `got` is called with the number of bytes of each part. */
async function contentOf(
  entry: FileEntry,
  signal: AbortSignal,
  got: (count: number) => void,
): Promise<Blob> {
  const parts = new BlobParts();
  let left = entry.uncompressedSize;
  const sink = new WritableStream<Uint8Array>({
    write(chunk) {
      signal.throwIfAborted();
      left -= chunk.byteLength;
      if (left < 0) throw new ZipError(deviceErrorTexts.zipLonger(entry.filename));
      parts.add(chunk);
      got(chunk.byteLength);
    },
  });
  await entry.getData(sink, { signal });
  if (left > 0) throw new ZipError(deviceErrorTexts.zipShorter(entry.filename));
  return parts.blob();
}

/** The messages for errors of the library. */
function textOf(message: string): string | undefined {
  switch (message) {
    case ERR_BAD_FORMAT:
    case ERR_EOCDR_NOT_FOUND:
      return deviceErrorTexts.zipIncomplete;
    case ERR_CENTRAL_DIRECTORY_NOT_FOUND:
      return deviceErrorTexts.zipDamaged;
    case ERR_ENCRYPTED:
    case ERR_UNSUPPORTED_ENCRYPTION:
      return deviceErrorTexts.zipEncrypted;
    case ERR_SPLIT_ZIP_FILE:
      return deviceErrorTexts.zipSplit;
    case ERR_UNSAFE_FILENAME:
      return deviceErrorTexts.zipUnsafe;
    case ERR_UNSUPPORTED_COMPRESSION:
      return deviceErrorTexts.zipCompression;
    default:
      return undefined;
  }
}

/** Runs `work`. Adds the name of the ZIP and the remedy to the message of an error. */
async function explained<T>(
  { path }: InputFile,
  signal: AbortSignal,
  work: () => Promise<T>,
): Promise<T> {
  try {
    return await work();
  } catch (error) {
    signal.throwIfAborted();
    const fault = error instanceof Error ? error : new Error(String(error));
    const text =
      fault instanceof ZipError
        ? fault.message
        : (textOf(fault.message) ?? `${deviceErrorTexts.zipDamaged} (${fault.message})`);
    throw new Error(`${path}: ${text}`, { cause: error });
  }
}
