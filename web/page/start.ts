import { StreamError } from "../stream/types.ts";
import { startTexts } from "../texts/start.ts";
import { addressIn } from "./address/open_target.ts";
import { idOnDevice } from "./address/target.ts";
import type { UrlState } from "./address/url_state.ts";
import { Catalog } from "./catalog/catalog.ts";
import { DeviceFiles } from "./device/device_files.ts";
import { loadPart } from "./shell/load_part.ts";
import { VolumePage } from "./volume/volume_page.ts";

/**
 * Shows everything except stores of a server or of another host: the start page, a store on this
 * device (`src=device:CONTENT-ID`), or a volume at a URL.
 */
export async function start(root: HTMLElement, { src, file }: UrlState): Promise<void> {
  const components = loadPart(() => import("./shell/components.ts"));
  const id = idOnDevice(src);
  const address = src !== undefined && id === undefined ? addressIn(src) : undefined;
  if (address) {
    const files = new DeviceFiles(root);
    new Catalog(root, files.section.element);
    void files.openAddress(address);
  } else if (src !== undefined && id === undefined) {
    new VolumePage(root, badAddress(src));
  } else {
    const files = new DeviceFiles(root);
    if (id === undefined || !(await files.openKept(id))) {
      if (id !== undefined) {
        files.section.expects(file);
      }
      new Catalog(root, files.section.element);
    }
  }
  await components;
}

function badAddress(src: string) {
  const message = startTexts.badAddress(src, "https://example.org/head.isosplat");
  return {
    name: src,
    source: () => {
      throw new StreamError("bad-address", message);
    },
  };
}
