/** Scenes and bundles of the browser: documents, headers, and the requests for them. */
import { execFileSync } from "node:child_process";
import {
  copyFileSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  renameSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, it, test } from "vitest";
import { Bundle, type BundleFile } from "../../web/scene/bundle.ts";
import { coarseBytesOf, parseBundleHeader, piecesOf } from "../../web/scene/bundle_header.ts";
import { parseScene } from "../../web/scene/parse_scene.ts";
import { bundleScene, sceneAt, sceneOfFiles, servedScene } from "../../web/scene/scene_source.ts";
import { ServedBundle } from "../../web/scene/served_bundle.ts";
import { BlobSource } from "../../web/stream/blob_source.ts";
import { ServerSource } from "../../web/stream/server_source.ts";
import { joined } from "../../web/stream/transfer.ts";
import { StreamError } from "../../web/stream/types.ts";
import { defaultLight } from "../../web/viewer/light.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { Chance } from "../support/chance.ts";
import { type RangeHost, rangeHost } from "../support/range_host.ts";
import { ballVoxels } from "../support/series.ts";
import { core } from "./fixture.ts";

const golden = new URL("../golden/bundle1.0/", import.meta.url);
const bundle = new Uint8Array(readFileSync(new URL("golden.isobundle", golden)));
const document = readFileSync(new URL("scene.json", golden));
const program = fileURLToPath(new URL("../../build/release/native/cli/isosplat", import.meta.url));
const signal = new AbortController().signal;
const instance = await core();
const utf8 = (text: string) => new TextEncoder().encode(text);
const example = { format: "isosplat-scene", version: 1, layers: [{ store: "a" }] };

/** The message of the StreamError that `action` throws; "" if it throws none. */
function fault(action: () => unknown): string {
  try {
    action();
    return "";
  } catch (error) {
    expect(error).toBeInstanceOf(StreamError);
    return (error as StreamError).message;
  }
}

async function wholeOf(source: {
  header(signal: AbortSignal): Promise<Uint8Array>;
  range: BlobSource["range"];
  fileBytes: number | undefined;
}): Promise<Uint8Array> {
  await source.header(signal);
  const parts: Uint8Array[] = [];
  await source.range(0, source.fileBytes ?? 0, signal, (part) => parts.push(part.slice()));
  return joined(parts);
}

describe("a scene's document", () => {
  it("has its members, defaults for absent ones, and unknown members", () => {
    const scene = parseScene(document);
    expect(scene.name).toBe("Golden stores");
    expect(scene.layers.map(({ name, stores, visible }) => [name, ...stores, visible])).toEqual([
      ["bytes", "u8.isosplat", true],
      ["tiny", "tiny.isosplat", false],
    ]);
    expect(scene.layers[0]?.surfaces).toEqual([{ isovalue: 100.5, colour: "#d9ccb3", opacity: 1 }]);
    expect(scene.layers[1]?.transform?.[3]).toBe(20);
    expect(scene.clip).toEqual({ low: [0, 0, 0], high: [1, 1, 1], planes: [], caps: false });
    expect(scene.json.unknown).toEqual({ kept: true });
  });

  it("has slices, look and measurements", () => {
    const slices = {
      along: [0.5, null, 0],
      plane: { normal: [0, 0, 1], offset: 2 },
      range: [1, 2],
    };
    const field = { name: "dose", value: 2.5, units: "Gy" };
    const points = [
      { position: [1, 2, 3], value: 4, level: 1, layer: "a", voxel: [0, 0, 1], field },
    ];
    const scene = parseScene(
      utf8(
        JSON.stringify({
          ...example,
          slices,
          look: { kind: "exact", colour_by: "isovalue", light: { occlusion_radius: 0.5 }, more: 1 },
          measurements: [{ kind: "note", text: "here", points }],
        }),
      ),
    );
    expect(scene.slices).toEqual(slices);
    const light = { ...defaultLight, occlusionRadius: 0.5 };
    expect(scene.look).toEqual({ kind: "exact", colourBy: "isovalue", light });
    expect(scene.measurements).toEqual([{ kind: "note", text: "here", points }]);
    const plain = parseScene(utf8(JSON.stringify(example)));
    expect(plain.slices).toEqual({ along: [null, null, null] });
    expect([plain.look, plain.measurements]).toEqual([{}, []]);
  });

  it("has the field that colours show", () => {
    const lookOf = (look: unknown) =>
      parseScene(utf8(JSON.stringify({ ...example, look }))).look.field;
    expect(lookOf({ colour_by: "field", field: { name: "p" } })).toEqual({
      name: "p",
      range: null,
      scale: "linear",
      steps: 0,
      lines: 0,
    });
    const field = { name: "p", range: [0.5, 20], scale: "logarithmic", steps: 12, lines: 0.25 };
    expect(lookOf({ field })).toEqual(field);
    const said = (change: object) =>
      fault(() => lookOf({ colour_by: "field", field: { ...field, ...change } }));
    expect(said({ name: "" })).toContain("look.field.name: expected the name of a field");
    expect(said({ name: 3 })).toContain("look.field.name: expected a text of at most 64 bytes");
    expect(said({ range: [2, 1] })).toContain("look.field.range[1]: expected a number above the");
    expect(said({ range: [1, 2, 3] })).toContain("look.field.range: expected a list of 2");
    expect(said({ range: [0, 1] })).toContain("look.field.range[0]: expected a number above 0");
    expect(said({ range: [0, 1], scale: "linear" })).toBe("");
    expect(said({ scale: "log" })).toContain("look.field.scale: expected one of linear, ");
    for (const steps of [1, 257]) {
      expect(said({ steps })).toContain("look.field.steps: expected 0, or 2 to 256 colours");
    }
    for (const steps of [-1, 2.5, "8"]) {
      expect(said({ steps })).toContain("look.field.steps: expected an integer from 0 to 2^53");
    }
    expect(said({ lines: -1 })).toContain("look.field.lines: expected 0, or a number above 0");
    expect(said({ lines: "5" })).toContain("look.field.lines: expected a finite number");
    expect(fault(() => lookOf({ colour_by: "field" }))).toContain(
      "look.field: expected the field that colours show, found nothing",
    );
  });

  it("has the labels of layers", () => {
    const label = { value: 7, voxels: 1000, volume: 1953.125 };
    const layers = [{ store: "a", label }, { store: "b" }];
    const scene = parseScene(utf8(JSON.stringify({ ...example, layers })));
    expect(scene.layers.map((layer) => layer.label)).toEqual([label, null]);
    for (const value of [0.5, 2 ** 54, "7", null]) {
      const wrong = [{ store: "a", label: { ...label, value } }];
      expect(
        fault(() => parseScene(utf8(JSON.stringify({ ...example, layers: wrong })))),
      ).toContain("layers[0].label.value: expected an integer from -2^53 to 2^53");
    }
  });

  it("has stores for each step of time, or one for all", () => {
    const time = { steps: [0, 0.5, 2], unit: "s" };
    const layers = [{ stores: ["a", "b", "c"] }, { store: "d" }];
    const scene = parseScene(utf8(JSON.stringify({ ...example, time, layers })));
    expect(scene.time).toEqual({ values: [0, 0.5, 2], unit: "s" });
    expect(scene.layers.map(({ stores }) => stores)).toEqual([["a", "b", "c"], ["d"]]);
    const stepOf = (step: unknown) =>
      parseScene(utf8(JSON.stringify({ ...example, time: { ...time, step }, layers }))).step;
    expect([undefined, 2, 3, -1, 0.5, "1", null].map(stepOf)).toEqual([0, 2, 0, 0, 0, 0, 0]);
  });

  // The program reads the same documents (shared/core/scene/parse_scene.cpp).
  it("is refused if the program refuses it, with the same message", { timeout: 120_000 }, () => {
    const folder = mkdtempSync(join(tmpdir(), "isosplat-scene-"));
    const file = join(folder, "scene.json");
    const chance = new Chance(7);
    const values = [null, -1, 1e301, 0, "", "x", "#12345g", [], [1], {}, true, "a/../b"];
    const full = {
      ...example,
      name: "n",
      layers: [
        {
          store: "a",
          name: "b",
          group: "c",
          part_of: "d",
          visible: true,
          surfaces: [{ isovalue: 1, colour: "#010203", opacity: 0.5 }],
          transform: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
          label: { value: -3, voxels: 12, volume: 40.5 },
        },
        { stores: ["a", "b"] },
      ],
      time: { steps: [1, 2], unit: "s" },
      camera: { target: [0, 0, 0], distance: 1, azimuth: 1, elevation: 2, field_of_view: 3 },
      clip: {
        box: { low: [0, 0, 0], high: [1, 1, 1] },
        planes: [{ normal: [1, 0, 0], offset: 1 }],
      },
      slices: {
        along: [0, 0.5, null],
        plane: { normal: [0, 1, 0], offset: 1 },
        range: [1, 2],
        mapped: true,
      },
      look: {
        kind: "exact",
        shading: "smooth",
        colour_by: "field",
        colour_map: "magma",
        field: { name: "p", range: [1, 2], scale: "logarithmic", steps: 5, lines: 0.25 },
        light: { azimuth: 1, roughness: 0.5, occlusion_radius: 0.1, shadow_softness: 0.1 },
        eye_dome: 0.5,
      },
      background: "#01020304",
      measurements: [
        { kind: "distance", text: "w", points: [{ position: [0, 0, 0] }, { position: [1, 0, 0] }] },
        { kind: "note", text: "n", points: [{ position: [0, 0, 0], level: 1, normal: [0, 0, 1] }] },
      ],
    };
    let refused = 0;
    try {
      for (let i = 0; i < 200; ++i) {
        const changed = structuredClone(full) as unknown as Record<string, unknown>;
        change(changed, chance, values);
        const text = JSON.stringify(changed);
        writeFileSync(file, text);
        const found = fault(() => parseScene(utf8(text)));
        const said = programSays(file);
        // The message without the found value, whose numbers JavaScript writes in another way.
        const expected = (message: string) => message.replace(/, found .*/s, "").trim();
        if (found) ++refused;
        expect([text, expected(found)]).toEqual([text, expected(said)]);
      }
    } finally {
      rmSync(folder, { recursive: true });
    }
    expect(refused).toBeGreaterThan(50);
  });

  it("is refused if it is not JSON, not UTF-8 or too large", () => {
    expect(fault(() => parseScene(utf8("{")))).toContain("expected JSON");
    expect(fault(() => parseScene(new Uint8Array([0xff, 0xfe])))).toContain("expected JSON");
    expect(fault(() => parseScene(utf8("[".repeat(1_000_000))))).toContain("expected JSON");
    expect(fault(() => parseScene(new Uint8Array(4 * 1024 * 1024 + 1)))).toContain("at most");
  });
});

/** Replaces one member of a document, at any depth. */
function change(within: Record<string, unknown>, chance: Chance, values: readonly unknown[]): void {
  const keys = Object.keys(within);
  const key = chance.of(keys);
  const child = within[key];
  if (child && typeof child === "object" && Object.keys(child).length > 0 && chance.next() < 0.75) {
    change(child as Record<string, unknown>, chance, values);
  } else {
    within[key] = chance.of(values);
  }
}

/** The program's message about a scene's document; "" if it reads it. */
function programSays(file: string): string {
  try {
    execFileSync(program, ["info", file], { stdio: "pipe" });
    return "";
  } catch (error) {
    const { stderr } = error as { stderr: Buffer };
    const message = /scene: .*/.exec(stderr.toString())?.[0] ?? "";
    // Missing stores are not a fault of the document.
    return message;
  }
}

describe("the coarse parts of a bundle", () => {
  it("are kept up to a limit, and fetched again when they are needed", async () => {
    const asked: [number, number][] = [];
    const headerBytes = new DataView(bundle.buffer, bundle.byteOffset).getUint32(12, true);
    const file: BundleFile = {
      name: "golden",
      address: undefined,
      concurrency: 1,
      fresh: false,
      firstBytes: async () => bundle.slice(0, headerBytes),
      range: async (offset, bytes, _signal, arrived) => {
        asked.push([offset, bytes]);
        arrived(bundle.slice(offset, offset + bytes), offset);
      },
      bypassCaches: () => {},
      forget: () => {},
    };
    const first = new Bundle(file, instance);
    const { stores } = await first.header(signal);
    const parts = [...stores.values()].map((store) => ({
      path: store.path,
      offset: store.coarseOffset,
      bytes: coarseBytesOf(store),
    }));
    const [one, two] = parts as [(typeof parts)[0], (typeof parts)[0]];
    const read = async (from: Bundle, { offset, bytes }: typeof one) => {
      const found: Uint8Array[] = [];
      await from.range(offset, bytes, signal, (part) => found.push(part.slice()));
      expect(joined(found)).toEqual(bundle.slice(offset, offset + bytes));
    };

    // Both fit: each is fetched once.
    await first.fetchCoarse([one.path], signal);
    await first.fetchCoarse([two.path], signal);
    for (const part of [one, two, one]) await read(first, part);
    expect(asked).toHaveLength(2);
    expect(first.keptBytes).toBe(headerBytes + one.bytes + two.bytes);

    // One of them fits: the most recently used one.
    asked.length = 0;
    const small = new Bundle(file, instance, Math.max(one.bytes, two.bytes));
    await small.fetchCoarse([one.path], signal);
    await read(small, one);
    await small.fetchCoarse([two.path], signal);
    expect(small.keptBytes).toBe(two.bytes);
    await read(small, two);
    expect(asked).toHaveLength(2);
    await read(small, one);
    await small.fetchCoarse([one.path], signal);
    expect(small.keptBytes).toBe(one.bytes);
    await read(small, one);
    expect(asked).toEqual([one, two, one, one].map(({ offset, bytes }) => [offset, bytes]));
  });
});

describe("a bundle's header", () => {
  const header = () => {
    const found = parseBundleHeader(instance, bundle, "golden");
    if (typeof found === "number") throw new Error("expected a header");
    return found;
  };

  it("states its stores, whose pieces cover them", () => {
    const { stores, scene, coarseBytes, headerBytes } = header();
    expect(Buffer.from(scene)).toEqual(document);
    expect([...stores.keys()]).toEqual(["u8.isosplat", "tiny.isosplat"]);
    const covered = new Uint8Array(bundle.length).fill(1, 0, headerBytes);
    for (const store of stores.values()) {
      const pieces = piecesOf(store, 0, store.fileBytes);
      expect(pieces.reduce((sum, { bytes }) => sum + bytes, 0)).toBe(store.fileBytes);
      for (const { bundleOffset, bytes } of pieces) {
        for (let at = bundleOffset; at < bundleOffset + bytes; ++at)
          covered[at] = (covered[at] ?? 0) + 1;
      }
    }
    expect(covered.every((count) => count === 1)).toBe(true);
    expect(headerBytes + coarseBytes).toBeLessThanOrEqual(bundle.length);
  });

  it("states its size when only its first bytes are present", () => {
    expect(parseBundleHeader(instance, bundle.subarray(0, 64), "golden")).toBe(
      header().headerBytes,
    );
    expect(fault(() => parseBundleHeader(instance, bundle.subarray(0, 63), "golden"))).toContain(
      "64 bytes",
    );
  });

  it("is refused with one error wherever it is damaged", () => {
    const chance = new Chance(3);
    const size = header().headerBytes;
    for (let i = 0; i < 300; ++i) {
      const damaged = bundle.slice(0, size);
      const at = chance.whole(0, size - 1);
      damaged[at] = (damaged[at] ?? 0) ^ chance.whole(1, 255);
      // If the header states a larger size, more bytes are needed.
      const message = fault(() => {
        const found = parseBundleHeader(instance, damaged, "golden");
        if (typeof found === "number") throw new StreamError("cut-short", "golden: more bytes");
      });
      expect(message).toContain("golden: ");
    }
  });
});

describe("a scene of files", () => {
  const stores = ["u8.isosplat", "tiny.isosplat"].map((name) => {
    const bytes = readFileSync(new URL(`../golden/v1.0/${name}`, import.meta.url));
    return { path: name, file: new Blob([bytes]) };
  });

  it("in a bundle has the bytes of its stores", async () => {
    const scene = sceneOfFiles([{ path: "golden.isobundle", file: new Blob([bundle]) }]);
    const opened = await scene?.open(instance, signal);
    for (const store of stores) {
      const source = opened?.source(store.path);
      if (!source) throw new Error("expected a source");
      const bytes = await wholeOf(source);
      expect(Buffer.from(bytes)).toEqual(Buffer.from(await store.file.arrayBuffer()));
      expect(await source.contentId(signal)).toMatch(/^[0-9a-f]{32}$/);
    }
    await expect(opened?.source("other").header(signal)).rejects.toThrow(
      "expected the store other",
    );
  });

  it("with separate stores has the chosen ones", async () => {
    const [first] = stores;
    const scene = sceneOfFiles([
      { path: "scan/scene.json", file: new Blob([document]) },
      ...(first ? [first] : []),
    ]);
    const opened = await scene?.open(instance, signal);
    expect((await opened?.source("stores/u8.isosplat").header(signal))?.length).toBeGreaterThan(64);
    expect(fault(() => opened?.source("tiny.isosplat"))).toContain("choose it too");
  });

  it("with separate stores distinguishes stores of one name by their folders", async () => {
    const layers = ["a/x.isosplat", "b/x.isosplat"].map((store) => ({ store }));
    const json = new Blob([JSON.stringify({ ...example, layers })]);
    const [first, second] = stores.map(({ file }) => file);
    if (!first || !second) throw new Error("expected two stores");
    const open = (...files: { path: string; file: Blob }[]) =>
      sceneOfFiles([{ path: "s/scene.json", file: json }, ...files])?.open(instance, signal);
    const folder = await open(
      { path: "s/a/x.isosplat", file: first },
      { path: "s/b/x.isosplat", file: second },
    );
    const found = await folder?.source("b/x.isosplat").header(signal);
    expect(found).toEqual(await new BlobSource(second, "x").header(signal));
    const one = await open({ path: "x.isosplat", file: first });
    for (const { store } of layers) {
      expect(fault(() => one?.source(store))).toContain("more than once");
    }
  });

  it("is not found among other files", () => {
    expect(sceneOfFiles(stores)).toBeNull();
  });
});

describe("a scene of a server", () => {
  let server: RunningServer;
  let folder: string;
  beforeAll(async () => {
    folder = mkdtempSync(join(tmpdir(), "isosplat-scenes-"));
    mkdirSync(join(folder, "head"));
    writeFileSync(join(folder, "head.isobundle"), bundle);
    writeFileSync(join(folder, "head/scene.json"), document);
    for (const name of ["u8.isosplat", "tiny.isosplat"]) {
      copyFileSync(new URL(`../golden/v1.0/${name}`, import.meta.url), join(folder, "head", name));
    }
    server = await serve([folder]);
  });
  afterAll(async () => {
    await server.stop();
    rmSync(folder, { recursive: true });
  });

  test.each(["head", "head~scene"])("%s takes one request for its first picture", async (scene) => {
    const file = new ServedBundle({ base: server.url, scene });
    const opened = await bundleScene(file).open(instance, signal);
    const { layers } = opened.document;
    const paths = layers.filter(({ visible }) => visible).flatMap(({ stores }) => stores);
    await opened.fetchFirst(paths);
    for (const path of paths) {
      const store = instance.openStore(await opened.source(path).header(signal));
      const { offset, bytes } = store.bootstrapRange();
      await opened.source(path).range(offset, bytes, signal, () => {});
      store.close();
    }
    expect(file.requests).toBe(1);
    for (const path of layers.flatMap(({ stores }) => stores)) {
      const store = readFileSync(new URL(`../golden/v1.0/${path}`, import.meta.url));
      expect(Buffer.from(await wholeOf(opened.source(path)))).toEqual(store);
    }
    expect(file.requests).toBeGreaterThan(1);
  });

  it("is read again if it was replaced", async () => {
    const other = join(folder, "other.isobundle");
    writeFileSync(other, bundle);
    const scene = servedScene({ base: server.url, scene: "other" });
    await expect
      .poll(() =>
        scene.open(instance, signal).then(
          () => true,
          () => false,
        ),
      )
      .toBe(true);
    const opened = await scene.open(instance, signal);
    const source = opened.source("tiny.isosplat"); // not in the first response
    const before = await source.contentId(signal);
    expect(before).toMatch(/^[0-9a-f]{32}$/);
    // Another document has the same stores: the content of the scene changes, that of the store
    // does not.
    const changed = JSON.parse(document.toString()) as { layers: object[] };
    changed.layers.reverse();
    writeFileSync(join(folder, "head/changed.scene.json"), JSON.stringify(changed));
    const made = join(folder, "made.isobundle");
    execFileSync(program, ["bundle", join(folder, "head/changed.scene.json"), "-o", made]);
    renameSync(made, other);
    await expect
      .poll(
        () =>
          source
            .range(0, 100, signal, () => {})
            .then(
              () => "read",
              (error) => error.kind,
            ),
        {
          timeout: 20_000,
        },
      )
      .not.toBe("read");
    expect(await source.contentId(signal)).toBe(before);
    source.forget();
    const header = await source.header(signal);
    expect(Buffer.from(header)).toEqual(
      readFileSync(new URL("../golden/v1.0/tiny.isosplat", import.meta.url)).subarray(
        0,
        header.length,
      ),
    );
  });

  it("gets further steps, which `isosplat build` appends while it is served", async () => {
    const files = [0.2, 0.25, 0.3].map((radius, step) => {
      const header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n";
      const voxels = ballVoxels(24, { centre: [0.5, 0.5, 0.5], radius });
      const file = join(folder, `step_${step}.nrrd`);
      writeFileSync(file, Buffer.concat([Buffer.from(header), voxels]));
      return file;
    });
    const build = (steps: number) => {
      const output = ["-o", `${join(folder, "run")}/`, "--quiet", "--no-thumbnail"];
      execFileSync(program, ["build", ...files.slice(0, steps), ...output]);
    };
    const described = async () => {
      const response = await fetch(`${server.url}v1/scenes/run~scene`);
      return response.ok
        ? ((await response.json()) as { steps: number; urls: { file: string } })
        : null;
    };
    build(2);
    await expect.poll(async () => (await described())?.steps, { timeout: 20_000 }).toBe(2);
    const before = await described();
    build(3);
    await expect.poll(async () => (await described())?.steps, { timeout: 20_000 }).toBe(3);
    const old = await fetch(new URL(before?.urls.file ?? "", server.url));
    expect(old.status).toBe(404);
    expect(await old.text()).toContain("the content of this scene is now");
    const opened = await servedScene({ base: server.url, scene: "run~scene" }).open(
      instance,
      signal,
    );
    expect(opened.document.time?.values).toHaveLength(3);
  });

  it("is not found if it does not exist", async () => {
    const scene = servedScene({ base: server.url, scene: "none" });
    await expect(scene.open(instance, signal)).rejects.toMatchObject({ kind: "not-found" });
  });
});

describe("a scene at an address", () => {
  let host: RangeHost;
  const files = new Map<string, Uint8Array>([
    ["/golden.isobundle", bundle],
    ["/golden.scene.json", document],
    ["/cut.isobundle", bundle.subarray(0, 200)],
    ["/page.isobundle", utf8("<!doctype html>")],
  ]);

  beforeAll(async () => {
    host = await rangeHost((path) => files.get(path));
  });
  afterAll(() => host.stop());

  it("as a bundle takes at most three requests for its first picture", async () => {
    host.asked.length = 0;
    const opened = await sceneAt(`${host.origin}/golden.isobundle`).open(instance, signal);
    const paths = opened.document.layers.flatMap(({ stores }) => stores);
    await opened.fetchFirst(paths);
    for (const path of paths) {
      const store = instance.openStore(await opened.source(path).header(signal));
      const { offset, bytes } = store.bootstrapRange();
      await opened.source(path).range(offset, bytes, signal, () => {});
      store.close();
    }
    expect(host.asked.length).toBeLessThanOrEqual(3);
    for (const path of paths) {
      const file = readFileSync(new URL(`../golden/v1.0/${path}`, import.meta.url));
      expect(Buffer.from(await wholeOf(opened.source(path)))).toEqual(file);
    }
  });

  it("as a document names its stores relative to itself", async () => {
    const opened = await sceneAt(`${host.origin}/golden.scene.json`).open(instance, signal);
    expect(opened.source("a/b.isosplat").name).toBe(`${host.origin}/a/b.isosplat`);
    expect(opened.source("https://other.example/b").name).toBe("https://other.example/b");
    expect(fault(() => opened.source("file:///etc/passwd"))).toContain("http or https");
  });

  it("as a document names volumes of servers, and stores in bundles by fragments", async () => {
    const opened = await sceneAt(`${host.origin}/golden.scene.json`).open(instance, signal);
    const served = opened.source("https://other.example/ct/v1/volumes/a%20b?key=1");
    expect(served).toBeInstanceOf(ServerSource);
    expect(served.address).toBe("https://other.example/ct/v1/volumes/a%20b");
    const paths = ["golden.isobundle#u8.isosplat", "golden.isobundle#tiny.isosplat"];
    expect(opened.source("https://other.example/v1/scenes/run#a%20b.isosplat").address).toBe(
      "https://other.example/v1/scenes/run#a%20b.isosplat",
    );
    host.asked.length = 0;
    await opened.fetchFirst(paths);
    for (const path of paths) {
      const source = opened.source(path);
      const [, name = ""] = path.split("#");
      const file = readFileSync(new URL(`../golden/v1.0/${name}`, import.meta.url));
      expect(Buffer.from(await wholeOf(source))).toEqual(file);
      // The address names the same store again.
      expect(source.address).toBe(`${host.origin}/${path}`);
      expect(opened.source(source.address ?? "").name).toBe(source.name);
    }
    // Four requests: the bundle's header, the coarse parts of both stores, and the rest of each.
    expect(host.asked.length).toBeLessThanOrEqual(4);
    const absent = opened.source("golden.isobundle#absent.isosplat");
    await expect(absent.header(signal)).rejects.toThrow("expected the store absent.isosplat");
    const wrong = opened.source("golden.isobundle#%zz");
    await expect(wrong.header(signal)).rejects.toThrow("expected the store %zz");
    expect(fault(() => opened.source("file:///a.isobundle#b"))).toContain("http or https");
  });

  it("as a document of this device may have stores at addresses", async () => {
    const store = `${host.origin}/golden.isobundle#u8.isosplat`;
    const json = JSON.stringify({ ...example, layers: [{ store }, { store: "near.isosplat" }] });
    const files = [{ path: "saved.scene.json", file: new Blob([json]) }];
    const opened = await sceneOfFiles(files)?.open(instance, signal);
    expect(opened?.source(store).address).toBe(store);
    expect(fault(() => opened?.source("near.isosplat"))).toContain("among the chosen files");
  });

  it("is refused with the cause", async () => {
    const open = (name: string) => sceneAt(`${host.origin}/${name}`).open(instance, signal);
    await expect(open("cut.isobundle")).rejects.toThrow(StreamError);
    await expect(open("page.isobundle")).rejects.toThrow("expected a file of isosplat bundle");
    await expect(open("none.isobundle")).rejects.toMatchObject({ kind: "not-found" });
    await expect(open("golden.isobundle?.json")).resolves.toBeDefined();
  });

  it("is read again after it was replaced, once for all of its stores", async () => {
    const before = files.get("/golden.isobundle") as Uint8Array;
    const opened = await sceneAt(`${host.origin}/golden.isobundle`).open(instance, signal);
    const sources = ["u8.isosplat", "tiny.isosplat"].map((path) => opened.source(path));
    for (const source of sources) await source.header(signal);
    host.asked.length = 0;
    const ids = await Promise.all(sources.map((source) => source.contentId(signal)));
    expect(host.asked.length).toBeLessThanOrEqual(2);
    expect(new Set(ids).size).toBe(2);
    for (const source of sources) source.forget();
    expect((await sources[0]?.header(signal))?.length).toBeGreaterThan(64);
    files.set("/golden.isobundle", before);
  });
});

test("a bundle whose header is larger than the first request", async () => {
  const blob = new BlobSource(new Blob([bundle]), "golden");
  const few = Object.assign(Object.create(blob) as BlobSource, {
    firstBytes: (_: number, ending: AbortSignal) => blob.firstBytes(64, ending),
    range: blob.range.bind(blob),
  });
  Object.defineProperty(few, "name", { value: "golden" });
  const opened = await bundleScene(few).open(instance, signal);
  expect(opened.document.layers.length).toBe(2);
  const source = opened.source("tiny.isosplat");
  expect((await source.header(signal)).length).toBeGreaterThan(64);
});
