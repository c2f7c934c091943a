import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import { buildOptions, messageOf, withoutOptions } from "../../web/texts/without_options.ts";
import { trackedFiles } from "../support/source_graph.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const option = /--[a-z]/;

/** The string literals of C++ files, adjacent ones joined. */
function literals(pattern: string): string[] {
  return trackedFiles(root, pattern).flatMap((file) =>
    [
      ...readFileSync(join(root, file), "utf8").matchAll(
        /"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*/g,
      ),
    ].map(([literal]) => literal.slice(1, -1).replace(/"\s*"/g, "")),
  );
}

describe("messages of the program, on the page", () => {
  it.each([
    [
      "a.nii: expected 64 bytes, found 20: the file is incomplete, or its header is wrong; copy or download it again, or read the incomplete volume with --allow-truncated",
      "a.nii: expected 64 bytes, found 20: the file is incomplete, or its header is wrong; copy or download it again",
    ],
    [
      "expected a surface without holes, found holes: choose the finest level, or leave the surface open (--open)",
      "expected a surface without holes, found holes: choose the finest level, or leave the surface open",
    ],
    [
      "a.h5: expected one volume, found 2: /a, /b: choose one with --dataset",
      "a.h5: expected one volume, found 2: /a, /b",
    ],
    [
      "a.dcm: cannot be read (or ignore unreadable files with --allow-gaps)",
      "a.dcm: cannot be read",
    ],
    [
      "a.hdr: expected NRRD, found an ENVI header: give its data file with --dims, --type and --spacing",
      "a.hdr: expected NRRD, found an ENVI header: give its data file",
    ],
    [
      "a.img: expected NRRD, found voxels: give it with --dims, --type and --spacing, or put the .hdr beside it",
      "a.img: expected NRRD, found voxels: put the .hdr beside it",
    ],
    [
      'expected one of the segments 1, 2 for --segment, found "9"',
      'expected one of the segments 1, 2, found "9"',
    ],
    [
      "s.h5: expected one of its scales as --dataset, 0, 1, found 7",
      "s.h5: expected one of its scales, 0, 1, found 7",
    ],
    [
      "a.nrrd: expected a --time-step from 0 to 3, found 9: choose another",
      "a.nrrd: expected a time step from 0 to 3, found 9: choose another",
    ],
    [
      "/data: --dims, --type, --endian and --skip-bytes are for raw files, this is a folder: remove these options",
      "/data: dims, type, endian and skip bytes are for raw files, this is a folder: remove these options",
    ],
    [
      "a.vth: --spacing: expected none for a hierarchy of grids",
      "a.vth: spacing: expected none for a hierarchy of grids",
    ],
    [
      "12 voxels have no value according to the file's header; --missing-value none keeps them",
      "12 voxels have no value according to the file's header",
    ],
    [
      "a.npy: expected z, y, x, found the shape (9): choose along the first with --time-step 0 to --time-step 2, or along the last with --channel 0 to --channel 3",
      "a.npy: expected z, y, x, found the shape (9)",
    ],
    [
      "the header has no voxel spacing: 1,1,1 is assumed; --spacing sets another; coronal slices are assumed",
      "the header has no voxel spacing: 1,1,1 is assumed; coronal slices are assumed",
    ],
    ["use --memory 4G", "use memory 4G"],
    ["a --type x.raw: expected 9 bytes, found 8", "a --type x.raw: expected 9 bytes, found 8"],
  ])("have no options: %s", (message, words) => {
    expect(withoutOptions(message)).toBe(words);
    expect(messageOf(new Error(message))).toBe(words);
  });

  it.each([
    "a.lzma: expected NRRD, found LZMA-compressed data: unpack it with xz -d --format=lzma a.lzma, and give the volume in it",
    "a.nrrd: expected NRRD, found a pointer of Git LFS: get the file with git lfs pull --include a.nrrd",
    "a.isosplat: expected a store with fields, found one without: isosplat build --field adds them",
    "403: expected an address of the server, found evil.example: use a name that the server was started with: --allow-host NAME",
    "brain --final.nrrd: expected 3 sizes, found 2",
    "brain --type.nrrd",
    "a--b.nrrd: expected 3 sizes, found 2",
  ])("keep other programs, commands and names of files: %s", (message) => {
    expect(withoutOptions(message)).toBe(message);
  });

  /** Messages of the core that name options. */
  const messages = literals("shared/*.cpp")
    .filter((text) => option.test(text) && text.includes(" "))
    .map((text) => `a.nrrd: ${text.replace(/^\{\}: /, "").replace(/\{:?[^{}]*\}/g, "7")}`);

  it("name only known options", () => {
    const known = new Set<string>([...buildOptions, "include", "format", "field"]);
    const found = messages.flatMap((text) => [...text.matchAll(/--([a-z-]+)/g)]);
    expect(found.length).toBeGreaterThan(40);
    expect(found.map(([, name = ""]) => name).filter((name) => !known.has(name))).toEqual([]);
  });

  it("are whole sentences, whatever the core says", () => {
    const ofOthers = /isosplat build --(labels|field)|git lfs pull --include|xz -d --format/;
    const whole = messages.filter((text) => !/^a\.nrrd: (\s|[:,]|7--)|\s$/.test(text));
    for (const message of whole) {
      const words = withoutOptions(message);
      if (!ofOthers.test(message)) expect(words).not.toMatch(option);
      expect(words.length, message).toBeGreaterThan("a.nrrd: ".length);
      expect(words).not.toMatch(/[:;,] ?[,;:.]|[,;:] ?$|\(\)| {2}/);
      for (const word of ["expected", "found"]) {
        expect([message, words.includes(word)]).toEqual([message, message.includes(word)]);
      }
    }
  });

  it("come to the page only without them", () => {
    const files = trackedFiles(root, "web/page/*.ts");
    expect(files.length).toBeGreaterThan(80);
    const direct = /String\(error\)|\b(error|problem|fault)\??\.message\b/;
    // A message that is compared is not shown.
    const isRight = /withoutOptions\(|\.test\(error\.message\)/;
    const found = files.flatMap((file) =>
      readFileSync(join(root, file), "utf8")
        .split("\n")
        .filter((line) => direct.test(line) && !isRight.test(line))
        .map((line) => `${file}: ${line.trim()}`),
    );
    expect(found).toEqual([]);
  });
});

describe("texts of the page", () => {
  /** Options in texts for those who use the program, by their reasons. */
  const named = new Map([
    ["faults", ["--cors"]], // for the operator of a server, who sets it
    ["surface", ["--mesh"]], // for a surface that is too large for browsers: the program writes it
  ]);

  it.each(
    trackedFiles(root, "web/texts/*.ts").filter((file) => !file.endsWith("without_options.ts")),
  )("name no other options: %s", (file) => {
    const name = file.slice("web/texts/".length).split(".")[0] ?? "";
    const found = readFileSync(join(root, file), "utf8").match(/--[a-z-]+/g) ?? [];
    expect(found).toEqual(named.get(name) ?? []);
  });
});
