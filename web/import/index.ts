/**
 * Reads volume files in the browser, with the readers of the program `isosplat`. Nothing here is loaded
 * until a volume is to be read.
 *
 *     const volume = await openVolume([{ path: file.name, file }]);
 *     const { store, report } = await volume.build({ progress: ({ fraction }) => … });
 */
export { FileTable, type ReadBlob } from "./files.ts";
export { volumesAmong } from "./find_volumes.ts";
export { Importer } from "./importer.ts";
export { compileImport, type ImportFiles, instantiateImport } from "./module.ts";
export {
  type BuildOptions,
  findVolumes,
  type OpenedVolume,
  type OpenOptions,
  openVolume,
  type StoreOptions,
} from "./open_volume.ts";
export { type ReducedVolume, reducedVolume } from "./reduced_volume.ts";
export * from "./types.ts";
