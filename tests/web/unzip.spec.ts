/** ZIPs become the files that they contain; hostile ones become errors. */
import { BlobWriter, TextReader, ZipWriter } from "@zip.js/zip.js/lib/zip-core-native.js";
import { downloadZip } from "client-zip";
import { expect, test, vi } from "vitest";
import type { InputFile } from "../../web/device/files.ts";
import { type UnzipOptions, unzipped } from "../../web/device/unzip.ts";
import { zipOf } from "../support/zip_files.ts";

const input = (path: string, content: Uint8Array | string): InputFile => ({
  path,
  file: new File([content as BlobPart], path.replace(/.*\//, ""), { lastModified: 1234 }),
});

function unzip(files: InputFile[], options: Partial<UnzipOptions> = {}): Promise<InputFile[]> {
  return unzipped(files, { signal: new AbortController().signal, progress: vi.fn(), ...options });
}

async function texts(files: InputFile[]): Promise<Record<string, string>> {
  const pairs = files.map(async ({ path, file }) => [path, await file.text()] as const);
  return Object.fromEntries(await Promise.all(pairs));
}

const good = zipOf([
  { name: "ct/", content: "", method: 0 },
  { name: "ct/1.dcm", content: "first" },
  { name: "ct/2.dcm", content: "second".repeat(1000) },
  { name: "ct\\3.dcm", content: "third", method: 0 },
  { name: "__MACOSX/ct/._1.dcm", content: "no" },
  { name: "ct/.DS_Store", content: "no" },
  { name: "größe.raw", content: "" },
]);

test("a ZIP is replaced by its contents, in a folder with its name", async () => {
  const progress = vi.fn();
  const files = await unzip(
    [input("a.txt", "other"), input("scan.zip", good), input("in/old.zip", "not read")],
    { progress },
  );
  expect(await texts(files)).toEqual({
    "a.txt": "other",
    "in/old.zip": "not read",
    "scan/ct/1.dcm": "first",
    "scan/ct/2.dcm": "second".repeat(1000),
    "scan/ct/3.dcm": "third",
    "scan/größe.raw": "",
  });
  expect(files[2]?.file).toMatchObject({ name: "1.dcm", lastModified: 1234 });
  expect(progress).toHaveBeenLastCalledWith(6010, 6010);
});

test("reads ZIPs of other writers: streamed, ZIP64", async () => {
  const streamed = await downloadZip([{ name: "a.nrrd", input: "NRRD" }]).blob();
  const writer = new ZipWriter(new BlobWriter(), { zip64: true, useWebWorkers: false });
  await writer.add("b.nrrd", new TextReader("NRRD0004".repeat(100)));
  const long = await writer.close();
  const files = [
    input("a.zip", new Uint8Array(await streamed.arrayBuffer())),
    input("b.ZIP", new Uint8Array(await long.arrayBuffer())),
  ];
  expect(await texts(await unzip(files))).toEqual({
    "a/a.nrrd": "NRRD",
    "b/b.nrrd": "NRRD0004".repeat(100),
  });
});

const corrupt = Uint8Array.from(good);
corrupt[42] = 255 ^ (corrupt[42] as number);
test.each<[string, Uint8Array, RegExp]>([
  ["no ZIP", Buffer.alloc(1000, 7), /no ZIP, or incomplete/],
  ["an empty file", Buffer.alloc(0), /no ZIP, or incomplete/],
  ["a ZIP that is cut off", good.subarray(0, 300), /no ZIP, or incomplete/],
  ["a beginning that is missing", good.subarray(200), /damaged/],
  ["damaged data", corrupt, /damaged/],
  ["a wrong checksum", zipOf([{ name: "a", content: "abc", crc: 7 }]), /damaged/],
  ["an encrypted file", zipOf([{ name: "a", content: "abc", flags: 1 }]), /encrypted: unpack it/],
  [
    "another compression",
    zipOf([{ name: "a", content: "abc", method: 14 }]),
    /do not read: unpack/,
  ],
  ["a path outside", zipOf([{ name: "a/../../b", content: "x" }]), /outside of its folder/],
  ["a path outside, of Windows", zipOf([{ name: "..\\b", content: "x" }]), /outside of its folder/],
  ["an absolute path", zipOf([{ name: "/etc/passwd", content: "x" }]), /outside of its folder/],
  [
    "a file longer than it states",
    zipOf([{ name: "a", content: Buffer.alloc(1e7), bytes: 10 }]),
    /longer than it states|damaged/,
  ],
  ["a file shorter than it states", zipOf([{ name: "a", content: "abc", bytes: 10 }]), /damaged/],
])("%s is an error", async (_, zip, message) => {
  await expect(unzip([input("x.zip", zip)])).rejects.toThrow(message);
  await expect(unzip([input("x.zip", zip)])).rejects.toThrow(/^x\.zip: /);
});

test("limits are checked before anything is decompressed", async () => {
  const progress = vi.fn();
  const bomb = zipOf([
    { name: "a", content: "abc" },
    { name: "b", content: "abc", bytes: 0xf0000000 },
    { name: "c", content: "abc", bytes: 0xf0000000 },
  ]);
  await expect(unzip([input("x.zip", bomb)], { progress })).rejects.toThrow(
    "x.zip: expected at most 4295 MB when it is unpacked, found at least 8054 MB: unpack it",
  );
  const many = zipOf(
    Array.from({ length: 20_001 }, (_, i) => ({ name: `${i}`, content: "", method: 0 })),
  );
  await expect(unzip([input("x.zip", many)], { progress })).rejects.toThrow(
    "x.zip: expected at most 20000 files",
  );
  expect(progress).not.toHaveBeenCalled();
});

test("cancelling ends it with the signal's reason", async () => {
  const cancel = new AbortController();
  const files = [input("x.zip", zipOf([{ name: "a", content: Buffer.alloc(1e7) }]))];
  const progress = () => cancel.abort(new Error("cancelled"));
  await expect(unzip(files, { signal: cancel.signal, progress })).rejects.toThrow(/^cancelled$/);
});

test("ZIPs with random damage give files or an error", async () => {
  let random = 5;
  const next = (limit: number): number => {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    return Math.floor((random / 2 ** 32) * limit);
  };
  let errors = 0;
  for (let i = 0; i < 200; ++i) {
    const zip = Uint8Array.from(good);
    for (let flips = 1 + next(4); flips > 0; --flips) zip[next(zip.length)] = next(256);
    try {
      for (const { path } of await unzip([input("x.zip", zip)])) expect(path).toMatch(/^x\//);
    } catch (error) {
      expect((error as Error).message).toMatch(/^x\.zip: .+:.+|damaged/);
      errors++;
    }
  }
  expect(errors).toBeGreaterThan(20);
});
