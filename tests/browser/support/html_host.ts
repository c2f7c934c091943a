import { createServer } from "node:http";

export interface HtmlHost {
  /**
   * Its port differs from the server's, so that script, worker and store are cross-origin for its
   * page.
   */
  readonly origin: string;
  stop(): void;
}

/** Serves one page at every path. `html` is called for each request. */
export async function htmlHost(html: () => string): Promise<HtmlHost> {
  const pages = createServer((_request, response) => {
    response.setHeader("Content-Type", "text/html");
    response.end(html());
  });
  await new Promise<void>((listening) => pages.listen(0, "127.0.0.1", listening));
  const address = pages.address();
  if (!address || typeof address === "string") throw new Error("no port");
  return { origin: `http://127.0.0.1:${address.port}/`, stop: () => pages.close() };
}
