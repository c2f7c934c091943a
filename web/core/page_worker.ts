let inheritsPolicy = false;

/**
 * From now on, workers have the Content-Security-Policy that the page has when they start. Otherwise
 * they have the one that their program was sent with: what the page was given later is not in it.
 */
export function startWorkersWithPagePolicy(): void {
  inheritsPolicy = true;
}

/**
 * The class of the page's workers. Their program may be of another origin than the page, as where a
 * script element names another host. Browsers allow only workers of the page's own origin, and let
 * those of a Blob inherit the page's policy: where one of these matters, a Blob imports the program.
 */
export function pageWorker(): typeof globalThis.Worker {
  return class extends globalThis.Worker {
    constructor(program: string | URL, options?: WorkerOptions) {
      const { href, origin, protocol } = new URL(program);
      // "null": the program is a Blob of a page that is a file.
      const isForeign =
        typeof location !== "undefined" && origin !== "null" && origin !== location.origin;
      const isImported = isForeign || (inheritsPolicy && protocol !== "blob:");
      const importer = () => {
        const text = `import ${JSON.stringify(href)};`;
        const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
        // The fragment names the program, for who looks at a page's workers.
        return `${address}#${href.slice(href.lastIndexOf("/") + 1)}`;
      };
      super(isImported ? importer() : program, options);
    }
  };
}
