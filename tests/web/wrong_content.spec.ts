import { expect, it } from "vitest";
import { formatOfName, wrongContent } from "../../web/device/wrong_content.ts";

const contentOf = (...parts: BlobPart[]) => wrongContent(new Blob(parts));

it("text is recognized by its first bytes, with its beginning", async () => {
  expect(await contentOf("Notes on the scan\nsecond line")).toEqual({
    kind: "text",
    beginning: "Notes on the scan…",
  });
  expect(await contentOf("short")).toEqual({ kind: "text", beginning: "short" });
  expect(await contentOf(`${"ä".repeat(5000)}`)).toEqual({
    kind: "text",
    beginning: `${"ä".repeat(40)}…`,
  });
  expect(await contentOf(new Uint8Array([0xff, 0xfe, 0x41, 0, 0x42, 0]))).toEqual({
    kind: "text",
    beginning: "AB",
  });
});

it("a web page, and an empty file", async () => {
  expect(await contentOf("\n<!DOCTYPE html><title>404</title>")).toEqual({ kind: "webPage" });
  expect(await contentOf()).toEqual({ kind: "empty" });
});

it("other bytes are not text", async () => {
  expect(await contentOf(new Uint8Array([0x4e, 0x45, 0x53, 0x1a]))).toBeUndefined();
  expect(await contentOf(new Uint8Array([0xc3, 0x28, 0x41]))).toBeUndefined();
});

it("names state formats", () => {
  expect(
    ["a/notes.nrrd", "b.NII.gz", "c.txt", "constructor", "d.constructor"].map(formatOfName),
  ).toEqual(["NRRD", "NIfTI", undefined, undefined, undefined]);
});
