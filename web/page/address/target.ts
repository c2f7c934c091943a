import type { Source } from "../../stream/source.ts";

/** The beginning of the address of a store on this device, in `src=`; its content id follows. */
export const deviceAddress = "device:";

/** The target of a volume page: a store of a server, of another host, or of this device. */
export interface Target {
  /** The volume's name or the store's URL. */
  name: string;
  source: () => Source;
  /** Of a provisional store (shown_volume.ts): a description for the visitor. */
  provisional?: string;
}
