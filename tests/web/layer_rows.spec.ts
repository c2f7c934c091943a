/** The rows of the list of layers, and the layers in the address. */
import { describe, expect, it } from "vitest";
import type { StoreInfo, Triple } from "../../web/core/types.ts";
import {
  type LayerState,
  layersAddress,
  layersOfAddress,
  plainLayer,
  readLayer,
  readOrder,
  writeLayer,
} from "../../web/page/address/layer_address.ts";
import { readUrl, writeUrl } from "../../web/page/address/url_state.ts";
import { frameNotes } from "../../web/page/layers/frames_of_reference.ts";
import {
  dropOf,
  found,
  type LayerEntry,
  rowsInView,
  rowsOf,
} from "../../web/page/layers/layer_rows.ts";
import type { Source } from "../../web/stream/source.ts";

/** "a" is a layer, "gb" the layer b of the group g. */
const entriesOf = (text: string): LayerEntry[] =>
  text.split(" ").map((name, key) => ({
    key,
    title: name.at(-1) ?? "",
    group: name.slice(0, -1),
    visible: true,
    colour: "#ffffff",
    opacity: 1,
    isChosen: key === 0,
    isFirst: key === 0,
    isOpening: false,
    problem: undefined,
  }));
const shown = (rows: ReturnType<typeof rowsOf>) =>
  rows.map((row) => (row.kind === "group" ? `[${row.group}]` : row.entry.title)).join("");

describe("rows", () => {
  it("list the layers of a group together, at the position of its first layer", () => {
    const entries = entriesOf("a gb c gd he");
    expect(shown(rowsOf(entries, new Set()))).toBe("a[g]bdc[h]e");
    const [, group] = rowsOf(entries, new Set(["g"]));
    expect(group).toEqual({
      kind: "group",
      group: "g",
      keys: [1, 3],
      visible: 2,
      isCollapsed: true,
    });
    expect(shown(rowsOf(entries, new Set(["g"])))).toBe("a[g]c[h]e");
  });

  it("are found by all words, in names and groups", () => {
    const entries = entriesOf("a bonea boneb liverb");
    const titles = (query: string) =>
      found(entries, query).map(({ group, title }) => group + title);
    expect(titles("  ")).toHaveLength(4);
    expect(titles("BONE  a")).toEqual(["bonea"]);
    expect(titles("b")).toEqual(["bonea", "boneb", "liverb"]);
    expect(titles("nothing")).toEqual([]);
  });

  it("of a thousand layers are rendered only in view and at the focus", () => {
    const view = { top: 3400, height: 306, rowHeight: 34 };
    expect(rowsInView(1000, view, [0, 105])).toEqual([
      0,
      ...Array.from({ length: 17 }, (_, i) => 96 + i),
    ]);
    expect(rowsInView(3, { ...view, top: 0 }, [-1, 7])).toEqual([0, 1, 2]);
    expect(rowsInView(0, view, [0])).toEqual([]);
  });
});

describe("a layer that is dropped", () => {
  const rows = rowsOf(entriesOf("a gb gc d"), new Set()); // a [g] b c d

  it("goes before the row below", () => {
    expect(dropOf(rows, 4 - 1, 0)).toEqual({ group: "", before: 0 });
    expect(dropOf(rows, 0, 5)).toEqual({ group: "" });
    expect(dropOf(rows, 3, 1)).toEqual({ group: "", before: 1 });
    expect(dropOf(rows, 7, 1)).toBeUndefined();
  });

  it("joins a group between two of its layers, and below its row", () => {
    expect(dropOf(rows, 0, 2)).toEqual({ group: "g", before: 1 });
    expect(dropOf(rows, 0, 3)).toEqual({ group: "g", after: 1 });
    expect(dropOf(rows, 3, 3)).toEqual({ group: "g", after: 1 });
  });

  it("stays in its group if dropped at the group's end, and leaves it elsewhere", () => {
    expect(dropOf(rows, 1, 4)).toEqual({ group: "g", after: 2 });
    expect(dropOf(rows, 1, 5)).toEqual({ group: "" });
    expect(dropOf(rows, 2, 1)).toEqual({ group: "", before: 1 });
    expect(dropOf(rows, 0, 4)).toEqual({ group: "", before: 3 });
  });

  it("does not join a collapsed group", () => {
    const collapsed = rowsOf(entriesOf("a gb gc d"), new Set(["g"])); // a [g] d
    expect(dropOf(collapsed, 3, 1)).toEqual({ group: "", before: 1 });
    expect(dropOf(collapsed, 0, 2)).toEqual({ group: "", before: 3 });
  });
});

describe("frames of reference", () => {
  const grid = (change: Partial<StoreInfo> = {}) =>
    ({
      voxels: [11, 11, 11],
      spacing: [1, 1, 1],
      origin: [0, 0, 0],
      direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
      metadata: {},
      ...change,
    }) as StoreInfo;
  const head = { title: "head", info: grid({ origin: [100, 0, -50] }) };
  const notesOf = (...infos: StoreInfo[]) =>
    frameNotes(
      head,
      infos.map((info, i) => ({ title: `layer ${i}`, info })),
    );

  it("are not mentioned if grids are the same, or overlap in the world", () => {
    expect(notesOf()).toEqual([]);
    expect(notesOf(head.info, grid({ origin: [108, 2, -52], voxels: [5, 5, 5] }))).toEqual([]);
    // Turned by half a circle about z, it ends where the other one begins.
    const turned = { direction: [-1, 0, 0, 0, -1, 0, 0, 0, 1], origin: [111, 9, -50] };
    expect(notesOf(grid(turned as Partial<StoreInfo>))).toEqual([]);
    const plain = { title: "plain", info: grid() };
    expect(frameNotes(plain, [plain])).toEqual([]);
  });

  it("contradict each other if the volumes lie apart", () => {
    expect(notesOf(grid({ origin: [-100, 0, -50] }))).toEqual([
      expect.stringMatching(/^layer 0 lies apart from head: their frames of reference contradict/),
    ]);
  });

  it("contradict each other if the stores name different ones, even on the same grid", () => {
    const of = (frame: string) => grid({ metadata: { frame_of_reference: frame } });
    const notes = (first: string, other: string) =>
      frameNotes({ title: "a", info: of(first) }, [{ title: "b", info: of(other) }]);
    for (const frame of ["scanner", "mni152", "dicom-0123456789abcdef"]) {
      expect(notes(frame, frame)).toEqual([]);
    }
    expect(notes("scanner", "dicom-0123456789abcdef")).toEqual([]);
    for (const other of ["mni152", "dicom-fedcba9876543210"]) {
      expect(notes("dicom-0123456789abcdef", other)).toEqual([
        expect.stringMatching(/^b and a have different frames of reference/),
      ]);
    }
    expect(frameNotes({ title: "a", info: of("mni152") }, [{ title: "b", info: grid() }])).toEqual(
      [],
    );
  });

  it("are known if a store names one, even with its first voxel at the origin", () => {
    const scanned = { title: "scan", info: grid({ metadata: { frame_of_reference: "scanner" } }) };
    expect(frameNotes(scanned, [head])).toEqual([expect.stringMatching(/^head lies apart/)]);
  });

  it("are the same for stores of one file, whatever their position in it", () => {
    const ofFile = (origin: Triple, file = "seg.nii.gz", more = {}) =>
      grid({ origin, metadata: { source: { file, ...more } } });
    const liver = { title: "liver", info: ofFile([100, 0, -50]) };
    const notes = (info: StoreInfo) => frameNotes(liver, [{ title: "spleen", info }]);
    expect(notes(ofFile([160, 40, 50]))).toEqual([]);
    // Another file, another lattice, or a file of this name in another folder.
    for (const other of [
      ofFile([160, 40, 50], "ct.nii.gz"),
      ofFile([160.5, 40, 50]),
      ofFile([160, 40, 50], "seg.nii.gz", { path_hash: "0123456789abcdef" }),
      grid({ origin: [160, 40, 50] }),
    ]) {
      expect(notes(other)).toHaveLength(1);
    }
  });

  it("are unknown without an address", () => {
    expect(notesOf(grid(), grid({ voxels: [2, 2, 2] }))).toEqual([
      expect.stringMatching(/^layer 0, layer 1: their files do not say where they lie/),
    ]);
    const plain = { title: "plain", info: grid() };
    expect(frameNotes(plain, [head])).toEqual([expect.stringMatching(/^plain: its file does not/)]);
    const many = Array.from({ length: 9 }, () => grid());
    expect(notesOf(...many)[0]).toMatch(/^layer 0, layer 1, layer 2 and 6 more: /);
  });
});

describe("layers in the address", () => {
  const everything = {
    src: "https://example.org/a b/ü;%.isosplat?x=1&y=2",
    name: "Knochen; 50 %: groß",
    group: "CT,1",
    visible: false,
    isovalues: [300.5, -1e-9],
    colours: ["#d9ccb3", "#c8553d"],
    opacities: [0.4, 1],
    transform: [1, 0, 0, 12.5, 0, 1, 0.25, 0, 0, 0, 1, 1 / 3, 0, 0, 0, 1],
  };

  it("are read as they were written", () => {
    expect(readLayer(writeLayer(everything))).toEqual(everything);
    const query = writeUrl({ volume: "head", layers: [everything], layerOrder: [1, 0] });
    expect(query).toContain("&layer=src:https://example.org/a%20b/");
    expect(readUrl(query)).toEqual({ volume: "head", layers: [everything], layerOrder: [1, 0] });
  });

  it.each([
    "",
    "visible:off",
    "volume:",
    "volume:a;src:b",
    "volume:a;visible:perhaps",
    "volume:a;index:1",
    "index:-1",
    "index:99999",
    "volume:a;isovalue:x",
    "volume:a;colour:red",
    "volume:a;opacity:2",
    "volume:a;transform:1,2,3",
    "volume:a;transform:0,0,0,0,0,0,0,0,0,0,0,0",
    "volume:%",
    `volume:a;name:${"x".repeat(2000)}`,
    "volume:a;unknown:1",
    ":a",
  ])("are ignored if they are not valid: %s", (text) => {
    expect(readLayer(text)).toBeUndefined();
    const { layers, notes } = readUrl(`?volume=a&layer=${encodeURIComponent(text)}&layer=volume:b`);
    expect(layers).toEqual([{ volume: "b" }]);
    expect(notes).toHaveLength(1);
  });

  it("have an order that contains each number once", () => {
    expect(readOrder("2,0,1")).toEqual([2, 0, 1]);
    for (const text of ["", "1,1", "-1", "0.5", "99999"]) expect(readOrder(text)).toBeUndefined();
  });

  const source = {} as Source;
  const state = (key: number, change: Partial<LayerState> = {}): LayerState => ({
    ...plainLayer,
    key,
    source,
    place: {},
    ...change,
  });

  it("are only those that were added or changed", () => {
    const opened = [state(0), state(1, { name: "b" }), state(2)];
    expect(layersAddress({ opened, present: opened })).toEqual({ layers: [], order: undefined });
    const added = state(7, { place: { volume: "x" }, visible: false });
    const present = [added, state(0, { surfaces: [] }), state(1, { name: "B" })];
    expect(layersAddress({ opened, present })).toEqual({
      layers: [
        { index: 1, name: "B" },
        { index: 2, isRemoved: true },
        { volume: "x", visible: false },
      ],
      order: [3, 0, 1],
    });
  });

  it("keep their numbers when another one of the scene is missing", () => {
    const opened = [undefined, state(1), state(2)];
    const present = [
      state(1, { surfaces: [{ isovalue: 1, colour: "#ffffff", opacity: 1 }] }),
      state(2, { group: "g" }),
      state(5, { place: { volume: "v" } }),
      state(6),
    ];
    expect(layersAddress({ opened, present })).toEqual({
      layers: [{ index: 2, group: "g" }, { volume: "v" }],
      order: undefined,
    });
  });

  it("lead to the same layers", async () => {
    const opened = [state(0), state(1, { name: "b" }), state(2)];
    const present = [
      state(8, { place: { src: "s" }, name: "s" }),
      state(1, { name: "b", group: "g", visible: false }),
      state(0),
      state(9, { place: { volume: "v" } }),
    ];
    const { layers, order } = layersAddress({ opened, present });
    let key = 8;
    const made = await layersOfAddress(opened, layers, order, async ({ src, volume, name = "" }) =>
      state(key++, { place: src ? { src } : { volume: volume ?? "" }, name }),
    );
    expect(made).toEqual({ present, unknown: 0 });
  });

  it("count layers that do not exist, and put those that the order lacks last", async () => {
    const opened = [state(0)];
    const layers = [{ index: 4, visible: false }, { volume: "a" }, { volume: "gone" }];
    const made = await layersOfAddress(opened, layers, [2, 9], async ({ volume = "" }) =>
      volume === "gone" ? undefined : state(5, { place: { volume } }),
    );
    expect(made.unknown).toBe(1);
    expect(made.present.map(({ key }) => key)).toEqual([0, 5]);
  });
});
