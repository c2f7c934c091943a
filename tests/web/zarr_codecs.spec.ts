/** Compares the codecs of chunks with the encoders of numcodecs. */
import Blosc from "numcodecs/blosc";
import Lz4 from "numcodecs/lz4";
import { expect, test } from "vitest";
import { decodeBlosc } from "../../web/zarr/blosc.ts";
import { decodeLz4 } from "../../web/zarr/lz_blocks.ts";

/** Smooth 16-bit values with some noise: literals, and matches near and far. */
function sample(bytes: number): Uint8Array {
  const values = new Uint16Array(bytes / 2);
  for (let i = 0; i < values.length; ++i) {
    values[i] =
      1000 + 300 * Math.sin(i / 40) + (((i * 2654435761) >>> 13) & 3) + (i % 9000 > 4000 ? 7 : 0);
  }
  return new Uint8Array(values.buffer);
}

const inputs: [string, Uint8Array][] = [
  ["smooth values", sample(400_000)],
  ["values that do not fill the last block", sample(262_144 + 130)],
  ["zeros", new Uint8Array(70_000)],
  ["noise", Uint8Array.from({ length: 5000 }, (_, i) => Math.imul(i * i + 7, 2654435761) >>> 24)],
  ["few bytes", Uint8Array.of(1, 2, 3, 4, 5, 6)],
];

for (const cname of ["blosclz", "lz4", "lz4hc", "zlib", "zstd"]) {
  for (const shuffle of [0, 1, 2]) {
    test.each(inputs)(`Blosc with ${cname}, shuffle ${shuffle}: %s`, async (_, input) => {
      const codec = Blosc.fromConfig({
        id: "blosc",
        cname,
        clevel: 5,
        shuffle,
        blocksize: 0,
      } as never);
      const chunk = await codec.encode(input);
      expect(Buffer.compare(await decodeBlosc(chunk, input.length), input)).toBe(0);
      await expect(decodeBlosc(chunk, input.length - 1)).rejects.toThrow("at most");
    });
  }
}

test("chunks of Blosc that are cut or changed are errors, or other bytes of the same size", async () => {
  const input = sample(3000);
  for (const cname of ["blosclz", "lz4", "zstd"]) {
    const codec = Blosc.fromConfig({
      id: "blosc",
      cname,
      clevel: 5,
      shuffle: 1,
      blocksize: 0,
    } as never);
    const chunk = await codec.encode(input);
    for (let bytes = 0; bytes < chunk.length; bytes += 41) {
      await expect(decodeBlosc(chunk.slice(0, bytes), input.length)).rejects.toThrow();
    }
    for (let at = 0; at < chunk.length; at += 13) {
      const changed = chunk.slice();
      changed[at] = (changed[at] ?? 0) ^ 0x24;
      const decoded = await decodeBlosc(changed, 2 * input.length).catch(() => undefined);
      expect(decoded?.length ?? 0).toBeLessThanOrEqual(2 * input.length);
    }
  }
});

test.each(inputs)("LZ4: %s", async (_, input) => {
  const chunk = await Lz4.fromConfig({ id: "lz4" } as never).encode(input);
  expect(Buffer.compare(decodeLz4(chunk.subarray(4), input.length), input)).toBe(0);
  expect(() => decodeLz4(chunk.subarray(4), input.length + 1)).toThrow("damaged");
});
