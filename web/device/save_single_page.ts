import { deviceErrorTexts } from "../texts/device_errors.ts";
import { fetchPageFile, pageFiles } from "./page_files.ts";

/** Maximum size of a store in a single page. Browsers read larger pages slowly, or refuse them. */
export const maxSinglePageStore = 300_000_000;

/** The store replaces this text in single.html, which the build makes. */
const mark = "<!-- store -->";
/**
 * Bytes of the store in one element: a multiple of 3, so that only the last element has base64
 * padding.
 */
const partBytes = 3 << 20;

/** The size of the page with a store of this size. */
export async function singlePageBytes(storeBytes: number): Promise<number> {
  const template = (await pageFiles()).find(({ name }) => name === "single.html");
  const parts = Math.ceil(storeBytes / partBytes);
  return (template?.bytes ?? 0) + 4 * Math.ceil(storeBytes / 3) + 100 * (parts + 1);
}

/**
 * Makes one HTML file with the viewer and the store, or the bundle of a scene. It opens from file://, without a
 * server, with this view (a query, as in the address). Rejects with an Error if the store is too large, or if the
 * template of the page cannot be read.
 */
export async function singlePage(store: Blob, name: string, view: string): Promise<Blob> {
  if (store.size > maxSinglePageStore) {
    const mb = (n: number) => `${Math.round(n / 1e6)} MB`;
    throw new Error(deviceErrorTexts.tooLargeForPage(mb(maxSinglePageStore), mb(store.size)));
  }
  const response = await fetchPageFile("single.html");
  const [before, after] = response.ok ? (await response.text()).split(mark) : [];
  if (before === undefined || after === undefined) {
    throw new Error(deviceErrorTexts.noPageFile("single.html", response.status));
  }
  const parts: (string | Blob)[] = [before];
  for (let at = 0; at < store.size; at += partBytes) {
    const piece = new Uint8Array(await store.slice(at, at + partBytes).arrayBuffer());
    // The browser may keep a Blob on disk.
    parts.push(new Blob([`<script type="text/plain" data-store>${base64(piece)}</script>\n`]));
  }
  parts.push(
    `<meta name="isosplat-name" content="${name.replace(/[^\w.-]/g, "")}">`,
    `<meta name="isosplat-view" content="${view.replace(/&/g, "&amp;").replace(/"/g, "&quot;")}">`,
    after,
  );
  return new Blob(parts, { type: "text/html" });
}

function base64(bytes: Uint8Array): string {
  let text = "";
  // The number of arguments of a call is limited.
  for (let at = 0; at < bytes.length; at += 0x6000) {
    text += btoa(String.fromCharCode(...bytes.subarray(at, at + 0x6000)));
  }
  return text;
}
