// Files of several streams, such as concatenated compressed files. All streams are decompressed.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gunzipSync, gzipSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import type { Packing } from "../../web/import/types.ts";
import { unpackStream } from "../../web/import/unpack_streams.ts";

const packed = (suffix: string): Buffer =>
  readFileSync(fileURLToPath(new URL(`../browser/packed/ball.nrrd.${suffix}`, import.meta.url)));

const content = gunzipSync(packed("gz"));
const twice = Buffer.concat([content, content]);

async function unpacked(packing: Packing, ...parts: Uint8Array[]): Promise<Buffer> {
  const found: Uint8Array[] = [];
  await unpackStream(new Blob(parts as BlobPart[]), packing, (part) => found.push(part));
  return Buffer.concat(found);
}

/** A skippable frame of Zstandard with three bytes of other data. */
const skippable = Uint8Array.of(0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 1, 2, 3);

describe("several streams in a file", () => {
  for (const [packing, suffix] of [
    ["gzip", "gz"],
    ["bzip2", "bz2"],
    ["xz", "xz"],
    ["zstd", "zst"],
  ] as const) {
    const one = packed(suffix);
    it(`of ${packing}`, async () => {
      expect((await unpacked(packing, one)).equals(content)).toBe(true);
      expect((await unpacked(packing, one, one)).equals(twice)).toBe(true);
    });

    it(`of ${packing}, the second one cut off`, async () => {
      await expect(unpacked(packing, one, one.subarray(0, one.length - 20))).rejects.toThrow();
    });
  }

  it("of block gzip: thousands of members, in pieces with arbitrary ends", async () => {
    const members: Buffer[] = [];
    for (let at = 0; at < content.length; at += 997) {
      members.push(gzipSync(content.subarray(at, at + 997)));
    }
    members.push(gzipSync(Buffer.alloc(0)), Buffer.alloc(100));
    expect((await unpacked("gzip", ...members, ...members)).equals(twice)).toBe(true);
  });

  it("of gzip, with a wrong checksum or invalid data", async () => {
    const damaged = Buffer.from(packed("gz"));
    damaged[damaged.length - 7] = (damaged[damaged.length - 7] ?? 0) ^ 1;
    await expect(unpacked("gzip", damaged)).rejects.toThrow("incorrect data check");
    await expect(unpacked("gzip", packed("gz"), Uint8Array.of(1, 2, 3))).rejects.toThrow();
  });

  it("of xz with padding between and after them", async () => {
    const zeros = new Uint8Array(8);
    expect((await unpacked("xz", packed("xz"), zeros, packed("xz"), zeros)).equals(twice)).toBe(
      true,
    );
  });

  it("of xz, with invalid padding or data", async () => {
    const odd = unpacked("xz", packed("xz"), new Uint8Array(7), packed("xz"));
    await expect(odd).rejects.toThrow("padding of xz");
    const surplus = unpacked("xz", Uint8Array.of(1, 2, 3, 4), packed("xz"));
    await expect(surplus).rejects.toThrow("xz stream");
  });

  it("of Zstandard with other data between them", async () => {
    const found = await unpacked("zstd", packed("zst"), skippable, packed("zst"));
    expect(found.equals(twice)).toBe(true);
  });
});
