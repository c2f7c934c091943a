/** What the address of the page opens. */
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { openTarget } from "../../web/page/address/open_target.ts";
import type { Source } from "../../web/stream/source.ts";

beforeEach(() => vi.stubGlobal("location", { href: "https://here.example/page/" }));
afterEach(() => vi.unstubAllGlobals());

const sourceOf = (src: string): Source => {
  const target = openTarget({ src });
  if (!target || !("source" in target)) throw new Error(`${src} is no store`);
  return target.source();
};

it("opens stores on any host", () => {
  expect(sourceOf("https://host.example/a/head.isosplat").address).toBe(
    "https://host.example/a/head.isosplat",
  );
  expect(openTarget({ src: "head.isosplat" })).toMatchObject({ name: "head.isosplat" });
});

it("opens a volume of another server, by the address of its data or of its page", () => {
  const api = "https://host.example/viewer/v1/volumes/ct~head";
  for (const src of [
    api,
    "https://host.example/viewer/?volume=ct~head&isovalue=60",
    "https://host.example/viewer/index.html?volume=ct~head",
    "https://other.example/?src=https://host.example/viewer/v1/volumes/ct~head",
  ]) {
    expect(sourceOf(src).address).toBe(api);
    expect(openTarget({ src })?.name).toBe("ct~head");
  }
  const scene = openTarget({ src: "https://host.example/?scene=my run&exp=9&sig=ab" });
  expect(scene).toMatchObject({ name: "my run", scene: expect.any(Function) });
});

it("leaves volumes, which are no stores, and what is no address, to the start page", () => {
  for (const src of ["https://host.example/head.nii.gz", "ftp://host.example/x", "device:0"]) {
    expect(openTarget({ src })).toBeUndefined();
  }
  expect(openTarget({ src: "https://host.example/?src=https://h.example/x.nrrd" })).toBeUndefined();
  // A page's link that names no address is opened as it stands.
  const wrong = "https://host.example/?src=http://[";
  expect(sourceOf(wrong).address).toBe(new URL(wrong).href);
  // Its query is its own.
  expect(sourceOf("https://host.example/get.php?volume=7").address).toBe(
    "https://host.example/get.php?volume=7",
  );
});
