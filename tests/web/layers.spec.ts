/**
 * The resources that layers share (sample budget, requests, progress), their order, and their
 * transforms.
 */
import { describe, expect, test } from "vitest";
import type { StoreInfo } from "../../web/core/types.ts";
import { RequestLimit } from "../../web/stream/request_limit.ts";
import type { Progress } from "../../web/stream/types.ts";
import type { Layer } from "../../web/viewer/layer.ts";
import { type LayerEntry, LayerList } from "../../web/viewer/layer_list.ts";
import { openingProgress, progressOfLayers } from "../../web/viewer/layers_progress.ts";
import { shareSamples } from "../../web/viewer/sample_shares.ts";
import {
  checkedTransform,
  coverage,
  identity,
  placed,
  scaleOf,
  viewProjectionOf,
  volumeScaleOf,
} from "../../web/viewer/transform.ts";

describe("the sample budget", () => {
  const need = (coverage: number, surfaces = 1, pinned = 0) => ({ coverage, surfaces, pinned });

  test("a single layer gets all of it", () => {
    expect(shareSamples(1001, [need(0, 0, 5)])).toEqual([1001]);
    expect(shareSamples(1001, [])).toEqual([]);
  });

  test("is divided in proportion to the size of surfaces on the screen", () => {
    expect(shareSamples(1200, [need(0.25), need(0.5)])).toEqual([400, 800]);
    expect(shareSamples(1200, [need(0.25, 2), need(0.5)])).toEqual([600, 600]);
    expect(shareSamples(1200, [need(0), need(0, 0)])).toEqual([600, 600]);
  });

  test("leaves each layer its coarse levels, and little more to layers outside of the picture", () => {
    expect(shareSamples(1200, [need(0.5, 1, 100), need(0.5, 1, 300)])).toEqual([500, 700]);
    const [outside = 0, inside = 0] = shareSamples(1050, [need(0), need(1)]);
    expect([outside, inside]).toEqual([50, 1000]);
  });

  test("is never exceeded, unless coarse levels alone exceed it", () => {
    for (let i = 0; i < 1000; ++i) {
      const needs = Array.from({ length: 1 + (i % 9) }, () =>
        need(Math.random(), Math.floor(4 * Math.random()), Math.floor(1000 * Math.random())),
      );
      const sum = shareSamples(20_000, needs).reduce((all, share) => all + share, 0);
      expect(sum).toBeLessThanOrEqual(20_000);
      expect(sum).toBeGreaterThan(19_900);
    }
  });
});

describe("the order of layers", () => {
  /** Layers "a", "b", … ; capital letters: not listed yet. */
  function listOf(names: string) {
    const list = new LayerList();
    const entries = [...names].map((name, id) => {
      const entry = { layer: { id, name } as Layer, isListed: name === name.toLowerCase() };
      list.add(entry as LayerEntry);
      return entry as LayerEntry;
    });
    const layerOf = (name: string) => entries[names.indexOf(name)]?.layer as Layer;
    const order = () => list.entries.map(({ layer }) => layer.name).join("");
    return { list, entries, layerOf, order };
  }

  test("is the order in which they were added, until a layer is moved", () => {
    const { list, layerOf, order } = listOf("abcd");
    expect(list.move(layerOf("d"), 0)).toBe(true);
    expect(order()).toBe("dabc");
    expect(list.move(layerOf("a"), 3)).toBe(true);
    expect(order()).toBe("dbca");
    expect(list.move(layerOf("b"), 2)).toBe(true);
    expect(order()).toBe("dcba");
    expect(list.move(layerOf("c"), 1)).toBe(false);
    expect(order()).toBe("dcba");
  });

  test("counts only the layers that are listed", () => {
    const { list, layerOf, order } = listOf("aXbYc");
    list.move(layerOf("c"), 1);
    expect(order()).toBe("aXcbY");
    expect(list.listed.map(({ name }) => name)).toEqual(["a", "c", "b"]);
    list.move(layerOf("a"), 2);
    expect(list.listed.map(({ name }) => name)).toEqual(["c", "b", "a"]);
    expect(() => list.move(layerOf("X"), 0)).toThrow(RangeError);
  });

  test("refuses any other index", () => {
    const { list, layerOf, order } = listOf("abc");
    for (const index of [-1, 3, 0.5, Number.NaN]) {
      expect(() => list.move(layerOf("a"), index)).toThrow(`from 0 to 2, found ${index}`);
    }
    expect(order()).toBe("abc");
  });

  test("finds the layer of a volume's number: numbers of steps follow the layer's number", () => {
    const { list, entries } = listOf("abc"); // 0, 1, 2
    expect([0, 2, 7].map((volume) => list.idOf(volume))).toEqual([0, 2, 2]);
    list.remove(entries[1] as LayerEntry);
    expect(list.idOf(1)).toBe(0);
  });

  test("does not change which layer is the first: it stays the one that was added first", () => {
    const { list, entries, layerOf } = listOf("abcd");
    list.move(layerOf("a"), 3);
    list.move(layerOf("d"), 0);
    expect(list.first?.layer.name).toBe("a");
    list.remove(entries[0] as LayerEntry);
    expect(list.first?.layer.name).toBe("b");
    list.clear();
    expect(list.first).toBeUndefined();
    list.add(entries[2] as LayerEntry);
    expect(list.first?.layer.name).toBe("c");
  });
});

describe("requests", () => {
  test("a single session makes as many as its source allows", () => {
    const share = new RequestLimit().join(
      () => 3,
      () => {},
    );
    for (const free of [3, 2, 1, 0]) {
      expect(share.free).toBe(free);
      share.begin();
    }
  });

  test("several sessions together make no more, and take turns", () => {
    const limit = new RequestLimit();
    const told: string[] = [];
    const join = (name: string, concurrency: number) =>
      limit.join(
        () => concurrency,
        () => told.push(name),
      );
    const [a, b, c] = [join("a", 4), join("b", 2), join("c", 2)];
    expect([a.free, b.free]).toEqual([4, 2]);
    for (let i = 0; i < 3; ++i) a.begin();
    b.begin();
    expect([a.free, b.free, c.free]).toEqual([0, 0, 0]);
    a.ended();
    expect(told).toEqual([]);
    a.begin();
    for (const share of [b, a, c]) share.wait();
    a.ended();
    expect(told).toEqual(["b", "c"]);
    expect([a.free, b.free, c.free]).toEqual([1, 1, 1]);
    told.length = 0;
    // Sessions that were notified begin their requests, or wait again.
    b.ended();
    expect(told).toEqual(["a"]);
    a.leave();
    a.ended();
    expect([b.free, c.free]).toEqual([2, 2]);
  });

  test("begin when no session pauses them", () => {
    const limit = new RequestLimit();
    let turns = 0;
    const share = limit.join(
      () => 2,
      () => ++turns,
    );
    const [first, second] = [0, 1].map(() =>
      limit.join(
        () => 1,
        () => {},
      ),
    );
    first?.pause();
    second?.pause();
    expect(share.free).toBe(0);
    share.wait();
    first?.resume();
    expect([share.free, turns]).toEqual([0, 0]);
    second?.leave();
    expect([share.free, turns]).toEqual([2, 1]);
    second?.pause();
    expect(share.free).toBe(2);
  });
});

describe("progress", () => {
  const progress = (state: Progress["state"], change: Partial<Progress> = {}): Progress => ({
    ...openingProgress,
    state,
    complete: state === "complete",
    ...change,
  });

  test("the progress of one layer is unchanged", () => {
    const own = progress("refining", { chunksToGo: 3 });
    expect(progressOfLayers([own], 5)).toBe(own);
  });

  test("nothing is missing if no layer is shown", () => {
    expect(progressOfLayers([], 5)).toMatchObject({ state: "complete", complete: true });
  });

  test("numbers are added, and the picture is complete when all layers are", () => {
    const a = progress("complete", { samplesResident: 5, sampleBudget: 10, finestLevel: 1 });
    const b = progress("complete", { samplesResident: 7, sampleBudget: 20, finestLevel: 0 });
    const both = progressOfLayers([a, b], 30);
    const numbers = { samplesResident: 12, sampleBudget: 30, finestLevel: 0 };
    expect(both).toMatchObject({ state: "complete", complete: true, ...numbers });
    expect(progressOfLayers([a, openingProgress], 30)).toMatchObject({
      state: "refining",
      complete: false,
      finestLevel: 1,
    });
    expect(progressOfLayers([openingProgress, openingProgress], 30).state).toBe("opening");
  });

  test("a fault of one layer is the fault of the picture", () => {
    const fault = { kind: "unreachable", message: "gone" } as const;
    const both = progressOfLayers([progress("complete"), progress("offline", { fault })], 30);
    expect(both).toMatchObject({ state: "offline", complete: false, fault });
  });
});

describe("transforms", () => {
  const info = {
    voxels: [11, 21, 31],
    spacing: [1, 2, 3],
    origin: [5, 6, 7],
    direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  } as unknown as StoreInfo;
  // Turns by 90° about z, doubles, shears y by z, and moves.
  const transform = [0, -2, 0, 10, 2, 0, 0.5, 20, 0, 0, 2, 30, 0, 0, 0, 1];

  const world = ({ direction, spacing, origin }: StoreInfo, voxel: readonly number[]) =>
    origin.map((start, row) =>
      voxel.reduce(
        (sum, v, i) => sum + v * (direction[3 * row + i] ?? 0) * (spacing[i] ?? 0),
        start,
      ),
    );
  const apply = (matrix: readonly number[], [x = 0, y = 0, z = 0]: readonly number[]) =>
    [0, 4, 8].map(
      (row) =>
        (matrix[row] ?? 0) * x +
        (matrix[row + 1] ?? 0) * y +
        (matrix[row + 2] ?? 0) * z +
        (matrix[row + 3] ?? 0),
    );

  test("have a scale if they change all lengths by the same factor", () => {
    expect(scaleOf(identity)).toBe(1);
    expect(volumeScaleOf(identity)).toBe(1);
    // A shear keeps volumes, and a reflection keeps them as well.
    expect(volumeScaleOf([-2, 5, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30, 0, 0, 0, 1])).toBe(24);
    expect(scaleOf([0, -2, 0, 10, 2, 0, 0, 20, 0, 0, -2, 30, 0, 0, 0, 1])).toBe(2);
    expect(scaleOf(transform)).toBeUndefined();
    expect(scaleOf([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1])).toBeUndefined();
  });

  test("without one, the grid stays the same", () => {
    expect(placed(info, identity)).toBe(info);
    const view = new Float64Array(16);
    expect(viewProjectionOf(view, identity)).toBe(view);
  });

  test("a transform is another grid, whose directions have length 1", () => {
    const moved = placed(info, transform);
    for (const voxel of [
      [0, 0, 0],
      [1, 0, 0],
      [3, 4, 5],
    ]) {
      const expected = apply(transform, world(info, voxel));
      world(moved, voxel).forEach((number, i) => void expect(number).toBeCloseTo(expected[i] ?? 0));
    }
    for (let axis = 0; axis < 3; ++axis) {
      const column = [0, 3, 6].map((row) => moved.direction[row + axis] ?? 0);
      expect(Math.hypot(...column)).toBeCloseTo(1);
    }
  });

  test("the view for streaming shows the store as the picture shows the moved grid", () => {
    const view = Float64Array.from({ length: 16 }, (_, i) => Math.sin(i));
    const own = viewProjectionOf(view, transform);
    const clip = (matrix: Float64Array, point: readonly number[]) =>
      [0, 1, 2, 3].map((row) =>
        [...point, 1].reduce((sum, number, k) => sum + (matrix[4 * k + row] ?? 0) * number, 0),
      );
    const expected = clip(view, apply(transform, [1, 2, 3]));
    clip(own, [1, 2, 3]).forEach((number, i) => void expect(number).toBeCloseTo(expected[i] ?? 0));
  });

  test("transforms that are not affine, or are singular, are refused", () => {
    for (const wrong of [
      [],
      identity.slice(1),
      identity.map((number) => number / 0),
      identity.with(12, 1),
      identity.with(15, 2),
      identity.with(0, 0),
      [1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
    ]) {
      expect(() => checkedTransform(wrong)).toThrow(RangeError);
    }
    expect(checkedTransform(transform)).toEqual(transform);
    // A mirror.
    expect(checkedTransform(identity.with(0, -1))).toEqual(identity.with(0, -1));
  });

  test("the share of the picture that a volume covers", () => {
    const cube = { ...info, voxels: [3, 3, 3], spacing: [0.5, 0.5, 0.5], origin: [0, 0, 0] };
    const box = cube as unknown as StoreInfo;
    expect(coverage(box, identity)).toBeCloseTo(1 / 4);
    const half = viewProjectionOf(Float64Array.from(identity), identity.with(3, 0.5));
    expect(coverage(box, half)).toBeCloseTo(1 / 8);
    const outside = viewProjectionOf(Float64Array.from(identity), identity.with(3, 3));
    expect(coverage(box, outside)).toBe(0);
    expect(coverage(box, identity.with(15, -1))).toBe(1);
  });
});
