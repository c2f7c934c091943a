/** The Content-Security-Policy that the built page states is the one that the server sends. */
import { expect, test } from "vitest";
import { demoFolder, serve } from "../browser/support/server.ts";

test("the page and the server have the same policy", async () => {
  const server = await serve([demoFolder]);
  try {
    const response = await fetch(server.url);
    const [, stated] =
      /<meta http-equiv="Content-Security-Policy" content="([^"]*)"/.exec(await response.text()) ??
      [];
    expect(stated).toContain("default-src 'none'");
    expect(response.headers.get("content-security-policy")).toBe(stated);
  } finally {
    await server.stop();
  }
});
