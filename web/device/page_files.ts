import { deviceErrorTexts } from "../texts/device_errors.ts";

/** A file of this page, as the build lists it in files.json. */
export interface PageFile {
  /** Relative to the page. */
  name: string;
  bytes: number;
}

/**
 * Fetches a file of this page. Rejects with an Error if there is no network and the file is not
 * kept on the device.
 */
export async function fetchPageFile(name: string): Promise<Response> {
  try {
    return await fetch(name);
  } catch {
    throw new Error(deviceErrorTexts.pageFileUnreachable(name));
  }
}

/** The files that a copy of this page needs. Rejects with an Error if the page was not built. */
export async function pageFiles(): Promise<PageFile[]> {
  const response = await fetchPageFile("files.json");
  if (!response.ok) {
    throw new Error(deviceErrorTexts.noPageFiles(response.status));
  }
  return ((await response.json()) as { files: PageFile[] }).files;
}
