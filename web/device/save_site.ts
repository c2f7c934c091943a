import { downloadZip, predictLength } from "client-zip";
import type { StoreInfo } from "../core/types.ts";
import { deviceErrorTexts } from "../texts/device_errors.ts";
import { fetchPageFile, type PageFile, pageFiles } from "./page_files.ts";

/** Estimated bytes of the other content of the ZIP: README, catalog, thumbnail, file names. */
const otherBytes = 40_000;

const catalogElements =
  '<meta name="isosplat-catalog" content="catalog.json">' +
  '<link rel="preload" as="fetch" href="catalog.json" crossorigin>';

const readme = `A web site with one volume, from Isosplat.

Unpack this archive into a folder of any web host that serves parts of files (HTTP Range requests):
nginx, Apache, Caddy, GitHub Pages, a bucket. Everyone who reaches the host can read it.

On this machine: npx http-server -o       in the folder. If the page is opened from a file manager,
browsers do not let it read the volume. Save a single page for this purpose instead.
`;

/** The approximate size of the ZIP for a store of this size, in bytes. */
export async function siteBytes(storeBytes: number): Promise<number> {
  const files = await pageFiles();
  const sizes = files.map(({ name, bytes }) => ({ name, size: bytes }));
  return Number(predictLength([...sizes, { name: "store", size: storeBytes }])) + otherBytes;
}

/**
 * A static site as a ZIP archive, in the layout of `isosplat publish`. Its files are not compressed,
 * since stores hardly compress.
 * `picture`: a data URL, or null. Rejects with an Error if a file of the page cannot be read.
 */
export async function siteZip(
  store: Blob,
  info: StoreInfo,
  name: string,
  picture: string | null,
): Promise<Blob> {
  const file = `stores/${name}-${info.contentId}.isosplat`;
  const entry = {
    name,
    file,
    contentId: info.contentId,
    fileBytes: info.fileBytes,
    voxels: info.voxels,
    spacing: info.spacing,
    range: info.range,
    levels: info.levels,
    title: info.metadata.title,
    units: info.metadata.units,
    type: info.metadata.source?.type,
    histogram: info.metadata.histogram,
    ...(picture && { thumbnail: `${file}.webp` }),
  };
  const catalog = `${JSON.stringify({ isosplat: "site 1", volumes: [entry] })}\n`;
  const parts = async function* () {
    yield { name: "README.txt", input: readme };
    for (const page of await pageFiles()) yield { name: page.name, input: await content(page) };
    yield { name: "catalog.json", input: catalog };
    yield { name: file, input: store };
    if (picture) yield { name: `${file}.webp`, input: await (await fetch(picture)).blob() };
  };
  return downloadZip(parts()).blob();
}

async function content({ name }: PageFile): Promise<Blob | string> {
  const response = await fetchPageFile(name);
  if (!response.ok) {
    throw new Error(deviceErrorTexts.noPageFile(name, response.status));
  }
  if (name !== "index.html") return response.blob();
  const html = await response.text();
  // A page that is itself part of a published site names a catalog already.
  return html.includes("isosplat-catalog")
    ? html
    : html.replace("<head>", `<head>${catalogElements}`);
}
