/** The guessed layouts of raw files, and the requirements of saving. */
import { expect, test, vi } from "vitest";
import { guessRaw } from "../../web/device/raw_guess.ts";
import { layoutProblem, nameOf } from "../../web/device/reading.ts";
import { singlePage } from "../../web/device/save_single_page.ts";

test.each([
  ["head_256x256x109_uint16.raw", 2 * 256 * 256 * 109, [256, 256, 109], "u16", 0],
  ["head_256x256x109.raw", 256 * 256 * 109, [256, 256, 109], "u8", 0],
  ["a 64_32_16 float.bin", 4 * 64 * 32 * 16, [64, 32, 16], "f32", 0],
  ["head_8x8x8_int16.raw", 100 + 2 * 512, [8, 8, 8], "i16", 100],
  ["cube.raw", 100 ** 3, [100, 100, 100], "u8", 0],
  ["ct.raw", 2 * 512 * 512 * 37, [512, 512, 74], "u8", 0],
  ["nothing.raw", 7, [2, 2, 2], "u8", 0],
])("guesses %s of %d bytes", (name, bytes, dims, type, skipBytes) => {
  expect(guessRaw(name, bytes)).toEqual({ dims, type, bigEndian: false, skipBytes });
});

test("detects big-endian files by their name", () => {
  expect(guessRaw("a_4x4x4_int16_be.raw", 128).bigEndian).toBe(true);
  expect(guessRaw("beetle_4x4x4_int16.raw", 128).bigEndian).toBe(false);
});

test("reports why a layout does not fit", () => {
  const layout = { dims: [4, 4, 4], type: "u16", bigEndian: false, skipBytes: 0 } as const;
  const of = (change: object) => layoutProblem({ ...layout, dims: [4, 4, 4], ...change }, 130);
  expect(of({})).toBeUndefined();
  expect(of({ skipBytes: 2 })).toBeUndefined();
  expect(of({ skipBytes: 3 })).toBe(
    "expected 131 bytes, found a file of 130: correct the size or the type",
  );
  for (const dims of [
    [1, 4, 4],
    [4, 4, Number.NaN],
    [4, 4, 2.5],
    [4, 4, 2 ** 21],
  ]) {
    expect(of({ dims })).toContain("expected whole numbers of voxels");
  }
  expect(of({ skipBytes: -1 })).toContain("bytes to skip");
});

test("names volumes by their files", () => {
  expect(nameOf("scan/head.x.raw")).toBe("head.x");
  expect(nameOf(".raw")).toBe("volume");
});

test("saving a single page without a network reports the missing file", async () => {
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  try {
    await expect(singlePage(new Blob(["store"]), "head", "")).rejects.toThrow(
      "single.html: expected a file of this page, found no network",
    );
  } finally {
    vi.unstubAllGlobals();
  }
});
