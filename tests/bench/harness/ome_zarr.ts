/** OME-Zarr 0.5 (Zarr 3): a volume of bytes in three scales, each half of the finer one, in chunks of 64³. */
import { gzipSync } from "node:zlib";

type Voxels = [x: number, y: number, z: number];

const chunkSide = 64;
const scales = 3;

/** Means of 2³ voxels. Odd remaining voxels are left out. */
function halved(values: Uint8Array, [x, y, z]: Voxels): { values: Uint8Array; voxels: Voxels } {
  const voxels: Voxels = [x >> 1, y >> 1, z >> 1];
  const [width, height, depth] = voxels;
  const out = new Uint8Array(width * height * depth);
  let to = 0;
  for (let k = 0; k < depth; ++k) {
    for (let j = 0; j < height; ++j) {
      for (let i = 0; i < width; ++i) {
        let sum = 0;
        for (let corner = 0; corner < 8; ++corner) {
          const plane = 2 * k + (corner >> 2);
          const row = 2 * j + ((corner >> 1) & 1);
          sum += values[(plane * y + row) * x + 2 * i + (corner & 1)] ?? 0;
        }
        out[to++] = Math.round(sum / 8);
      }
    }
  }
  return { values: out, voxels };
}

/** One chunk, with zeros beyond the volume's end. */
function chunkOf(values: Uint8Array, [x, y, z]: Voxels, begin: Voxels): Uint8Array {
  const chunk = new Uint8Array(chunkSide ** 3);
  const width = Math.min(chunkSide, x - begin[0]);
  for (let k = 0; k < chunkSide && begin[2] + k < z; ++k) {
    for (let j = 0; j < chunkSide && begin[1] + j < y; ++j) {
      const from = ((begin[2] + k) * y + begin[1] + j) * x + begin[0];
      chunk.set(values.subarray(from, from + width), (k * chunkSide + j) * chunkSide);
    }
  }
  return chunk;
}

function addScale(files: Map<string, Buffer>, folder: string, values: Uint8Array, voxels: Voxels) {
  const zyx = voxels.toReversed();
  const metadata = {
    zarr_format: 3,
    node_type: "array",
    shape: zyx,
    data_type: "uint8",
    chunk_grid: { name: "regular", configuration: { chunk_shape: zyx.map(() => chunkSide) } },
    chunk_key_encoding: { name: "default", configuration: { separator: "/" } },
    fill_value: 0,
    codecs: [
      { name: "bytes", configuration: { endian: "little" } },
      { name: "gzip", configuration: { level: 9 } },
    ],
    attributes: {},
    dimension_names: ["z", "y", "x"],
  };
  files.set(`${folder}/zarr.json`, Buffer.from(JSON.stringify(metadata)));
  const [x, y, z] = voxels;
  for (let k = 0; k < z; k += chunkSide) {
    for (let j = 0; j < y; j += chunkSide) {
      for (let i = 0; i < x; i += chunkSide) {
        const path = [k, j, i].map((begin) => begin / chunkSide).join("/");
        const chunk = chunkOf(values, voxels, [i, j, k]);
        files.set(`${folder}/c/${path}`, gzipSync(chunk, { level: 9 }));
      }
    }
  }
}

/** The files of NAME.zarr by their paths. */
export function omeZarr(
  name: string,
  values: Uint8Array,
  voxels: Voxels,
  spacing: number[],
): Map<string, Buffer> {
  const files = new Map<string, Buffer>();
  const datasets = Array.from({ length: scales }, (_, level) => ({
    path: String(level),
    coordinateTransformations: [
      { type: "scale", scale: spacing.map((each) => each * 2 ** level).reverse() },
    ],
  }));
  const axes = ["z", "y", "x"].map((axis) => ({ name: axis, type: "space" }));
  const ome = { version: "0.5", multiscales: [{ name, axes, datasets }] };
  const group = { zarr_format: 3, node_type: "group", attributes: { ome } };
  files.set(`${name}.zarr/zarr.json`, Buffer.from(JSON.stringify(group)));
  let scale = { values, voxels };
  for (let level = 0; level < scales; ++level) {
    if (level > 0) scale = halved(scale.values, scale.voxels);
    addScale(files, `${name}.zarr/${level}`, scale.values, scale.voxels);
  }
  return files;
}
