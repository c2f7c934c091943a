import type { KeptStore } from "../../device/kept_stores.ts";
import { BlobSource } from "../../stream/blob_source.ts";
import type { Target } from "../address/target.ts";

/** The beginning of the address of a store on this device, in `src=`; its content id follows. */
export const deviceAddress = "device:";

export function deviceTarget({ name }: KeptStore, blob: Blob): Target {
  return { name, source: () => new BlobSource(blob, name) };
}
