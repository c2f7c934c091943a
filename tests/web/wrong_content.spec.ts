import { expect, it } from "vitest";
import { formatOfName, unknownTextOf, wrongContent } from "../../web/device/wrong_content.ts";
import { messageOf } from "../../web/texts/without_options.ts";
import { fileOf, importProgram, localImporter } from "../support/local_import.ts";

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

const vtu = '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0"></VTKFile>\n';
const pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 5\n";

it.each([
  ["mesh.vtu", vtu, "an unstructured grid of VTK's XML format"],
  ["scan.nrrd", pointer, "get the file with git lfs pull --include scan.nrrd"],
  ["part.stl", "solid part\nfacet normal 0 0 1\n", "a mesh (STL): give the volume"],
  ["scan.nii", "<?xml version='1.0'?><Error><Code>NoSuchKey</Code></Error>", "a storage host"],
  ["page.nrrd", "<?xml version='1.0'?><html></html>", "a web page"],
  ["a.hdr", "ENVI\nsamples = 3\n", "ENVI"],
  ["notes.nrrd", "Notes of the scan\nFirst line\n", undefined],
])("the core says what a text is, if it knows: %s", async (path, text, answer) => {
  const importer = await localImporter(await importProgram(), [fileOf(path, Buffer.from(text))]);
  let error: unknown;
  try {
    importer.open(path);
  } catch (thrown) {
    error = thrown;
  }
  const content = await unknownTextOf(error, new Blob([text]));
  if (answer === undefined) {
    expect(content).toEqual({ kind: "text", beginning: "Notes of the scan…" });
  } else {
    expect(content).toBeUndefined();
    expect(messageOf(error)).toContain(answer);
  }
});
