/**
 * Reads OME-Zarr images and Zarr arrays at addresses, in a worker. Nothing here is loaded until one is
 * opened.
 *
 *     const image = await openZarr("https://example.org/brain.zarr", signal);
 *     const { voxels } = await readZarr(image, image.scales[0], { signal, progress });
 */
export { openZarr, readZarr } from "./ask_worker.ts";
export { ZarrError } from "./image_axes.ts";
export type * from "./types.ts";
export { addressOfFolder, type FilesByPath } from "./zarr_files.ts";
