import { open, root } from "zarrita";
import { readScale } from "../../web/zarr/read_scale.ts";
import type { ZarrScale } from "../../web/zarr/types.ts";
import type { ZarrSource } from "../../web/zarr/zarr_files.ts";
import { valueAt, voxels } from "./zarr_variants.ts";

/** The expected voxels of a scale, from `valueAt`. */
export function expectedVoxels(): Uint16Array {
  const all = new Uint16Array(voxels[0] * voxels[1] * voxels[2]);
  let at = 0;
  for (let z = 0; z < voxels[2]; ++z) {
    for (let y = 0; y < voxels[1]; ++y) {
      for (let x = 0; x < voxels[0]; ++x) all[at++] = valueAt(x, y, z);
    }
  }
  return all;
}

/** The voxels (uint16) of a scale. `source.absent` counts its absent chunks. */
export async function readVoxels(source: ZarrSource, scale: ZarrScale): Promise<Uint16Array> {
  const array = await open(root(source).resolve(scale.path), { kind: "array" });
  source.absent = 0;
  const layers: Uint8Array[] = [];
  await readScale(
    array,
    scale,
    (layer) => layers.push(layer),
    () => {},
  );
  return new Uint16Array(new Uint8Array(Buffer.concat(layers)).buffer);
}
