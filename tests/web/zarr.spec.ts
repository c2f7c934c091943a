/** OME-Zarr images and Zarr arrays on a plain web server: metadata, voxels, and refusals. */
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { replaceCodecs } from "../../web/zarr/codecs.ts";
import { openImage } from "../../web/zarr/open_image.ts";
import type { ZarrImage, ZarrScale } from "../../web/zarr/types.ts";
import { ZarrHost } from "../../web/zarr/zarr_host.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
import { writeArray, writeGroup, writeJson } from "../support/zarr.ts";
import { plainZarr as plain, valueAt, voxels, zarrVariants } from "../support/zarr_variants.ts";
import { expectedVoxels, readVoxels } from "../support/zarr_voxels.ts";

async function voxelsOf({ address }: ZarrImage, scale: ZarrScale, host?: ZarrHost) {
  return readVoxels(host ?? new ZarrHost(new URL(address)), scale);
}

describe.skipIf(!hasNginx)("Zarr on nginx", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-zarr-"));
  let host: Nginx;

  beforeAll(async () => {
    replaceCodecs();
    host = await nginx({ folders: [folder] });
  });
  afterAll(async () => {
    await host?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test.each(zarrVariants)("an array of %s", async (name, options) => {
    const path = `${name.replaceAll(/\W+/g, "-")}.zarr`;
    await writeArray(join(folder, path), options);
    const image = await openImage(`${host.url}${path}/`);
    const [scale] = image.scales as [ZarrScale];
    expect(scale.description).toMatchObject({ voxels, type: "u16", format: "Zarr" });
    expect(scale.description.notes).toEqual(["its lengths have no unit: millimetres are assumed"]);
    expect(await voxelsOf(image, scale)).toEqual(expectedVoxels());
  });

  test("absent chunks have the fill value, and are counted", async () => {
    const isAbsent = (chunk: readonly number[]) => chunk.join() === "1,0,2";
    await writeArray(join(folder, "absent.zarr"), { ...plain, fill: 7, isAbsent });
    const image = await openImage(`${host.url}absent.zarr`);
    const reading = new ZarrHost(new URL(image.address));
    const found = await voxelsOf(image, image.scales[0] as ZarrScale, reading);
    const right = expectedVoxels();
    expect(found[0]).toBe(right[0]);
    expect(found[4 * 13 * 11 + 10]).toBe(7);
    expect(found.filter((voxel, i) => voxel !== right[i])).toHaveLength(3 * 4 * 4);
    expect(reading.absent).toBe(1);
  });

  const image5d = {
    name: "brain",
    axes: [
      { name: "t", type: "time", unit: "second" },
      { name: "c", type: "channel" },
      ...["z", "y", "x"].map((name) => ({ name, type: "space", unit: "micrometer" })),
    ],
    datasets: ["0", "1"].map((path, i) => ({
      path,
      coordinateTransformations: [
        { type: "scale", scale: [1, 1, 2, 0.5 * 2 ** i, 0.5 * 2 ** i] },
        { type: "translation", translation: [0, 0, 0, 0.25 * i, 0.25 * i] },
      ],
    })),
    coordinateTransformations: [{ type: "scale", scale: [1, 1, 10, 10, 10] }],
  };
  const scales = async (version: 2 | 3, path: string): Promise<void> => {
    for (const [i, step] of [1, 2].entries()) {
      await writeArray(join(folder, path, String(i)), {
        version,
        shape: [2, 3, 9, Math.ceil(11 / step), Math.ceil(13 / step)],
        chunks: [1, 2, 4, 4, 5],
        value: ([t = 0, c = 0, z = 0, y = 0, x = 0]) =>
          valueAt(x * step, y * step, z) + 10_000 * c + 30_000 * t,
      });
    }
  };

  test.each([
    ["0.4", 2],
    ["0.5", 3],
  ] as const)("an image of OME-Zarr %s: scales, units, channel and time", async (name, version) => {
    const path = `image-${name}.ome.zarr`;
    const attributes = { multiscales: [{ version: name, ...image5d }] };
    writeGroup(join(folder, path), version, version === 3 ? { ome: attributes } : attributes);
    await scales(version, path);
    const image = await openImage(`${host.url}${path}`);
    expect(image.chosen).toBeUndefined();
    const [fine, coarse] = image.scales as [ZarrScale, ZarrScale];
    expect(fine.description).toEqual({
      voxels,
      type: "u16",
      spacing: [0.005, 0.005, 0.02],
      origin: [0, 0, 0],
      name: `image-${name}`,
      format: "OME-Zarr",
      notes: ["t: 0 of 0 to 1 is read", "c: 0 of 0 to 2 is read"],
    });
    expect(coarse.description).toMatchObject({
      voxels: [7, 6, 9],
      spacing: [0.01, 0.01, 0.02],
      origin: [0.0025, 0.0025, 0],
    });
    expect(await voxelsOf(image, fine)).toEqual(expectedVoxels());
    // One scale by its address, and another channel.
    const chosen = await openImage(`${host.url}${path}/1#c=1`);
    expect(chosen.chosen).toBe(1);
    expect(chosen.scales[1]?.description.notes).toContain("c: 1 of 0 to 2 is read");
    const second = await voxelsOf(chosen, chosen.scales[1] as ZarrScale);
    expect([second[0], second[1]]).toEqual([10_001, 10_003]);
    await expect(openImage(`${host.url}${path}#c=3`)).rejects.toThrow(
      "expected an index of c from 0 to 2, found 3",
    );
  });

  test("requests to a host that fails now and then are repeated", async () => {
    await writeArray(join(folder, "again.zarr"), plain);
    const proxy = new FaultProxy(host.url);
    proxy.fault = (path, number) =>
      path.endsWith("1.1.1") && number % 2 === 0 ? { kind: "reset" } : undefined;
    await proxy.start();
    const image = await openImage(`${proxy.url}/again.zarr`);
    expect(await voxelsOf(image, image.scales[0] as ZarrScale)).toEqual(expectedVoxels());
    proxy.fault = () => ({ kind: "status", status: 403 });
    await expect(openImage(`${proxy.url}/again.zarr`)).rejects.toThrow("403");
    await proxy.stop();
  });

  const zarray = {
    zarr_format: 2,
    shape: [9, 11, 13],
    chunks: [4, 4, 5],
    dtype: "<u2",
    compressor: null,
    fill_value: 0,
    order: "C",
    filters: null,
  };
  test.each([
    ["too many voxels", { shape: [9, 11, 2 ** 40] }, "or too large"],
    [
      "voxels beyond numbers",
      { shape: [9, 11, 1e300] },
      "whole numbers from 1, found [9,11,1e+300]",
    ],
    [
      "a negative chunk",
      { chunks: [4, -4, 5] },
      "chunks of 3 whole numbers from 1, found [4,-4,5]",
    ],
    ["chunks of another rank", { chunks: [4, 4] }, "expected chunks of 3 whole numbers"],
    ["a shape of words", { shape: ["a", 2, 3] }, "expected a shape of whole numbers"],
    ["no shape", { shape: undefined }, "whole numbers from 1, found nothing"],
    ["one slice", { shape: [1, 11, 13] }, "it is no volume"],
    ["two axes", { shape: [11, 13], chunks: [4, 4] }, "expected the axes x, y and z"],
    ["half floats", { dtype: "<f2" }, "float16"],
    ["words as voxels", { dtype: "<U8" }, "expected integers"],
    ["an unknown type", { dtype: "<q9" }, "metadata are not valid"],
  ])("refuses %s", async (name, change, message) => {
    const path = `${name.replaceAll(" ", "-")}.zarr`;
    writeJson(join(folder, path, ".zarray"), { ...zarray, ...change });
    await expect(openImage(host.url + path)).rejects.toThrow(message);
  });

  test.each([
    ["an unknown codec", { compressor: { id: "squeeze" } }, "squeeze"],
    [
      "chunks that take too much memory",
      { shape: [2048, 2048, 2048], chunks: [2048, 2048, 64] },
      "choose a coarser scale",
    ],
    ["too many chunks", { shape: [100, 100, 100], chunks: [1, 1, 1] }, "found 1000000: choose"],
    ["a short chunk", {}, "expected 80 voxels, found 3"],
    ["a chunk that inflates to too much", { compressor: { id: "gzip" } }, "numcodecs.gzip"],
  ])("refuses %s before or while it is read", async (name, change, message) => {
    const path = `${name.replaceAll(" ", "-")}.zarr`;
    writeJson(join(folder, path, ".zarray"), { ...zarray, ...change });
    const bytes = name.includes("inflates")
      ? gzipSync(new Uint8Array(10_000_000))
      : [1, 0, 2, 0, 3, 0];
    for (const x of [0, 1, 2])
      writeFileSync(join(folder, path, `0.0.${x}`), Uint8Array.from(bytes));
    const image = await openImage(host.url + path);
    await expect(voxelsOf(image, image.scales[0] as ZarrScale)).rejects.toThrow(message);
  });

  test("refuses groups that are not images, with a message", async () => {
    await expect(openImage(`${host.url}none.zarr`)).rejects.toThrow(
      "expected zarr.json, .zarray or .zgroup, found none of them: check the address",
    );
    const group = async (name: string, attributes: object) => {
      writeGroup(join(folder, name), 2, attributes);
      return openImage(host.url + name);
    };
    await expect(group("plate.zarr", { plate: {} })).rejects.toThrow("found a plate of images");
    await expect(group("group.zarr", {})).rejects.toThrow("a group without multiscales");
    const of = (change: object) => ({ multiscales: [{ ...image5d, ...change }] });
    await expect(group("sets.zarr", of({ datasets: "all" }))).rejects.toThrow(
      '1 to 64 datasets with paths in multiscales, found "all"',
    );
    await scales(2, "axes.zarr");
    await expect(group("axes.zarr", of({ axes: ["x"] }))).rejects.toThrow("expected 5 axes");
    await scales(2, "scale.zarr");
    const steps = [{ type: "scale", scale: [1, 1, 0, 1, 1] }];
    await expect(group("scale.zarr", of({ coordinateTransformations: steps }))).rejects.toThrow(
      "expected 5 positive numbers as scale, found [1,1,0,1,1]",
    );
    writeFileSync(join(folder, "group.zarr", ".zattrs"), "{");
    await expect(openImage(`${host.url}group.zarr`)).rejects.toThrow("metadata are not valid");
  });
});
