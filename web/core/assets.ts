/**
 * The files that the page fetches at run time: WebAssembly and the programs of workers. Their address
 * is `new URL("…", import.meta.url)`, an expression that bundlers replace by the address of their copy
 * of the file. If `setAssetBase` was called, they are in the folder that it names.
 */
let base: URL | undefined;

/**
 * Sets the folder of a copy of the package's `assets`, for bundlers that do not copy them: its address,
 * which may be relative to the page. Call it before the first volume is opened. undefined: the bundler
 * has copied the files.
 */
export function setAssetBase(url: string | URL | undefined): void {
  const page = typeof document === "undefined" ? undefined : document.baseURI;
  base = url === undefined ? undefined : new URL(`${url}`.replace(/\/*$/, "/"), page);
}

/** The address of a file in the folder of `setAssetBase`; undefined if it was not called. */
export function assetInBase(name: string): URL | undefined {
  return base && new URL(name, base);
}
