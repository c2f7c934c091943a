/**
 * The files that the page fetches at run time: WebAssembly and the programs of workers. They lie where
 * `new URL("…", import.meta.url)` says, an expression that bundlers replace by the address at which they
 * have put the file; or in the folder that `setAssetBase` names.
 */
let base: URL | undefined;

/**
 * The folder of a copy of the package's `assets`, for bundlers that do not place them: its address, from
 * the page's. Call it before the first volume is opened. undefined: where the bundler has put the files.
 */
export function setAssetBase(url: string | URL | undefined): void {
  const page = typeof document === "undefined" ? undefined : document.baseURI;
  base = url === undefined ? undefined : new URL(`${url}`.replace(/\/*$/, "/"), page);
}

/** The address of a file in the folder of `setAssetBase`; undefined if it was not called. */
export function assetInBase(name: string): URL | undefined {
  return base && new URL(name, base);
}
