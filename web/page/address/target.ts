import type { SceneSource } from "../../scene/scene_source.ts";
import type { Source } from "../../stream/source.ts";

/** The beginning of the address of a store on this device, in `src=`; its content id follows. */
export const deviceAddress = "device:";

/** The content id in the address of a store on this device; undefined for other addresses. */
export function idOnDevice(src: string | undefined): string | undefined {
  return src?.startsWith(deviceAddress) ? src.slice(deviceAddress.length) : undefined;
}

/** The target of a volume page: a store or a scene of a server, of another host, or of this device. */
export type Target = StoreTarget | SceneTarget;

export interface SceneTarget {
  /** The scene's name or the last part of its URL. */
  name: string;
  /** The code that reads scenes is loaded for them alone. */
  scene: () => Promise<SceneSource>;
  provisional?: undefined;
}

export interface StoreTarget {
  /** The volume's name or the store's URL. */
  name: string;
  source: () => Source;
  /** A description for the visitor, if the store is provisional (shown_volume.ts). */
  provisional?: string;
}
