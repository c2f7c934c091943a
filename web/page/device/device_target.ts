import type { KeptStore } from "../../device/kept_stores.ts";
import { BlobSource } from "../../stream/blob_source.ts";
import type { StoreTarget } from "../address/target.ts";

export function deviceTarget({ name }: KeptStore, blob: Blob): StoreTarget {
  return { name, source: () => new BlobSource(blob, name) };
}
