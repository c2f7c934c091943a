/** A file of this page, as the build lists it in files.json. */
export interface PageFile {
  /** Relative to the page. */
  name: string;
  bytes: number;
}

/** The files that a copy of this page needs. Rejects with an Error without a built page. */
export async function pageFiles(): Promise<PageFile[]> {
  const response = await fetch("files.json");
  if (!response.ok) {
    throw new Error(
      `files.json: expected the list of this page's files, found status ${response.status}: ` +
        "load the page anew",
    );
  }
  return ((await response.json()) as { files: PageFile[] }).files;
}
