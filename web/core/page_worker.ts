/**
 * Workers whose program may be of another origin than the page, as where a script element names
 * another host. Browsers allow only workers of the page's own origin; these may import the program.
 */
export function workerOfAnyOrigin(): typeof globalThis.Worker {
  return class extends globalThis.Worker {
    constructor(program: string | URL, options?: WorkerOptions) {
      const { href, origin } = new URL(program);
      // "null": the program is a Blob of a page that is a file.
      const isForeign =
        typeof location !== "undefined" && origin !== "null" && origin !== location.origin;
      const text = `import ${JSON.stringify(href)};`;
      const importer = () => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
      super(isForeign ? importer() : program, options);
    }
  };
}
