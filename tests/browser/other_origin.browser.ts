/**
 * A web page of another origin cannot read a local server, unless the operator lists its origin.
 */
import { createServer, type Server } from "node:http";
import type { AddressInfo } from "node:net";
import { expect, type Page, test } from "@playwright/test";
import { demoFolder, type RunningServer, serve } from "./support/server.ts";
import { settled } from "./support/view.ts";

let other: Server;
let otherOrigin: string;
let server: RunningServer;
let listing: RunningServer;

test.beforeAll(async () => {
  other = createServer((_request, response) =>
    response.setHeader("Content-Type", "text/html").end("<!doctype html><title>Other</title>"),
  );
  await new Promise<void>((resolve) => other.listen(0, "127.0.0.1", resolve));
  otherOrigin = `http://127.0.0.1:${(other.address() as AddressInfo).port}`;
  server = await serve([demoFolder]);
  listing = await serve([demoFolder], 0, ["--cors", otherOrigin]);
});

test.afterAll(async () => {
  other.close();
  await Promise.all([server.stop(), listing.stop()]);
});

/** The content of a URL that a page can read, by each method that pages have. */
function attempts(page: Page, url: string): Promise<Record<string, string>> {
  return page.evaluate(async (from) => {
    const found: Record<string, string> = {};
    const read = async (way: string, attempt: () => Promise<string>): Promise<void> => {
      try {
        found[way] = await attempt();
      } catch {
        found[way] = "";
      }
    };
    await read("fetch", async () => (await fetch(from)).text());
    await read("credentials", async () => (await fetch(from, { credentials: "include" })).text());
    await read("no-cors", async () => (await fetch(from, { mode: "no-cors" })).text());
    await read("XMLHttpRequest", async () => {
      const request = new XMLHttpRequest();
      request.open("GET", from, false);
      request.send();
      return request.responseText;
    });
    await read("frame", async () => {
      const frame = document.createElement("iframe");
      frame.src = from;
      document.body.append(frame);
      await new Promise((resolve) => frame.addEventListener("load", resolve));
      return frame.contentDocument?.body.textContent ?? "";
    });
    return found;
  }, url);
}

test("a page of another origin reads nothing of a local server", async ({ page }) => {
  await page.goto(otherOrigin);
  for (const path of ["v1/volumes", "v1/volumes/bucky", "v1/volumes/bucky/bootstrap", "healthz"]) {
    const found = await attempts(page, server.url + path);
    for (const [way, text] of Object.entries(found)) expect(text, `${way} ${path}`).toBe("");
    // If the operator lists the page's origin, the methods that use CORS can read it.
    const listed = await attempts(page, listing.url + path);
    expect(listed.fetch, path).not.toBe("");
    expect(listed.XMLHttpRequest, path).not.toBe("");
    expect(listed["no-cors"], path).toBe("");
    expect(listed.frame, path).toBe("");
  }
});

test("a page that reaches the server by a foreign host name reads nothing", async () => {
  const { request } = await import("node:http");
  const { port } = new URL(server.url);
  const status = await new Promise<number>((resolve, reject) => {
    const headers = { Host: `evil.example:${port}`, "Sec-Fetch-Site": "same-origin" };
    request({ port, path: "/v1/volumes", headers }, (answer) => resolve(answer.statusCode ?? 0))
      .on("error", reject)
      .end();
  });
  expect(status).toBe(403);
});

test("the page of the server itself reads the volume", async ({ page }) => {
  await page.goto(`${server.url}?volume=bucky`);
  await settled(page);
  await expect(page.getByRole("alert")).toHaveCount(0);
});
