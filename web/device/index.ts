/** Volumes on this device: files, building, keeping and saving stores. Nothing is uploaded. */
export * from "./fetch_file.ts";
export * from "./files.ts";
export * from "./handed_over.ts";
export * from "./kept_stores.ts";
export * from "./no_upload.ts";
export * from "./raw_guess.ts";
export * from "./reading.ts";
export * from "./remote_files.ts";
export * from "./zarr_volume.ts";
