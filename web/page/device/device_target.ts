import type { KeptStore } from "../../device/kept_stores.ts";
import { BlobSource } from "../../stream/blob_source.ts";
import type { Target } from "../address/target.ts";

export function deviceTarget({ name }: KeptStore, blob: Blob): Target {
  return { name, source: () => new BlobSource(blob, name) };
}
