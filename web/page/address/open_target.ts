import { servedPath } from "../../scene/scene_name.ts";
import { FileSource } from "../../stream/file_source.ts";
import { sourceAt } from "../../stream/source_at.ts";
import { sceneSource, volumeSource } from "../shell/site.ts";
import type { Target } from "./target.ts";
import type { UrlState } from "./url_state.ts";

/** The endings of URLs of volumes, which are not stores: see start.ts. */
const volumeEnding =
  /\.(nii|nrrd|nhdr|mha|mhd|hdr|vtk|vt[ir]|cube?|xsf|dx|dcm|dicom|raw|npy|npz|h5|hdf5|mg[hz]|mrc|map|rec|st|zip|tiff?)(\.gz)?$|\.zarr(\/|$)|\/(zarr\.json|\.z(attrs|array|group|metadata))$/i;

/**
 * The target of the page's address: a volume or a scene of its server or site, or a store or a scene on any
 * host. Undefined for everything else: see start.ts.
 */
export function openTarget({
  volume,
  scene,
  src,
}: Pick<UrlState, "volume" | "scene" | "src">): Target | undefined {
  if (volume !== undefined) return { name: volume, source: () => volumeSource(volume) };
  if (scene !== undefined) return { name: scene, scene: () => sceneSource(scene) };
  const given = src === undefined ? undefined : addressIn(src);
  const address = given && ofPage(given);
  if (!address || isOfVolume(address)) return undefined;
  if (/\.(json|isobundle)$/i.test(address.pathname) || servedPath.test(address.pathname)) {
    const open = async () => (await import("../../scene/scene_source.ts")).sceneAt(address.href);
    return { name: fileName(address), scene: open };
  }
  return {
    name: fileName(address),
    source: () => sourceAt(address) ?? new FileSource(address.href),
  };
}

/**
 * What the page of another server shows, if this is the address of one (`https://host/?volume=head`); otherwise the
 * address itself. A signed link keeps its signature.
 */
function ofPage(address: URL): URL {
  const { pathname, searchParams } = address;
  if (!/\/(index\.html)?$/.test(pathname)) return address;
  const src = searchParams.get("src");
  if (src !== null) return addressIn(src, address.href) ?? address;
  for (const kind of ["volume", "scene"]) {
    const name = searchParams.get(kind);
    if (name === null) continue;
    const shown = new URL(`v1/${kind}s/${encodeURIComponent(name)}`, address);
    for (const key of ["exp", "sig"]) {
      const value = searchParams.get(key);
      if (value !== null) shown.searchParams.set(key, value);
    }
    return shown;
  }
  return address;
}

/** Whether a URL refers to a volume, by its ending; otherwise it refers to a store. */
function isOfVolume({ pathname }: URL): boolean {
  return volumeEnding.test(pathname);
}

/** Undefined if the text is not a URL that can be fetched. */
export function addressIn(text: string, base = location.href): URL | undefined {
  try {
    const address = new URL(text, base);
    return /^https?:$/.test(address.protocol) ? address : undefined;
  } catch {
    return undefined;
  }
}

function fileName(address: URL): string {
  const name = address.pathname.slice(address.pathname.lastIndexOf("/") + 1);
  try {
    return decodeURIComponent(name) || address.href;
  } catch {
    return name; // a % that is not a valid escape
  }
}
