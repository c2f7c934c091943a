import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import { messageOf, withoutOptions } from "../../web/texts/without_options.ts";
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
      "a.hdr: expected NRRD, found an ENVI header",
    ],
    ["a--b.nrrd: expected 3 sizes, found 2", "a--b.nrrd: expected 3 sizes, found 2"],
  ])("have no options: %s", (message, words) => {
    expect(withoutOptions(message)).toBe(words);
    expect(messageOf(new Error(message))).toBe(words);
  });

  it("have none, whatever the core says", () => {
    const messages = literals("shared/*.cpp")
      .filter((text) => option.test(text) && text.includes(" "))
      .map((text) => `a.nrrd: ${text}`);
    expect(messages.length).toBeGreaterThan(40);
    for (const message of messages) {
      expect(withoutOptions(message)).not.toMatch(option);
      expect(withoutOptions(message)).toMatch(/^a\.nrrd/);
    }
  });

  it("come to the page only without them", () => {
    const files = trackedFiles(root, "web/page/*.ts");
    expect(files.length).toBeGreaterThan(80);
    const direct = /String\(error\)|\b(error|problem|fault)\??\.message\b/;
    const found = files.flatMap((file) =>
      readFileSync(join(root, file), "utf8")
        .split("\n")
        .filter((line) => direct.test(line) && !line.includes("withoutOptions("))
        .map((line) => `${file}: ${line.trim()}`),
    );
    expect(found).toEqual([]);
  });
});

it("no text of the page names an option", () => {
  for (const file of trackedFiles(root, "web/texts/*.ts")) {
    if (file.endsWith("without_options.ts")) continue;
    expect([file, ...(readFileSync(join(root, file), "utf8").match(/--[a-z-]+/g) ?? [])]).toEqual([
      file,
    ]);
  }
});
